use crate::balance::ForceBalance;
use crate::segments::Segment;
use pam_core::SealedMasses;
use pam_data::{MassOrigin, Recording};
use pam_trajectory::metrics::Scores;
use pam_trajectory::predict::Prediction;
use serde::Serialize;
use serde_json::{Value, json};

/// Scores of one segment of excitation frequency.
#[derive(Debug, Clone)]
pub struct SegmentScores {
    /// The segment.
    pub segment: Segment,
    /// Its scores.
    pub scores: Scores,
    /// Work of the external force a cycle on the measured motion, mJ: what the real joint
    /// dissipates.
    pub loop_work_measured_mj: Option<f64>,
    /// The same on the predicted motion: what the model dissipates.
    pub loop_work_predicted_mj: Option<f64>,
}

/// How one recording was predicted.
#[derive(Debug, Clone)]
pub struct RecordingEvaluation {
    /// The recording.
    pub recording: Recording,
    /// The masses it was predicted with.
    pub masses: SealedMasses,
    /// Where the masses came from.
    pub origin: MassOrigin,
    /// The prediction.
    pub prediction: Prediction,
    /// Scores over the whole recording.
    pub scores: Scores,
    /// Scores by excitation frequency.
    pub segments: Vec<SegmentScores>,
    /// The force that the model lacks on the measured motion.
    pub balance: ForceBalance,
}

/// A recording whose prediction failed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FailedRecording {
    /// Its name.
    pub name: String,
    /// Why.
    pub why: String,
    /// The last predicted time, s.
    pub reached_s: Option<f64>,
}

/// How a data set was predicted.
#[derive(Debug, Clone)]
pub struct Evaluation {
    /// Predicted recordings, in the order of the data set.
    pub recordings: Vec<RecordingEvaluation>,
    /// Recordings whose prediction failed.
    pub failed: Vec<FailedRecording>,
    /// Channel-wise means over the predicted recordings.
    pub mean: Scores,
}

impl Evaluation {
    /// The machine-readable form: `recordings` (name, masses, R², RMSE, segments, force balance),
    /// `mean` and `failed`. Undefined values are `null`.
    #[must_use]
    pub fn to_json(&self) -> Value {
        json!({
            "recordings": self.recordings.iter().map(RecordingEvaluation::to_json).collect::<Vec<_>>(),
            "mean": self.mean,
            "failed": self.failed,
        })
    }
}

impl RecordingEvaluation {
    fn to_json(&self) -> Value {
        let segments: Vec<Value> = self
            .segments
            .iter()
            .map(|s| {
                json!({
                    "frequency_hz": s.segment.frequency_hz,
                    "from_s": self.recording.time_s[s.segment.range.start],
                    "to_s": self.recording.time_s[s.segment.range.end - 1],
                    "r2": s.scores.r2,
                    "rmse": s.scores.rmse,
                    "loop_work_measured_mj": s.loop_work_measured_mj,
                    "loop_work_predicted_mj": s.loop_work_predicted_mj,
                })
            })
            .collect();
        json!({
            "name": self.recording.name,
            "mass_flexor_g": self.masses.flexor_g,
            "mass_extensor_g": self.masses.extensor_g,
            "mass_origin": self.origin,
            "samples": self.recording.len(),
            "r2": self.scores.r2,
            "rmse": self.scores.rmse,
            "segments": segments,
            "force_balance": self.balance,
            "notes": self.recording.notes,
            "preprocessing": self.recording.preprocessing,
            "solver": {
                "accepted_steps": self.prediction.statistics.accepted,
                "rejected_steps": self.prediction.statistics.rejected,
                "field_evaluations": self.prediction.statistics.evaluations,
            },
        })
    }
}
