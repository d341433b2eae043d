//! The fit of a smooth correction.

use super::basis::{remembering, smooth, waves};
use super::ground::{Drop, Ground, drop_by_blocks};
use super::lines::periods_s;
use crate::error::DiagnoseError;
use crate::fit::{ChannelErrors, Hypothesis, Member};
use crate::law::{Data, Design, Scores};
use crate::terms::{Definition, Place, Term, TermSpace, Variable, grouped};
use pam_core::parallel;
use std::sync::{Mutex, PoisonError};

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
    evidence: f64,
    /// Cost on the training rows.
    train: f64,
    /// Cost on the validation rows.
    validation: f64,
    /// Mean whitened squares of the validation rows.
    chi: Vec<f64>,
    /// Minus two times their log-likelihood per row.
    pub(crate) deviance: f64,
    /// Rows that were one observation.
    rows_per_observation: f64,
}

/// Share of the rows of an observation below which corrections are fitted again with what the best of them leaves.
const FEWER_ROWS: f64 = 0.8;
/// Most times that they are.
const AGAIN: usize = 3;
/// Drop of the validation cost that an addition to a correction must bring.
const WORTH: f64 = 10.0;
/// Drop of the validation cost that is no chance: odds of ten nats.
const EVIDENCE: f64 = 20.0;

impl Learned {
    /// What the system is asked to add.
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

    /// Whether the validation rows have learned something: a notable share of their squared error is gone, and that is no chance,
    /// by the scatter between blocks of time or by their likelihood, which does not need the error to be everywhere.
    pub(crate) fn is_learned(&self, ground: &Ground<'_>) -> bool {
        let settings = &ground.settings.remainder;
        let (drop, probability) = (&self.drop, settings.learned_probability);
        drop.share > settings.learned_share
            && (drop.p_value < probability || self.evidence > EVIDENCE)
    }

    /// The periods of what it repeats in time, s.
    fn periods_s(&self, variables: &[Variable]) -> Vec<f64> {
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
    fn periods_left_s(
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
    fn correlated_rows(
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
    fn is_enough(&self, ground: &Ground<'_>) -> bool {
        let settings = &ground.settings.remainder;
        let most = settings.nothing_ratio.powi(2);
        self.drop.share > settings.enough_share || self.chi.iter().all(|c| *c < most)
    }
}

/// The named causes alone, with which every correction is compared.
struct Before<'a> {
    ground: &'a Ground<'a>,
    /// Fitted to the training rows.
    hypothesis: Hypothesis,
    /// Errors of the validation rows.
    errors: ChannelErrors,
    /// Rows that count as one observation: as many as the residual of the causes is correlated over, or that of a correction
    /// if one is known.
    rows_per_observation: f64,
}

impl<'a> Before<'a> {
    /// `None` if they cannot be simulated.
    fn of(space: &dyn TermSpace, ground: &'a Ground<'a>) -> Result<Option<Self>, DiagnoseError> {
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

fn definitions(space: &dyn TermSpace, terms: &[Vec<Term>], deviation: f64) -> Vec<Definition> {
    let of = |(k, terms): (usize, &Vec<Term>)| {
        let id = format!("learned_correction_{}", k + 1);
        Definition::flexible(&id, terms, deviation, space.variables(), space.places())
    };
    terms.iter().enumerate().map(of).collect()
}

/// Most terms of a correction that is cut down.
const MOST_TERMS: usize = 14;
/// Families whose correction is cut down before one of them is chosen.
const CUT_DOWN: usize = 2;
/// Sums that are followed while it is.
const BEAM: usize = 3;

/// The correction without the terms that it does not need on the training rows, if the validation rows do not need them either:
/// it is known better where there are no data, and takes less time.
fn sparse(
    space: &dyn TermSpace,
    before: &Before<'_>,
    dense: Learned,
) -> Result<Learned, DiagnoseError> {
    let ground = before.ground;
    let kept: Vec<usize> = space.with(&dense.definitions(space), |system| {
        let Some(rows) = ground.rows(system, &ground.start(system)) else { return Ok(Vec::new()) };
        let train = &rows.choosing.train;
        let count: usize = dense.terms.iter().map(Vec::len).sum();
        let design = Design::at(train, &dense.hypothesis)?;
        let named = design.own.len() - count;
        let design = design.beside(named);
        let columns = design.own.clone();
        let scores = Scores {
            design: &design,
            rows_per_observation: train.correlated_rows(&dense.hypothesis)?,
            least: train.errors(&dense.hypothesis)?.mean(),
        };
        let all = scores.beam(&columns, &vec![0.0; count], MOST_TERMS, BEAM);
        Ok(all.into_iter().next().map_or_else(Vec::new, |s| s.columns))
    })?;
    if kept.is_empty() {
        return Ok(dense);
    }
    let (mut terms, mut members, mut first) = (Vec::new(), Vec::new(), 0);
    let (named, own) = dense.hypothesis.members.split_at(ground.named.len());
    for (all, member) in dense.terms.iter().zip(own) {
        let here = |k: &usize| (first..first + all.len()).contains(k);
        let of: Vec<usize> = kept.iter().copied().filter(here).map(|k| k - first).collect();
        first += all.len();
        if !of.is_empty() {
            terms.push(of.iter().map(|&k| all[k].clone()).collect::<Vec<Term>>());
            members.push(of.iter().map(|&k| member.values[k]).collect::<Vec<f64>>());
        }
    }
    let members = members
        .into_iter()
        .enumerate()
        .map(|(k, values)| Member::always(ground.listed + k, &values));
    let members = named.iter().cloned().chain(members).collect();
    let start =
        Learned { hypothesis: Hypothesis { members, ..dense.hypothesis.clone() }, ..dense.clone() };
    let iterations = 2 * ground.settings.remainder.iterations;
    let found = fitted(space, before, &terms, dense.deviation, Some(&start), iterations)?;
    Ok(found.filter(|f| f.validation < dense.validation + WORTH).unwrap_or(dense))
}

/// Learns a correction: at the places where it removes most of the error of the validation rows, with the prior that does, and
/// with memory or at further places where that is worth it. `None` if there is nothing to learn.
pub(crate) fn learn(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    done: &(dyn Fn(f64) + Sync),
) -> Result<Option<Learned>, DiagnoseError> {
    let (variables, places) = (space.variables(), space.places());
    let Some(mut before) = Before::of(space, ground)? else { return Ok(None) };
    let mut families: Vec<usize> = places.iter().map(|p| p.family).collect();
    families.sort_unstable();
    families.dedup();
    let mut alone = each_family(space, &before, &families, &|share| done(0.3 * share))?;
    // A slow error is few observations beside the causes, and many beside what explains it.
    for _ in 0..AGAIN {
        let best = alone.iter().min_by(|a, b| a.1.validation.total_cmp(&b.1.validation));
        let Some((_, best)) = best else { break };
        let rows = best.correlated_rows(space, ground)?;
        if rows > FEWER_ROWS * before.rows_per_observation {
            break;
        }
        before.rows_per_observation = rows;
        alone = each_family(space, &before, &families, &|share| done(0.3 + 0.3 * share))?;
    }
    let before = &before;
    // What the validation rows confirm comes before what is a little more probable and confirmed by none.
    let rank = |found: &Learned| (!found.is_learned(ground), found.validation);
    let best = alone.iter().min_by(|a, b| {
        let ((a, cost_a), (b, cost_b)) = (rank(&a.1), rank(&b.1));
        a.cmp(&b).then(cost_a.total_cmp(&cost_b))
    });
    let Some((family, mut best)) = best.cloned() else { return Ok(None) };
    best = with_best_deviation(space, before, best)?;
    best = sparse(space, before, best)?;
    done(0.8);
    // What remembers or repeats may be all that there is: then no smooth terms tell where it acts.
    let mut others = alone.iter().filter(|(k, _)| *k != family && !best.is_learned(ground));
    let rich = |k: usize| places.iter().any(|p| p.family == k && p.rich);
    let starts: Vec<(usize, Learned)> = [(family, best.clone())]
        .into_iter()
        .chain(others.find(|(k, _)| rich(*k)).cloned())
        .collect();
    let mut family = family;
    for (own, start) in starts {
        if start.is_enough(ground) {
            continue;
        }
        let mut more = remembering(own, variables, places);
        more.extend(waves(own, variables, places, &start.periods_left_s(space, ground)?));
        if more.is_empty() {
            continue;
        }
        let found = grown(space, before, start, more)?;
        if (!found.is_learned(ground), found.validation)
            < (!best.is_learned(ground), best.validation)
        {
            (family, best) = (own, found);
        }
    }
    done(0.9);
    for (other, found) in &alone {
        // Only what helps by itself helps beside something else.
        let helps = found.is_learned(ground);
        if *other == family || !helps || best.is_enough(ground) {
            continue;
        }
        best = grown(space, before, best, smooth(*other, variables, places))?;
    }
    done(1.0);
    Ok(best.is_learned(ground).then_some(best))
}

/// The correction at the places of each family alone, those that leave least of the training rows first and cut down.
fn each_family(
    space: &dyn TermSpace,
    before: &Before<'_>,
    families: &[usize],
    done: &(dyn Fn(f64) + Sync),
) -> Result<Vec<(usize, Learned)>, DiagnoseError> {
    let settings = &before.ground.settings.remainder;
    let finished = Mutex::new(0);
    let each: Result<Vec<Option<Learned>>, DiagnoseError> = parallel::map(families.len(), |k| {
        let terms = smooth_of(families[k], space);
        let (deviation, iterations) = (settings.deviations[0], settings.iterations);
        let found = fitted(space, before, &terms, deviation, None, iterations);
        // Reported under the lock, so that progress never goes back.
        let mut finished = finished.lock().unwrap_or_else(PoisonError::into_inner);
        *finished += 1;
        done(f64::from(*finished) / families.len() as f64);
        found
    })
    .into_iter()
    .collect();
    let found = families.iter().zip(each?);
    let mut alone: Vec<(usize, Learned)> =
        found.filter_map(|(family, found)| Some((*family, found?))).collect();
    // Many terms that remove the error of the training rows may go astray in validation rows that reach further: what removes
    // most there is judged by the few terms that do it as well.
    alone.sort_by(|a, b| a.1.train.total_cmp(&b.1.train));
    let cut =
        parallel::map(alone.len().min(CUT_DOWN), |k| sparse(space, before, alone[k].1.clone()));
    for ((_, found), few) in alone.iter_mut().zip(cut) {
        *found = few?;
    }
    Ok(alone)
}

/// A correction with the standard deviation of the prior that suits the validation rows best: from the one that it has, wider and
/// wider ones as long as that is better, else narrower ones.
fn with_best_deviation(
    space: &dyn TermSpace,
    before: &Before<'_>,
    mut best: Learned,
) -> Result<Learned, DiagnoseError> {
    let settings = &before.ground.settings.remainder;
    let first = best.deviation;
    let mut wider: Vec<f64> = settings.deviations.into_iter().filter(|d| *d > first).collect();
    let mut narrower: Vec<f64> = settings.deviations.into_iter().filter(|d| *d < first).collect();
    wider.sort_by(f64::total_cmp);
    narrower.sort_by(|a, b| b.total_cmp(a));
    for direction in [wider, narrower] {
        for deviation in direction {
            let found =
                fitted(space, before, &best.terms, deviation, Some(&best), settings.iterations)?;
            match found.filter(|f| f.validation < best.validation) {
                Some(better) => best = better,
                None => break,
            }
        }
        if best.deviation != first {
            break;
        }
    }
    Ok(best)
}

/// A correction with the few of some further terms that do most about what it leaves of the training rows, to first order; as it
/// was where the validation rows do not need them.
fn grown(
    space: &dyn TermSpace,
    before: &Before<'_>,
    best: Learned,
    more: Vec<Term>,
) -> Result<Learned, DiagnoseError> {
    let ground = before.ground;
    let blocks: Vec<Vec<Term>> = grouped(&more).map(<[Term]>::to_vec).collect();
    let all = [best.terms.clone(), blocks.clone()].concat();
    let kept: Vec<usize> = space.with(&definitions(space, &all, best.deviation), |system| {
        let Some(rows) = ground.rows(system, &ground.start(system)) else { return Ok(Vec::new()) };
        let train = &rows.choosing.train;
        let first = ground.listed + best.terms.len();
        let with = blocks.iter().enumerate().fold(best.hypothesis.clone(), |h, (k, block)| {
            h.with(first + k, &vec![0.0; block.len()])
        });
        let design = Design::at(train, &with)?;
        let first = design.own.len() - more.len();
        let design = design.beside(first);
        let columns = design.own.clone();
        let scores = Scores {
            design: &design,
            rows_per_observation: train.correlated_rows(&best.hypothesis)?,
            least: train.errors(&best.hypothesis)?.mean(),
        };
        let sums = scores.beam(&columns, &vec![0.0; more.len()], MOST_TERMS, BEAM);
        Ok(sums.into_iter().next().map_or_else(Vec::new, |s| s.columns))
    })?;
    if kept.is_empty() {
        return Ok(best);
    }
    let terms = kept.iter().map(|&k| more[k].clone()).collect();
    let terms = [best.terms.clone(), vec![terms]].concat();
    let iterations = ground.settings.remainder.iterations;
    let found = fitted(space, before, &terms, best.deviation, Some(&best), iterations)?;
    match found.filter(|f| f.validation < best.validation - WORTH) {
        Some(found) => sparse(space, before, found),
        None => Ok(best),
    }
}

fn smooth_of(family: usize, space: &dyn TermSpace) -> Vec<Vec<Term>> {
    vec![smooth(family, space.variables(), space.places())]
}

/// A correction at the same places beside fewer named causes, with what those were.
pub(crate) fn learn_again(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    known: &Learned,
) -> Result<Option<Learned>, DiagnoseError> {
    let (variables, places) = (space.variables(), space.places());
    let Some(mut before) = Before::of(space, ground)? else { return Ok(None) };
    before.rows_per_observation = before.rows_per_observation.min(known.rows_per_observation);
    let before = &before;
    let families = known.families(places);
    let terms =
        families.iter().map(|&family| smooth(family, variables, places)).collect::<Vec<_>>();
    let iterations = ground.settings.remainder.iterations;
    let Some(dense) = fitted(space, before, &terms, known.deviation, None, iterations)? else {
        return Ok(None);
    };
    let mut found = sparse(space, before, dense)?;
    for &family in &families {
        let mut more = remembering(family, variables, places);
        more.extend(waves(family, variables, places, &known.periods_s(variables)));
        let held = known.terms.iter().flatten().any(|t| more.contains(t));
        if held {
            found = grown(space, before, found, more)?;
        }
    }
    Ok(Some(found))
}

/// Fits terms to the training rows beside the named causes, from another correction on if one is given; `None` if they cannot
/// be simulated.
fn fitted(
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
