//! A correction that was fitted, and what it is compared with.

use super::basis::waves;
use super::ground::{Drop, Ground, drop_by_blocks};
use super::lines::periods_s;
use crate::error::DiagnoseError;
use crate::fit::{ChannelErrors, Hypothesis, Member};
use crate::law::Data;
use crate::terms::{Definition, Place, Term, TermSpace, Variable};

/// A smooth correction as it was fitted to the training rows.
#[derive(Debug, Clone)]
pub(crate) struct Learned {
    /// Its terms with unit coefficients, by the effects that hold them.
    pub(crate) terms: Vec<Vec<Term>>,
    /// Standard deviation of the prior of the coefficients, relative to the sizes of the places.
    pub(crate) deviation: f64,
    /// Named causes, then the coefficients, fitted to the training rows.
    pub(crate) hypothesis: Hypothesis,
    /// Drop of the error of the validation rows from the named causes alone.
    pub(crate) drop: Drop,
    /// Drop of the cost of the validation rows.
    pub(super) evidence: f64,
    /// Cost on the training rows.
    pub(super) train: f64,
    /// Cost on the validation rows.
    pub(super) validation: f64,
    /// Mean whitened squares of the validation rows.
    pub(super) chi: Vec<f64>,
    /// Minus two times their log-likelihood per row.
    pub(crate) deviance: f64,
    /// Rows that were one observation.
    pub(super) rows_per_observation: f64,
}

impl Learned {
    /// The definitions of its terms.
    pub(crate) fn definitions(&self, space: &dyn TermSpace) -> Vec<Definition> {
        definitions(space, &self.terms, self.deviation)
    }

    /// The same with the times of the causes in all recordings, where it was learned from pieces of them.
    pub(crate) fn in_whole(&self, data: &Data<'_>) -> Self {
        let members = data.in_whole(&self.hypothesis.members);
        Self { hypothesis: Hypothesis { members, ..self.hypothesis.clone() }, ..self.clone() }
    }

    /// The families of places at which it acts.
    pub(crate) fn families(&self, places: &[Place]) -> Vec<usize> {
        let mut all: Vec<usize> =
            self.terms.iter().flatten().map(|t| places[t.place].family).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// The terms with the coefficients of a fitted hypothesis.
    pub(crate) fn fitted(&self, hypothesis: &Hypothesis) -> Vec<Term> {
        let members = &hypothesis.members[hypothesis.members.len() - self.terms.len()..];
        let all = self.terms.iter().zip(members).flat_map(|(terms, m)| terms.iter().zip(&m.values));
        all.map(|(t, c)| Term { coefficient: c * t.coefficient, ..t.clone() }).collect()
    }

    /// Whether the correction generalises: it removes a notable share of the squared error of the validation rows, and not by chance,
    /// by the scatter between blocks of time or by their likelihood, which does not need the error to be everywhere.
    pub(crate) fn is_learned(&self, ground: &Ground<'_>) -> bool {
        let settings = &ground.settings.remainder;
        let (drop, probability) = (&self.drop, settings.learned_probability);
        drop.share > settings.learned_share
            && (drop.p_value < probability || self.evidence > settings.clear_evidence)
    }

    /// The periods of what it repeats in time, s.
    pub(super) fn periods_s(&self, variables: &[Variable]) -> Vec<f64> {
        let waves = self.terms.iter().flatten().filter(|t| t.repeats_in_time(variables));
        let mut all: Vec<f64> = waves.flat_map(|t| t.factors.iter().map(|f| f.scale)).collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    }

    /// The waves of its periods at its places.
    pub(crate) fn waves(&self, space: &dyn TermSpace) -> Vec<Term> {
        let (variables, places) = (space.variables(), space.places());
        let periods_s = self.periods_s(variables);
        let of = |family: usize| waves(family, variables, places, &periods_s);
        self.families(places).into_iter().flat_map(of).collect()
    }

    /// The strongest periods of what it leaves of the training rows, s; none where it cannot be simulated.
    pub(super) fn periods_left_s(
        &self,
        space: &dyn TermSpace,
        ground: &Ground<'_>,
    ) -> Result<Vec<f64>, DiagnoseError> {
        space.with(&self.definitions(space), |system| {
            let Some(rows) = ground.rows(system, &ground.start(system)) else {
                return Ok(Vec::new());
            };
            periods_s(&rows.choosing.train, &self.hypothesis)
        })
    }

    /// Rows over which what it leaves is correlated, of validation rows if these are more: it was not fitted to them.
    pub(super) fn correlated_rows(
        &self,
        space: &dyn TermSpace,
        ground: &Ground<'_>,
    ) -> Result<f64, DiagnoseError> {
        space.with(&self.definitions(space), |system| {
            let Some(rows) = ground.rows(system, &ground.start(system)) else {
                return Ok(f64::INFINITY);
            };
            let choosing = &rows.choosing;
            let validated = choosing.on_validation(&self.hypothesis);
            let validated = choosing.validation.correlated_rows(&validated)?;
            Ok(choosing.train.correlated_rows(&self.hypothesis)?.max(validated))
        })
    }

    /// Whether next to nothing but noise is left.
    pub(super) fn is_enough(&self, ground: &Ground<'_>) -> bool {
        let settings = &ground.settings.remainder;
        let most = settings.nothing_ratio.powi(2);
        self.drop.share > settings.enough_share || self.chi.iter().all(|c| *c < most)
    }
}

/// The named causes alone, with which every correction is compared.
pub(super) struct Before<'a> {
    pub(super) ground: &'a Ground<'a>,
    /// Fitted to the training rows.
    hypothesis: Hypothesis,
    /// Errors of the validation rows.
    errors: ChannelErrors,
    /// Rows that count as one observation: as many as the residual of the causes is correlated over, or that of a correction
    /// if one is known.
    pub(super) rows_per_observation: f64,
}

impl<'a> Before<'a> {
    /// `None` if they cannot be simulated.
    pub(super) fn of(
        space: &dyn TermSpace,
        ground: &'a Ground<'a>,
    ) -> Result<Option<Self>, DiagnoseError> {
        let iterations = ground.settings.remainder.iterations;
        let converged = ground.settings.search.converged_drop;
        space.with(&[], |system| {
            let Some(rows) = ground.rows(system, &ground.start(system)) else { return Ok(None) };
            let train = &rows.choosing.train;
            let base = Hypothesis { members: ground.named.clone(), ..train.base() };
            let hypothesis = train.fit_to(base, iterations, converged)?.hypothesis;
            let errors = rows.choosing.validation_errors(&hypothesis)?;
            let rows_per_observation = train.rows_per_observation;
            Ok(Some(Self { ground, hypothesis, errors, rows_per_observation }))
        })
    }
}

/// Errors of the validation rows with the named causes alone; `None` if they cannot be simulated.
pub(crate) fn validation_errors(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
) -> Result<Option<ChannelErrors>, DiagnoseError> {
    Ok(Before::of(space, ground)?.map(|before| before.errors))
}

pub(super) fn definitions(
    space: &dyn TermSpace,
    terms: &[Vec<Term>],
    deviation: f64,
) -> Vec<Definition> {
    let of = |(k, terms): (usize, &Vec<Term>)| {
        let id = format!("learned_correction_{}", k + 1);
        Definition::flexible(&id, terms, deviation, space.variables(), space.places())
    };
    terms.iter().enumerate().map(of).collect()
}

/// Fits terms to the training rows beside the named causes, from another correction on if one is given; `None` if they cannot
/// be simulated.
pub(super) fn fitted(
    space: &dyn TermSpace,
    before: &Before<'_>,
    terms: &[Vec<Term>],
    deviation: f64,
    from: Option<&Learned>,
    iterations: usize,
) -> Result<Option<Learned>, DiagnoseError> {
    let ground = before.ground;
    let converged = ground.settings.search.converged_drop;
    space.with(&definitions(space, terms, deviation), |system| {
        let start = ground.start(system);
        let Some(mut rows) = ground.rows(system, &start) else { return Ok(None) };
        rows.set_rows_per_observation(before.rows_per_observation);
        let train = &rows.choosing.train;
        let named = ground.named.len();
        let (mut h, known): (Hypothesis, &[Member]) = match from {
            Some(from) => {
                let (named, known) = from.hypothesis.members.split_at(named);
                (Hypothesis { members: named.to_vec(), ..from.hypothesis.clone() }, known)
            }
            None => (Hypothesis { members: ground.named.clone(), ..train.base() }, &[]),
        };
        for (k, terms) in terms.iter().enumerate() {
            let values = known.get(k).map_or_else(|| vec![0.0; terms.len()], |m| m.values.clone());
            h = h.with(ground.listed + k, &values);
        }
        let Ok(fit) = train.fit_to(h, iterations, converged) else { return Ok(None) };
        let Ok(errors) = rows.choosing.validation_errors(&fit.hypothesis) else {
            return Ok(None);
        };
        let cost = |e: &ChannelErrors| e.rows as f64 / train.rows_per_observation * e.deviance();
        let drop = drop_by_blocks(
            &rows.choosing.validation,
            &rows.choosing.on_validation(&before.hypothesis),
            &rows.choosing.on_validation(&fit.hypothesis),
        )?;
        Ok(Some(Learned {
            terms: terms.to_vec(),
            deviation,
            hypothesis: fit.hypothesis,
            drop,
            evidence: cost(&before.errors) - cost(&errors),
            train: fit.cost,
            validation: cost(&errors),
            chi: errors.mean(),
            deviance: errors.deviance(),
            rows_per_observation: before.rows_per_observation,
        }))
    })
}
