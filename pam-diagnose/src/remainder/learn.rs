//! The fit of a smooth correction.

use super::basis::{remembering, smooth};
use super::ground::{Drop, Ground, drop_by_blocks};
use crate::error::DiagnoseError;
use crate::fit::{Fit, Hypothesis};
use crate::search::Candidates;
use crate::terms::{Definition, Term, TermSpace};
use std::time::Instant;

/// A smooth correction with its terms.
#[derive(Debug, Clone)]
pub struct Learned {
    /// The terms with unit coefficients, by definition.
    pub(crate) terms: Vec<Vec<Term>>,
    /// Standard deviation of the prior of the coefficients, relative to the sizes of the places.
    pub deviation: f64,
    /// The fit to the training rows.
    pub(crate) fit: Fit,
    /// Cost on the validation rows.
    pub(crate) validation: f64,
    pub(crate) drop: Drop,
    pub(crate) chi: Vec<f64>,
    pub(crate) rows_per_observation: f64,
}

/// Standard deviations that are tried, in units of the sizes of the places.
const DEVIATIONS: [f64; 4] = [0.03, 0.1, 0.3, 0.01];

impl Learned {
    /// Whether nothing but noise is left.
    fn is_enough(&self) -> bool {
        self.drop.share > 0.99 || self.chi.iter().all(|c| *c < 1.5)
    }

    pub(crate) fn definitions<T: TermSpace>(&self, space: &T) -> Vec<Definition> {
        definitions(space, &self.terms, self.deviation)
    }

    /// The terms with their coefficients.
    pub(crate) fn fitted_terms(&self, hypothesis: &Hypothesis) -> Vec<Term> {
        let members = &hypothesis.members[hypothesis.members.len() - self.terms.len()..];
        let all = self.terms.iter().zip(members).flat_map(|(terms, m)| terms.iter().zip(&m.values));
        all.map(|(t, c)| Term { coefficient: c * t.coefficient, ..t.clone() }).collect()
    }
}

fn definitions<T: TermSpace>(space: &T, terms: &[Vec<Term>], deviation: f64) -> Vec<Definition> {
    let of = |(k, terms): (usize, &Vec<Term>)| {
        let id = format!("correction{}", k + 1);
        Definition::flexible(&id, terms, deviation, space.variables(), space.places())
    };
    terms.iter().enumerate().map(of).collect()
}

pub(crate) fn learn<T: TermSpace>(
    space: &T,
    ground: &Ground<'_>,
) -> Result<Option<Learned>, DiagnoseError> {
    let mut families: Vec<usize> = space.places().iter().map(|p| p.family).collect();
    families.sort_unstable();
    families.dedup();
    let mut best: Option<(usize, Learned)> = None;
    for &family in &families {
        let terms = vec![smooth(family, space.variables(), space.places())];
        let found = fitted(space, ground, &terms, DEVIATIONS[0], None, 4)?;
        if let Some(found) = found
            && best.as_ref().is_none_or(|(_, b)| found.validation < b.validation)
        {
            best = Some((family, found));
        }
    }
    let Some((family, mut best)) = best else { return Ok(None) };
    for deviation in &DEVIATIONS[1..] {
        if let Some(found) = fitted(space, ground, &best.terms, *deviation, Some(&best), 3)?
            && found.validation < best.validation
        {
            best = found;
        }
    }
    let more = remembering(family, space.variables(), space.places());
    if !more.is_empty() && !best.is_enough() {
        let terms = [best.terms.clone(), vec![more]].concat();
        if let Some(found) = fitted(space, ground, &terms, best.deviation, Some(&best), 4)? {
            if found.validation < best.validation {
                best = found;
            }
        }
    }
    for &other in families.iter().filter(|f| **f != family) {
        if best.is_enough() {
            break;
        }
        let terms =
            [best.terms.clone(), vec![smooth(other, space.variables(), space.places())]].concat();
        if let Some(found) = fitted(space, ground, &terms, best.deviation, Some(&best), 3)? {
            if found.validation < best.validation - 10.0 {
                best = found;
            }
        }
    }
    Ok(Some(best))
}

fn fitted<T: TermSpace>(
    space: &T,
    ground: &Ground<'_>,
    terms: &[Vec<Term>],
    deviation: f64,
    from: Option<&Learned>,
    iterations: usize,
) -> Result<Option<Learned>, DiagnoseError> {
    let clock = Instant::now();
    let found = space.with(&definitions(space, terms, deviation), |system| {
        let start = ground.start(system);
        let Some(rows) = ground.rows(system, &start) else { return Ok(None) };
        let train = &rows.choosing.train;
        let base = Hypothesis { members: start.members.clone(), ..train.base() };
        let mut h = base.clone();
        let old = from.map(|f| (&f.fit.hypothesis.members[start.members.len()..], &f.fit.hypothesis));
        if let Some((_, hypothesis)) = old {
            h.members = hypothesis.members[..start.members.len()].to_vec();
            (h.shared, h.locals) = (hypothesis.shared.clone(), hypothesis.locals.clone());
        }
        for (k, terms) in terms.iter().enumerate() {
            let known = old.and_then(|(members, _)| members.get(k)).map(|m| m.values.clone());
            h = h.with(ground.listed + k, &known.unwrap_or_else(|| vec![0.0; terms.len()]));
        }
        let Ok(fit) = train.fit_to(h, iterations, 1.0) else { return Ok(None) };
        let Ok(errors) = rows.choosing.validation_errors(&fit.hypothesis) else {
            return Ok(None);
        };
        // Named causes alone, as well as they can be.
        let base = train.fit_to(base, 3, 1.0)?;
        let before = rows.choosing.validation_errors(&base.hypothesis)?;
        let rpo = train.rows_per_observation;
        let validation = errors.rows as f64 / rpo * errors.deviance();
        let drop = drop_by_blocks(
            &rows.choosing.validation,
            &rows.choosing.on_validation(&base.hypothesis),
            &rows.choosing.on_validation(&fit.hypothesis),
        )?;
        let left = train.correlated_rows(&fit.hypothesis)?;
        eprintln!(
            "  {:?} {deviation}: base {:.1} train {:.1} chi {:.2?} validation {validation:.1} {:.2?} drop {:.3} p {:.1e} rpo {rpo:.1} -> {left:.1} {:.2} s",
            terms.iter().map(|t| (t[0].place, t.len())).collect::<Vec<_>>(),
            before.rows as f64 / rpo * before.deviance(),
            fit.cost,
            fit.errors.mean(),
            errors.mean(),
            drop.share, drop.p_value,
            clock.elapsed().as_secs_f64()
        );
        Ok(Some(Learned {
            terms: terms.to_vec(),
            deviation,
            fit,
            validation,
            chi: errors.mean(),
            drop,
            rows_per_observation: left,
        }))
    })?;
    Ok(found)
}
