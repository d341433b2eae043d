//! Results of a comparison.

use crate::method::{Needs, Structure};
use pam_numerics::statistics;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// How one recording was predicted. Undefined numbers are absent.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RecordingScore {
    /// The recording.
    pub name: String,
    /// Sealed pressures at rest, flexor and extensor, kPa absolute.
    pub pressures_kpa: [f64; 2],
    /// R² of x, ẋ, P_f, P_e on the samples after the warm-up.
    pub r2: [Option<f64>; 4],
    /// Root mean square error of x there, mm.
    pub rmse_mm: Option<f64>,
    /// R² of x by excitation frequency (Hz) there.
    pub by_frequency: Vec<(f64, Option<f64>)>,
    /// Stiffness that the predicted motion shows, N/mm: see
    /// [`observe`](pam_control::equilibrium_point::observe).
    pub shown_stiffness_n_mm: Option<f64>,
    /// Why the prediction stopped, if it did.
    pub stopped: Option<String>,
}

/// Mean and scatter of one number over recordings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Mean over the recordings whose prediction reached its end.
    pub mean: Option<f64>,
    /// Sample standard deviation.
    pub deviation: Option<f64>,
    /// Median, a prediction that stopped counting as worst.
    pub median: Option<f64>,
    /// Number of recordings.
    pub count: usize,
    /// Number of them whose prediction stopped.
    pub stopped: usize,
}

impl Summary {
    /// The summary of values of which `None` stopped.
    #[must_use]
    pub fn of(values: &[Option<f64>]) -> Self {
        let mut finished: Vec<f64> = values.iter().copied().flatten().collect();
        let mean = (!finished.is_empty()).then(|| statistics::mean(&finished));
        let deviation = (finished.len() > 1).then(|| statistics::standard_deviation(&finished));
        let stopped = values.len() - finished.len();
        finished.sort_by(f64::total_cmp);
        // Those that stopped stand before all others.
        let at = |k: usize| k.checked_sub(stopped).and_then(|k| finished.get(k).copied());
        let half = values.len() / 2;
        let median = match values.len() {
            0 => None,
            n if n % 2 == 1 => at(half),
            _ => at(half - 1).zip(at(half)).map(|(a, b)| 0.5 * (a + b)),
        };
        Self { mean, deviation, median, count: values.len(), stopped }
    }
}

/// Scores of one set of recordings, predicted in one way.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SetScores {
    /// One entry per recording.
    pub recordings: Vec<RecordingScore>,
    /// R² of the displacement.
    pub displacement: Summary,
    /// R² of the displacement by excitation frequency, Hz.
    pub by_frequency: Vec<(f64, Summary)>,
}

impl SetScores {
    /// Summarises recordings.
    #[must_use]
    pub fn of(recordings: Vec<RecordingScore>) -> Self {
        let displacement = Summary::of(&recordings.iter().map(|r| r.r2[0]).collect::<Vec<_>>());
        let mut frequencies: Vec<f64> =
            recordings.iter().flat_map(|r| &r.by_frequency).map(|(f, _)| *f).collect();
        frequencies.sort_by(f64::total_cmp);
        frequencies.dedup();
        let by_frequency = frequencies
            .into_iter()
            .map(|f| {
                let values: Vec<Option<f64>> = recordings
                    .iter()
                    .flat_map(|r| &r.by_frequency)
                    .filter(|(g, _)| *g == f)
                    .map(|(_, v)| *v)
                    .collect();
                (f, Summary::of(&values))
            })
            .collect();
        Self { recordings, displacement, by_frequency }
    }
}

/// Both sets.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BothSets {
    /// Recordings that were fitted to.
    pub train: SetScores,
    /// Recordings that were not.
    pub held_out: SetScores,
}

/// Errors of force and stiffness, on the held-out recordings (on the training ones if there are
/// none).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Mechanics {
    /// R² of the model's restoring force against `F − m ẍ` along the measured motions, if it has a force.
    pub force_r2: Option<f64>,
    /// Mean |K − K_measured| / K_measured of the stiffness ∂f/∂x at rest, %, if it has a force. K_measured
    /// is what the measured motion shows.
    pub stiffness_error_percent: Option<f64>,
    /// The same of the stiffness that the predicted motion shows, which any model has.
    pub shown_stiffness_error_percent: Option<f64>,
    /// Range of K at rest over the recordings, N/mm.
    pub stiffness_range_n_mm: Option<[f64; 2]>,
    /// R² of the model's single-muscle force against what it was fitted to, if it is one of single muscles.
    pub single_muscle_r2: Option<f64>,
}

/// One model's part of a comparison.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ModelResult {
    /// Name.
    pub name: String,
    /// Kind of the method.
    pub kind: String,
    /// Kind of equations.
    pub structure: Structure,
    /// Inputs that a prediction needs.
    pub needs: Needs,
    /// Number of fitted numbers.
    pub parameters: usize,
    /// Predicted from the first sample.
    pub cold: BothSets,
    /// Predicted after the warm-up.
    pub warm: BothSets,
    /// Force and stiffness.
    pub mechanics: Mechanics,
    /// Results of the fit.
    pub details: Value,
}

impl ModelResult {
    /// Scores on both sets from both starts.
    #[must_use]
    pub fn sets(&self) -> [&SetScores; 4] {
        [&self.cold.train, &self.cold.held_out, &self.warm.train, &self.warm.held_out]
    }
}

/// Seconds that a model took; stored separately from the results, which repeat bit for bit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ModelTimes {
    /// Fitting.
    pub fit_s: f64,
    /// Predicting all recordings twice.
    pub predict_s: f64,
}

/// A predicted displacement for figures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Drawn {
    /// The recording.
    pub recording: String,
    /// Times, s.
    pub time_s: Vec<f64>,
    /// Cold-started prediction, mm; shorter than the times or empty if it stopped.
    pub displacement_mm: Vec<f64>,
}

/// A model's result with its times and figures: what is kept for a resumed comparison.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FinishedModel {
    /// Scores.
    pub result: ModelResult,
    /// Seconds.
    pub times: ModelTimes,
    /// Trajectories for figures.
    pub drawn: Vec<Drawn>,
}

/// Results of a comparison.
#[derive(Debug, Clone, PartialEq)]
pub struct Comparison {
    /// Its name.
    pub name: String,
    /// Names of the training recordings.
    pub train: Vec<String>,
    /// Names of the held-out recordings.
    pub held_out: Vec<String>,
    /// Samples of the warm-up.
    pub warm_up: usize,
    /// Seed.
    pub seed: u64,
    /// Models, in the order of the configuration.
    pub models: Vec<FinishedModel>,
    /// Measured displacements of the recordings that are drawn.
    pub measured: Vec<Drawn>,
}
