//! Detection limits, before anything is measured.
//!
//! Under the hypothesis that an effect of magnitude m is at work, the whitened squared residual drops by a noncentral χ² of
//! `p` degrees of freedom when its `p` parameters are fitted. The noncentrality is `‖s(m)‖²`, the square of the effect's
//! [`Signature`](pam_diagnose::joint::Signature): the whitened difference of the simulations with and without it, less what
//! the nuisances can imitate. For effects that are linear in their magnitude it is m² times the Fisher information that
//! is left by the Schur complement of the nuisances; here it is that of the simulation at every magnitude, so that friction, play
//! and saturation need no tangent.
//!
//! Three limits follow, each with the given power:
//!
//! | limit | the drop must exceed |
//! |---|---|
//! | `familywise` | the quantile of χ² that the largest of all candidates exceeds by chance at the level (Bonferroni): no test of this error rate sees less |
//! | `listed` | what a diagnosis asks of a set: its price and the odds, and the test against chance over its blocks |
//! | `foretold` | also the rule that a cause is minor that removes next to nothing, and what confirms it on a test recording: the whitened error is proven to be smaller, and the error of the free run is |
//!
//! The last one is only a forecast: which effect is named depends on rivals and on chance as well. `named` is therefore found by trials,
//! whole diagnoses of recordings with the effect in them, at magnitudes that follow from their outcomes ([`LimitPosterior`]).

mod demand;
mod limits;
mod pairs;
mod posterior;
mod power;
mod ray;
mod report;
mod result;
mod trials;

pub use limits::detect;
pub use posterior::LimitPosterior;
pub use power::{needed_noncentrality, noncentral_chi_square_sf};
pub use ray::{GivenValues, Ray, rays};
pub use report::detection_report;
pub use result::{Detection, Limit, Limits, Pair};
pub use trials::{LimitTrial, TriedLimit};

pub(crate) use demand::{Demand, Kind, of_nothing, signature};
pub(crate) use limits::{TrialProgress, detect_along};
pub(crate) use pairs::{reference, span_of};

use pam_diagnose::DiagnoseOptions;

/// Candidates, diagnosis, power and level of [`detect`].
#[derive(Debug, Clone)]
pub struct DetectOptions {
    /// Candidates and settings of the diagnosis that is foretold.
    pub diagnosis: DiagnoseOptions,
    /// Effects whose limits are computed, with values that are kept; all candidates if empty.
    pub effects: Vec<GivenValues>,
    /// Power of the limits.
    pub power: f64,
    /// Familywise rate of false alarms of the limit that no test falls below.
    pub level: f64,
    /// Diagnoses by which the limit of each effect is found. Without a number [`TRIALS`], or none where the recordings are longer than
    /// [`LONGEST_TRIED_S`] together.
    pub trials: Option<usize>,
}

/// Diagnoses by which the limit of an effect is found.
pub const TRIALS: usize = 8;
/// Total length of recordings up to which limits are found by trials unless a number is given: a diagnosis of them takes seconds, s.
pub const LONGEST_TRIED_S: f64 = 100.0;

impl DetectOptions {
    /// Number of trials of each effect in recordings of this total length.
    #[must_use]
    pub fn trials_for(&self, length_s: f64) -> usize {
        self.trials.unwrap_or(if length_s > LONGEST_TRIED_S { 0 } else { TRIALS })
    }
}

impl Default for DetectOptions {
    fn default() -> Self {
        Self {
            diagnosis: DiagnoseOptions::default(),
            effects: Vec::new(),
            power: 0.9,
            level: 0.05,
            trials: None,
        }
    }
}
