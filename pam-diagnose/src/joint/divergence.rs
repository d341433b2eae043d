//! Recordings on which the model itself diverges.
//!
//! An actuator that delivers less than the recorded force, or a model that is far off, drives the simulation out of the motion of the
//! joint, to where the model's force is an extrapolation and may push the joint on. The recording up to there is data like any
//! other; after it there is no prediction to compare with.

use crate::error::DiagnoseError;
use crate::settings::DataSettings;
use pam_data::Subject;
use pam_effects::model::{ActiveEffect, ExtendedModel};
use pam_effects::simulation::{Diverged, Nuisances, Trial, motion_until};
use serde::Serialize;
use std::fmt;

/// A recording of which only the beginning is used, because the model diverges on the rest.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CutRecording {
    /// Its name.
    pub recording: String,
    /// Length of the part that is used, s.
    pub used_s: f64,
    /// Length of the recording, s.
    pub recorded_s: f64,
}

impl fmt::Display for CutRecording {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}: only the first {:.2} s of {:.2} s are used. The simulation of the model diverges a second later: the model is far off, \
             or the actuator delivers less than the recorded force",
            self.recording, self.used_s, self.recorded_s
        )
    }
}

/// The recordings of which the trials, in the same order, are the beginning.
pub(super) fn cut_recordings<'a>(
    subjects: impl IntoIterator<Item = &'a Subject>,
    trials: impl IntoIterator<Item = &'a Trial>,
) -> Vec<CutRecording> {
    let cut = |(subject, trial): (&Subject, &Trial)| {
        let (record, (from_s, to_s)) = (&trial.record, subject.recording.span_s());
        let (used_s, recorded_s) = (record.duration_s(), to_s - from_s);
        // The last grid point may be up to a step before the last sample.
        (used_s + 2.0 * record.step_s < recorded_s).then(|| CutRecording {
            recording: record.source.name.clone(),
            used_s,
            recorded_s,
        })
    };
    subjects.into_iter().zip(trials).filter_map(cut).collect()
}

/// Time before a divergence that is not used, s: some periods of a joint, in which the simulation runs away.
const RUNNING_AWAY_S: f64 = 1.0;

/// The trial up to a second before the simulation of a model diverges; the whole trial if it does not.
///
/// # Errors
/// [`DiagnoseError::Diverges`] if the remaining part is shorter than [`DataSettings::shortest_s`].
pub(super) fn before_divergence(
    trial: Trial,
    model: &ExtendedModel,
    settings: &DataSettings,
) -> Result<Trial, DiagnoseError> {
    let (effects, values) = ActiveEffect::split(&model.effects);
    let (base, points) = (model.base(), trial.record.points());
    let motion = motion_until(&trial, &base, &effects, &values, &Nuisances::none(), points);
    let Err(diverged) = motion else { return Ok(trial) };
    let used_s = diverged.time_s - RUNNING_AWAY_S;
    if used_s < settings.shortest_s {
        return Err(diverges(&trial, diverged));
    }
    Ok(trial.until(trial.record.points_within(used_s)))
}

/// The error of a trial on which the model diverges.
pub(super) fn diverges(trial: &Trial, diverged: Diverged) -> DiagnoseError {
    DiagnoseError::Diverges { recording: trial.record.source.name.clone(), diverged }
}
