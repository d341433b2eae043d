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
    /// Time of its first sample, s.
    pub from_s: f64,
    /// Time of its last sample, s.
    pub to_s: f64,
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
    /// Number of samples that were predicted and scored. After [`every`](Self::every) the recording has fewer.
    pub samples: usize,
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
///
/// ```
/// use pam_core::{JointModel, SpringDamper};
/// use pam_data::{Recording, subjects};
/// use pam_train::evaluate;
/// use pam_trajectory::{Predictor, SolverSettings};
///
/// let model = JointModel::datasheet(SpringDamper::published());
/// let time_s = (0..500).map(|k| 2e-3 * f64::from(k)).collect();
/// let pushed = Recording::at_rest("a", time_s, [412.0, 412.0]).with_force(|t| 1e5 * (6.0 * t).sin());
/// let settings = SolverSettings::default();
/// let masses = model.gas_law_masses(0.0, [412.0, 412.0]);
/// let measured = model.predict(&pushed, masses, &settings)?.to_recording(&pushed, masses);
/// let evaluation = evaluate(&model, subjects([measured], &model)?, &settings, &|| ());
/// assert!(evaluation.mean.r2.x > 0.999_999 && evaluation.failed.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
    /// Keeps every `stride`-th sample of the recording, the prediction and the missing force, to save memory. Scores, balance and
    /// segment times still refer to all samples.
    ///
    /// # Panics
    /// If the stride is 0.
    #[must_use]
    pub fn every(mut self, stride: usize) -> Self {
        self.recording = self.recording.every(stride);
        self.prediction = self.prediction.every(stride);
        self.balance.missing_n = self.balance.missing_n.into_iter().step_by(stride).collect();
        for s in &mut self.segments {
            let range = &mut s.segment.range;
            *range = range.start.div_ceil(stride)..range.end.div_ceil(stride);
        }
        self
    }

    fn to_json(&self) -> Value {
        let segments: Vec<Value> = self
            .segments
            .iter()
            .map(|s| {
                json!({
                    "frequency_hz": s.segment.frequency_hz,
                    "from_s": s.from_s,
                    "to_s": s.to_s,
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
            "samples": self.samples,
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
