//! Stages of a curriculum.

use super::{Selection, SolverChoice};
use crate::optimiser::OptimiserSettings;
use crate::schedule::Schedule;
use crate::warm_start::DerivativeMatching;
use pam_trajectory::loss::AnyLoss;
use serde::{Deserialize, Serialize};

/// A stage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
pub enum Stage {
    /// The deformation coefficient is fitted to pressures along measured displacements.
    Gas(GasStage),
    /// Mass and force are regressed on accelerations.
    Derivatives(DerivativeStage),
    /// Everything is fitted through the solver.
    Solve(Box<SolveStage>),
}

impl Stage {
    /// Its name.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Gas(s) => &s.name,
            Self::Derivatives(s) => &s.name,
            Self::Solve(s) => &s.name,
        }
    }

    /// Epochs at most; stages without epochs count as one.
    #[must_use]
    pub fn epochs(&self) -> usize {
        match self {
            Self::Solve(s) => s.epochs,
            _ => 1,
        }
    }

    /// The training recordings that it uses; all if it does not say.
    #[must_use]
    pub fn recordings(&self) -> Option<&Selection> {
        match self {
            Self::Gas(s) => s.recordings.as_ref(),
            Self::Derivatives(s) => s.recordings.as_ref(),
            Self::Solve(s) => s.recordings.as_ref(),
        }
    }
}

/// See [`fit_deformation`](crate::warm_start::fit_deformation).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GasStage {
    /// Name.
    pub name: String,
    /// Recordings of the training set that it uses.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recordings: Option<Selection>,
}

/// See [`DerivativeMatching`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DerivativeStage {
    /// Name.
    pub name: String,
    /// Recordings of the training set that it uses.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recordings: Option<Selection>,
    /// Smoothing and regression.
    #[serde(default)]
    pub matching: DerivativeMatching,
}

/// Training through the solver.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SolveStage {
    /// Name.
    pub name: String,
    /// Recordings of the training set that it uses.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recordings: Option<Selection>,
    /// Prescribed auxiliary damping B, kg/s.
    #[serde(default)]
    pub auxiliary_damping: f64,
    /// Epochs at most.
    pub epochs: usize,
    /// Epochs without a new best loss after which the stage ends.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub patience: Option<usize>,
    /// Recordings are cut into windows of this length, s, each predicted from its own start.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub horizon_s: Option<f64>,
    /// Trainable starts of the windows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shooting: Option<Shooting>,
    /// Recordings or windows in a step of the optimiser; all if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub batch: Option<usize>,
    /// In place of the curriculum's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rate: Option<f64>,
    /// In place of the curriculum's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub schedule: Option<Schedule>,
    /// In place of the curriculum's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub optimiser: Option<OptimiserSettings>,
    /// In place of the curriculum's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub loss: Option<AnyLoss>,
    /// In place of the curriculum's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clip: Option<f64>,
    /// In place of the curriculum's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub solver: Option<SolverChoice>,
}

/// Multiple shooting: the starts of the windows are trained too, and a window that does not end where
/// the next one starts is penalised,
///
/// ```text
/// continuity · Σ_c (ŷ_c(end) − start_c)² / variance_c
/// ```
///
/// with the variance of each measured channel over the recording.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Shooting {
    /// Weight of the penalty.
    pub continuity: f64,
    /// Rate of the starts, in standard deviations of their channels.
    pub rate: f64,
}

impl Default for Shooting {
    fn default() -> Self {
        Self { continuity: 10.0, rate: 1e-3 }
    }
}
