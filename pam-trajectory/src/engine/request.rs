//! Requests to engines.

use super::EngineError;
use crate::windows::Windows;
use pam_core::{JointModel, NamedChoice, NetworkForce, ParametricForce};
use pam_data::{Recording, Subject};
use serde::{Deserialize, Serialize};

/// The loss of one window by its position in the request: as
/// [`value_and_cotangents`](crate::loss::TrajectoryLoss::value_and_cotangents) with that position in front.
pub type IndexedLoss<'a> =
    dyn Fn(usize, &Recording, &[[f64; 4]], &mut [[f64; 4]]) -> f64 + Sync + 'a;

/// Floating-point precision of the network.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Precision {
    /// Single.
    #[default]
    F32,
    /// Double.
    F64,
}

impl NamedChoice for Precision {
    const KIND: &'static str = "precision";
    const ALL: &'static [(&'static str, Self, &'static str)] = &[
        ("f32", Self::F32, "single precision in the network; states, time and sums stay in double"),
        ("f64", Self::F64, "double precision throughout"),
    ];
}

/// A force model for which an engine can be chosen: every [`ParametricForce`] that threads can share.
pub trait EngineForce: ParametricForce + Sync {}

impl<F: ParametricForce + Sync> EngineForce for F {}

/// Follows the tasks of an engine that works on one recording after another.
pub trait Progress: Sync {
    /// Called once with the number of tasks.
    fn planned(&self, tasks: usize);
    /// Called after each task, on any thread.
    fn done(&self);
}

/// A model and the windows on which it is evaluated.
pub struct TrajectoryRequest<'a, F = NetworkForce<f64>> {
    /// The model without its effects.
    pub model: &'a JointModel<f64, F>,
    /// Parameters of the model's effects in turn, without switches; empty without effects.
    pub effects: &'a [f64],
    /// Windows of recordings.
    pub windows: &'a Windows,
    /// Indices of the windows to evaluate; all if absent.
    pub part: Option<&'a [usize]>,
    /// The state `[x, ẋ, P_f, P_e]` (mm, mm/s, kPa, kPa) from which each of them is predicted, as the sensors
    /// show it; the measured one if absent.
    pub starts: Option<&'a [[f64; 4]]>,
    /// Follows the tasks of engines that have some.
    pub progress: Option<&'a dyn Progress>,
}

impl<'a, F> TrajectoryRequest<'a, F> {
    /// All windows, each from its measured start.
    #[must_use]
    pub fn new(model: &'a JointModel<f64, F>, windows: &'a Windows) -> Self {
        Self { model, effects: &[], windows, part: None, starts: None, progress: None }
    }

    /// Number of windows to evaluate.
    #[must_use]
    pub fn len(&self) -> usize {
        self.part.map_or(self.windows.subjects().len(), <[usize]>::len)
    }

    /// Whether there is no window to evaluate.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Index among all windows of the `k`-th one to evaluate.
    #[must_use]
    pub fn window(&self, k: usize) -> usize {
        self.part.map_or(k, |part| part[k])
    }

    /// Recording and masses of the `k`-th window to evaluate.
    #[must_use]
    pub fn subject(&self, k: usize) -> &'a Subject {
        &self.windows.subjects()[self.window(k)]
    }

    /// Start of the `k`-th window to evaluate.
    #[must_use]
    pub fn start(&self, k: usize) -> [f64; 4] {
        match self.starts {
            Some(starts) => starts[k],
            None => self.subject(k).recording.initial_state(),
        }
    }

    /// Checks that every window exists and has a start.
    ///
    /// # Errors
    /// [`EngineError::Request`] otherwise.
    pub fn check(&self) -> Result<(), EngineError> {
        let all = self.windows.subjects().len();
        if let Some(&missing) = self.part.and_then(|part| part.iter().find(|&&i| i >= all)) {
            return Err(EngineError::Request(format!("there is no window {missing}, only {all}")));
        }
        match self.starts {
            Some(starts) if starts.len() < self.len() => Err(EngineError::Request(format!(
                "{} starts for {} windows; give one for each",
                starts.len(),
                self.len()
            ))),
            _ => Ok(()),
        }
    }
}
