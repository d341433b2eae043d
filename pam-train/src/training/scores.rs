//! Scores of a model on recordings.

use pam_data::Channel;
use pam_trajectory::engine::{EngineError, NetworkJoint, TrajectoryEngine, TrajectoryRequest};
use pam_trajectory::metrics::r2;
use pam_trajectory::windows::Windows;

/// Recordings that are scored at a time: their predicted states stay in memory.
const PORTION: usize = 32;

/// Mean R² of `[x, ẋ, P_f, P_e]` over recordings that are predicted to their end from their first sample;
/// `None` where no recording gives one.
///
/// # Errors
/// [`EngineError`] if the engine cannot simulate the model on a recording.
pub(super) fn mean_r2(
    engine: &mut dyn TrajectoryEngine,
    model: &NetworkJoint,
    effects: &[f64],
    recordings: &Windows,
) -> Result<[Option<f64>; 4], EngineError> {
    let (mut sums, mut counts) = ([0.0; 4], [0.0; 4]);
    let all: Vec<usize> = (0..recordings.subjects().len()).collect();
    for part in all.chunks(PORTION) {
        let request = TrajectoryRequest {
            effects,
            part: Some(part),
            ..TrajectoryRequest::new(model, recordings)
        };
        let failures = engine.predict(&request)?;
        for k in (0..part.len()).filter(|&k| failures.iter().all(|f| f.problem != k)) {
            let measured = &request.subject(k).recording;
            let states = engine.predicted(k);
            for (c, channel) in Channel::ALL.into_iter().enumerate() {
                let predicted: Vec<f64> = states.iter().map(|y| y[c]).collect();
                let value = r2(measured.channel(channel), &predicted);
                if value.is_finite() {
                    sums[c] += value;
                    counts[c] += 1.0;
                }
            }
        }
    }
    Ok(std::array::from_fn(|c| (counts[c] > 0.0).then(|| sums[c] / counts[c])))
}
