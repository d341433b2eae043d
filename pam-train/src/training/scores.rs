//! Scores of a model on recordings.

use super::beginning::update_masses;
use super::error::TrainingError;
use pam_data::{Channel, MuscleSurfaces, Subject};
use pam_trajectory::engine::{NetworkJoint, TrajectoryEngine, TrajectoryRequest};
use pam_trajectory::metrics::r2;
use pam_trajectory::windows::Windows;

/// Recordings that are scored at a time on each thread: they and their predicted states are in memory.
const PER_THREAD: usize = 8;

/// Mean R² of `[x, ẋ, P_f, P_e]` over recordings that are predicted to their end from their first sample;
/// `None` where no recording gives one. Masses by the gas law are those of the model.
///
/// # Errors
/// [`TrainingError`] if the engine cannot simulate the model on a recording, or masses cannot be made.
pub(super) fn mean_r2(
    engine: &mut dyn TrajectoryEngine,
    (model, effects): (&NetworkJoint, &[f64]),
    surfaces: Option<&MuscleSurfaces>,
    recordings: impl IntoIterator<Item = Subject>,
) -> Result<[Option<f64>; 4], TrainingError> {
    let (mut sums, mut counts) = ([0.0; 4], [0.0; 4]);
    let mut recordings = recordings.into_iter();
    let at_a_time = PER_THREAD * rayon::current_num_threads();
    loop {
        let mut part: Vec<Subject> = recordings.by_ref().take(at_a_time).collect();
        if part.is_empty() {
            break;
        }
        update_masses(&mut part, model, surfaces)?;
        let windows = Windows::of(part, None);
        let request = TrajectoryRequest { effects, ..TrajectoryRequest::new(model, &windows) };
        let failures = engine.predict(&request)?;
        for (k, subject) in windows.subjects().iter().enumerate() {
            if failures.iter().any(|f| f.problem == k) {
                continue;
            }
            let states = engine.predicted(k);
            for (c, channel) in Channel::ALL.into_iter().enumerate() {
                let predicted: Vec<f64> = states.iter().map(|y| y[c]).collect();
                let value = r2(subject.recording.channel(channel), &predicted);
                if value.is_finite() {
                    sums[c] += value;
                    counts[c] += 1.0;
                }
            }
        }
    }
    Ok(std::array::from_fn(|c| (counts[c] > 0.0).then(|| sums[c] / counts[c])))
}
