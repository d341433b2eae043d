//! Fit of all effects of an extended model to recordings.

use crate::error::DiagnoseError;
use crate::fit::{Hypothesis, Interval, Problem};
use crate::search::noise_floors;
use pam_data::Subject;
use pam_effects::ExtendedModel;
use pam_effects::simulation::Trial;

/// Time at the start of a recording that is not fitted, s: transients of an unknown start.
pub(crate) const BURN_IN_S: f64 = 0.5;

/// Fits the parameters of all effects to recordings, by Gauss–Newton through the simulation from their
/// present values, with the network as it is. Returns the fitted model and the parameters' 95 %
/// intervals, effect by effect.
///
/// # Errors
/// [`DiagnoseError::Diverges`] if the model diverges on a recording.
pub fn refit(
    model: &ExtendedModel,
    subjects: &[Subject],
    iterations: usize,
) -> Result<(ExtendedModel, Vec<Vec<Interval>>), DiagnoseError> {
    let trials: Vec<Trial> = subjects.iter().map(|s| Trial::new(&model.joint, s)).collect();
    let all: Vec<&Trial> = trials.iter().collect();
    let problem = Problem::new(trials.iter(), model.base(), BURN_IN_S, noise_floors(&all));
    let start = model
        .effects
        .iter()
        .fold(Hypothesis::base(&[], trials.len()), |h, a| h.with(a.effect, &a.values));
    let fit = problem.fit(start, iterations)?;
    let mut intervals = problem.intervals(&fit)?.into_iter();
    let mut fitted = model.clone();
    let mut by_effect = Vec::new();
    for (active, (_, values)) in fitted.effects.iter_mut().zip(fit.hypothesis.fitted()) {
        active.values = values.to_vec();
        by_effect.push(intervals.by_ref().take(active.effect.info().parameters.len()).collect());
    }
    Ok((fitted, by_effect))
}
