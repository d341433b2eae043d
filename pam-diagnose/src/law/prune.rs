//! Removal of terms that the data do not support.

use super::find::{About, diverges};
use super::refine::Tried;
use crate::error::DiagnoseError;
use crate::fit::{Fit, Hypothesis, Problem};
use crate::remainder::{Dyn, Ground};
use crate::terms::{Definition, Term, TermSpace};

/// Backward elimination on training and validation data: a term whose coefficient has a 95 % interval that contains zero is removed
/// if the rest, fitted again, is at least as probable; then the next one. Laws that cannot be simulated are skipped.
pub(super) fn pruned(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    about: &About,
    law: Tried,
) -> Tried {
    let mut law = law;
    if law.terms.len() == 1 {
        return law;
    }
    let Ok(mut whole) = Fitted::of(space, ground, about, &law) else { return law };
    while law.terms.len() > 1 {
        let shorter = whole.doubtful.iter().find_map(|&k| {
            let less = without(space, &law, k);
            let fitted = Fitted::of(space, ground, about, &less).ok()?;
            (fitted.total <= whole.total).then_some((less, fitted))
        });
        let Some((less, fitted)) = shorter else { break };
        law = less;
        (law.terms, law.values) = (fitted.terms.clone(), fitted.values.clone());
        whole = fitted;
    }
    law
}

/// A law without one of its terms.
fn without(space: &dyn TermSpace, law: &Tried, term: usize) -> Tried {
    let mut less = law.clone();
    let gone = less.terms.remove(term);
    less.length -= gone.description_length(space.variables(), space.places());
    let kept = Definition::law("law", "", &less.terms, space.variables(), space.places());
    less.values = kept.parameters.iter().map(|p| p.start).collect();
    less
}

/// A law as it is fitted to training and validation data.
struct Fitted {
    terms: Vec<Term>,
    values: Vec<f64>,
    /// Terms whose coefficient may be zero, the least certain first.
    doubtful: Vec<usize>,
    /// Minus two times the logarithm of its posterior probability, up to a constant that laws share.
    total: f64,
}

impl Fitted {
    fn of(
        space: &dyn TermSpace,
        ground: &Ground<'_>,
        about: &About,
        law: &Tried,
    ) -> Result<Self, DiagnoseError> {
        let (variables, places) = (space.variables(), space.places());
        let definition = Definition::law("law", "", &law.terms, variables, places);
        space.with(std::slice::from_ref(&definition), |system| {
            let start = Hypothesis { members: law.named.clone(), ..ground.start(system) };
            let mut rows = ground.rows(system, &start).ok_or_else(diverges)?;
            rows.set_rows_per_observation(about.rows_per_observation);
            let open = &rows.whole;
            let fit = law.fitted_to(open, ground.listed, ground.settings.search.iterations)?;
            let values = fit.hypothesis.members.last().map_or(Vec::new(), |m| m.values.clone());
            Ok(Self {
                terms: definition.with_values(&law.terms, &values),
                doubtful: doubtful(open, &fit, &definition)?,
                total: crate::diagnosis::total(open, &fit) + 2.0 * law.length,
                values,
            })
        })
    }
}

/// Terms of a definition, the last member of a fit, whose coefficient may be zero, the least certain first.
fn doubtful(
    open: &Problem<'_, Dyn<'_>>,
    fit: &Fit,
    definition: &Definition,
) -> Result<Vec<usize>, DiagnoseError> {
    let intervals = open.intervals(fit)?;
    let own = &intervals[intervals.len() - definition.parameters.len()..];
    let coefficients = definition.parameters.iter().zip(own).filter(|(p, _)| p.absent.is_some());
    let mut doubtful: Vec<(usize, f64)> = coefficients
        .enumerate()
        .filter(|(_, (_, i))| i.contains(0.0))
        .map(|(k, (_, i))| (k, i.value.abs() / (i.ci95[1] - i.ci95[0])))
        .collect();
    doubtful.sort_by(|a, b| a.1.total_cmp(&b.1));
    Ok(doubtful.into_iter().map(|(k, _)| k).collect())
}
