//! The fit of all effects of an extended model to recordings.

use super::system::JointSystem;
use crate::data::OpenPart;
use crate::error::DiagnoseError;
use crate::fit::{Interval, Problem};
use crate::noise::{Noise, estimated_noise};
use crate::settings::DiagnosisSettings;
use pam_data::Subject;
use pam_effects::ExtendedModel;
use pam_effects::effects::AnyEffect;
use pam_effects::simulation::{ResampledRecord, Trial};

/// Fits the parameters of all effects to recordings, by Levenberg–Marquardt through the simulation from their
/// present values, with the network as it is. Returns the fitted model and the parameters' 95 %
/// intervals, effect by effect.
///
/// # Errors
/// [`DiagnoseError`] if the model diverges on a recording.
pub fn refit(
    model: &ExtendedModel,
    subjects: &[Subject],
    iterations: usize,
) -> Result<(ExtendedModel, Vec<Vec<Interval>>), DiagnoseError> {
    let settings = DiagnosisSettings::default();
    subjects.iter().try_for_each(ResampledRecord::check)?;
    let trials: Vec<Trial> = subjects.iter().map(|s| Trial::new(&model.joint, s)).collect();
    let all = OpenPart::whole(trials.len());
    let effects: Vec<&'static dyn AnyEffect> = model.effects.iter().map(|a| a.effect).collect();
    let base = model.base();
    let system = JointSystem::new(trials.iter().collect(), &all, base, &[], effects, &settings);
    let noise = Noise::white(&estimated_noise(&system, &all, &settings.noise));
    let mut problem = Problem::new(&system, (0..trials.len()).collect(), noise, &settings);
    let start = (0..).zip(&model.effects).fold(problem.base(), |h, (c, a)| h.with(c, &a.values));
    let mut fit = problem.fit(start, iterations)?;
    if let Some(noise) = Noise::learned(&problem, &fit.hypothesis, &system.noise_prior(&all)) {
        problem.noise = noise;
        problem.rows_per_observation = problem.correlated_rows(&fit.hypothesis)?;
        fit = problem.fit(fit.hypothesis, iterations)?;
    }
    let mut intervals = problem.intervals(&fit)?.into_iter();
    let mut fitted = model.clone();
    let mut by_effect = Vec::new();
    for (active, member) in fitted.effects.iter_mut().zip(fit.hypothesis.members) {
        active.values = member.values;
        by_effect.push(intervals.by_ref().take(active.effect.info().parameters.len()).collect());
    }
    Ok((fitted, by_effect))
}
