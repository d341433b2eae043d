//! The inputs of recordings without the errors of their measurement.

use super::diagnose::{DiagnoseOptions, resampled};
use super::force_noise::{driving_force, quiet_forces, with_doubtful_force};
use super::spans::spans;
use super::system::JointSystem;
use crate::data::{Roles, TestSource};
use crate::error::DiagnoseError;
use crate::noise::Noise;
use crate::search::{Candidates, Rows};
use pam_data::{Recording, Subject};
use pam_effects::ExtendedModel;
use pam_effects::simulation::Trial;

/// Recordings with the inputs that a model takes as the true ones: the force without its noise and as early as it acts, and the
/// first displacement and velocity. These are the values that a [`diagnose`](super::diagnose()) of the recordings fits before
/// it searches for causes; everything else is as measured. The residual `measured − simulated` along them is therefore noise of
/// the output sensors and model error.
///
/// # Errors
/// [`DiagnoseError`] if a recording is too short, or the model diverges on it.
pub fn calibrated_inputs(
    model: &ExtendedModel,
    recordings: &[Subject],
    options: &DiagnoseOptions,
) -> Result<Vec<Recording>, DiagnoseError> {
    let settings = &options.settings;
    let subjects: Vec<&Subject> = recordings.iter().collect();
    let trials = resampled(model, &subjects, settings)?;
    let quiet = quiet_forces(&subjects, settings);
    let trials = with_doubtful_force(trials, &quiet);
    let all: Vec<&Trial> = trials.iter().collect();
    let roles = Roles::assign(&spans(&all), TestSource::Absent, &settings.data)?;
    let open = roles.open();
    let system = JointSystem::new(all, &open, model.base(), &model.effects, Vec::new(), settings);
    let (noise, prior) = system.first_noise(&open, options.noise);
    let (noise, system) = (Noise::white(&noise), &system as &dyn Candidates);
    let mut rows = Rows::of(&roles, system, &noise, prior, settings);
    let base = rows.whole.base();
    let diverges = || DiagnoseError::TooLittle("the model diverges on the recordings".into());
    let fit = rows.learn_beside(&base).ok_or_else(diverges)?.hypothesis;
    let one = |i: usize| {
        let (subject, local) = (&recordings[i], &fit.locals[i]);
        let (trial, quiet) = (&trials[i], &quiet[i]);
        let nuisances = JointSystem::nuisances::<f64>(&fit, local);
        let mut recording = subject.recording.clone();
        let mut force_mn = driving_force(&recording).to_vec();
        if let Some(quiet) = quiet {
            let noise = driving_force(quiet).iter().map(|q| nuisances.force_noise_share * q);
            force_mn.iter_mut().zip(noise).for_each(|(force, noise)| *force -= noise);
        }
        let force_mn = led(&force_mn, nuisances.lead_samples);
        match &mut recording.low_passed.force_mn {
            Some(driving) => *driving = force_mn,
            None => recording.force_mn = force_mn,
        }
        recording.displacement_mm[0] += nuisances.start_mm;
        recording.velocity_mm_s[0] = trial.record.start_velocity.mm_s + nuisances.start_mm_s;
        recording
    };
    Ok((0..recordings.len()).map(one).collect())
}

/// A held force that acts earlier by so many samples than the one given: the cubic through the four nearest samples there, less
/// the correction for the zero-order hold ([`FineForce`](pam_effects::simulation::FineForce)).
fn led(force: &[f64], lead_samples: f64) -> Vec<f64> {
    if lead_samples == 0.0 {
        return force.to_vec();
    }
    let last = force.len() as isize - 1;
    let at = |k: isize| force[k.clamp(0, last) as usize];
    let whole = lead_samples.floor();
    let u = lead_samples - whole;
    let weights = [
        -u * (u - 1.0) * (u - 2.0) / 6.0,
        (u + 1.0) * (u - 1.0) * (u - 2.0) / 2.0,
        -(u + 1.0) * u * (u - 2.0) / 2.0,
        (u + 1.0) * u * (u - 1.0) / 6.0,
    ];
    let of = |k: isize| {
        let first = k + whole as isize - 1;
        let cubic: f64 = (0..).zip(weights).map(|(i, w)| w * at(first + i)).sum();
        let bend = at(k - 1) - 2.0 * at(k) + at(k + 1);
        cubic - 2.0 * lead_samples / 24.0 * bend
    };
    (0..=last).map(of).collect()
}
