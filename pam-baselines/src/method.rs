//! Traits of baselines: a [`Method`] makes a [`FittedModel`] from recordings.
//!
//! # Start of a prediction
//!
//! A prediction starts at a sample of a recording ([`Run::start`]). A model may use everything measured up
//! to and including that sample, and the external force at all times. At sample 0 that is the first state
//! alone (a *cold* start); at a later sample it is a history (a *warm* start), from which a recurrent model
//! takes its hidden state and any other model its first state.

use crate::error::BaselineError;
use pam_core::parallel;
use pam_core::{ForceInput, SealedMasses};
use pam_data::formats::npz::Array;
use pam_data::{MuscleSurfaces, Recording, Subject};
use pam_trajectory::{PerChannel, PredictError, Prediction, Predictor, SolverSettings};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The recordings that a model is fitted to.
#[derive(Debug, Clone, Copy)]
pub struct TrainingSet<'a> {
    /// Recordings with their sealed masses.
    pub subjects: &'a [Subject],
    /// Measured surfaces of a single muscle, for models of single muscles.
    pub surfaces: Option<&'a MuscleSurfaces>,
    /// Seed of everything random.
    pub seed: u64,
}

/// Kind of equations of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Structure {
    /// Equations of motion in which every number has a unit and a meaning.
    Physical,
    /// Equations of motion with a learned force.
    Hybrid,
    /// Coefficients of a dictionary of known functions.
    Dictionary,
    /// Weights.
    Network,
}

/// Inputs of a model in addition to the external force.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Needs {
    /// The measured state of one sample.
    State,
    /// The measured pressures at all times.
    Pressures,
}

/// Where a prediction starts.
#[derive(Debug, Clone, Copy)]
pub struct Run<'a> {
    /// The recording.
    pub recording: &'a Recording,
    /// Its sealed masses.
    pub masses: SealedMasses,
    /// The sample from which on it is predicted; this sample and those before it are known.
    pub start: usize,
}

impl Run<'_> {
    /// The measured state `[x, ẋ, P_f, P_e]` at the start.
    #[must_use]
    pub fn state(&self) -> [f64; 4] {
        pam_data::Channel::ALL.map(|c| self.recording.channel(c)[self.start])
    }

    /// Number of samples of the prediction, the start included.
    #[must_use]
    pub fn len(&self) -> usize {
        self.recording.len() - self.start
    }

    /// True if there is nothing to predict.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// A predicted trajectory: the samples from the start of the [`Run`] on, the start included. A model that
/// has no pressures of its own leaves those columns empty.
pub type Trajectory = PerChannel<Vec<f64>>;

/// A prediction that did not reach the end of its recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Stopped {
    /// Why.
    pub why: String,
}

/// A model that was fitted or read from a file.
pub trait FittedModel: Send + Sync {
    /// Predicts one run. Its first sample is the measured state at the start.
    ///
    /// # Errors
    /// [`Stopped`] if the prediction diverges.
    fn simulate(&self, run: &Run<'_>) -> Result<Trajectory, Stopped>;

    /// Predicts several runs, in their order; `done` gets the number of runs finished since the last call.
    /// Results do not depend on the number of threads.
    fn simulate_all(
        &self,
        runs: &[Run<'_>],
        done: &(dyn Fn(usize) + Sync),
    ) -> Vec<Result<Trajectory, Stopped>> {
        parallel::map(runs.len(), |k| {
            let result = self.simulate(&runs[k]);
            done(1);
            result
        })
    }

    /// Number of fitted numbers.
    fn parameter_count(&self) -> usize;

    /// Kind of equations.
    fn structure(&self) -> Structure;

    /// Inputs that a prediction needs.
    fn needs(&self) -> Needs {
        Needs::State
    }

    /// The restoring force of the joint (mN) at one operating point, if the model has one.
    fn restoring_force_mn(&self, _at: &ForceInput<f64>, _pressures_kpa: [f64; 2]) -> Option<f64> {
        None
    }

    /// The stiffness ∂f/∂x (N/mm) at one operating point with sealed air, if the model has a force.
    fn stiffness_n_mm(&self, _at: &ForceInput<f64>, _pressures_kpa: [f64; 2]) -> Option<f64> {
        None
    }

    /// The sealed masses of a recording by the model's own gas law, if it has one.
    fn masses(&self, _recording: &Recording) -> Option<SealedMasses> {
        None
    }

    /// The reflected mass m (kg) that belongs to the force.
    fn mass_kg(&self) -> Option<f64> {
        None
    }

    /// Results of the fit as JSON, for people and scripts.
    fn details(&self) -> serde_json::Value;

    /// The fitted numbers as named arrays, for a file.
    fn arrays(&self) -> BTreeMap<String, Array>;
}

/// A way to make a model.
///
/// ```
/// use pam_baselines::spring_damper::LinearJoint;
/// use pam_baselines::{FreeRun, Method, TrainingSet};
/// use pam_core::{JointModel, SpringDamper};
/// use pam_data::{Recording, subjects};
/// use pam_trajectory::{Predictor, SolverSettings};
///
/// let truth = JointModel::datasheet(SpringDamper::<f64>::published());
/// let settings = SolverSettings::default();
/// let mut measured = Vec::new();
/// for kpa in [[308.0, 412.0], [412.0, 412.0], [515.0, 412.0]] {
///     let masses = truth.gas_law_masses(0.0, kpa);
///     let time_s = (0..2000).map(|k| 2e-3 * f64::from(k)).collect();
///     let pushed = Recording::at_rest("a", time_s, kpa)
///         .with_force(|t| 1e5 * ((6.0 * t).sin() + (17.0 * t).sin()));
///     measured.push(truth.predict(&pushed, masses, &settings)?.to_recording(&pushed, masses));
/// }
///
/// let subjects = subjects(measured, &truth)?;
/// let training = TrainingSet { subjects: &subjects, surfaces: None, seed: 1 };
/// let fitted = LinearJoint {}.fit(&training, &|_share| true)?;
/// let run = &subjects[0];
/// let predicted = FreeRun(&*fitted).predict(&run.recording, run.masses, &settings)?;
/// let r2 = pam_trajectory::metrics::r2(&run.recording.displacement_mm, &predicted.channels.x);
/// assert!(r2 > 0.99, "{r2}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no method to compare",
    note = "implement `Method`: `title` and `fit`; see `pam-baselines/examples/own_baseline.rs`"
)]
pub trait Method: Sync {
    /// Name in tables.
    fn title(&self) -> String;

    /// Checks the settings.
    ///
    /// # Errors
    /// The problem and its remedy.
    fn check(&self) -> Result<(), String> {
        Ok(())
    }

    /// The content of the files that the settings name, if they name any: it distinguishes one fit from another
    /// besides the settings.
    fn content_of_files(&self) -> Option<String> {
        None
    }

    /// Fits the model. `progress` gets the share that is done, from 0 to 1, and returns whether to go
    /// on.
    ///
    /// # Errors
    /// [`BaselineError`] if the data do not allow a fit; [`BaselineError::Interrupted`].
    fn fit(
        &self,
        training: &TrainingSet<'_>,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Box<dyn FittedModel>, BaselineError>;
}

/// Tells progress and stops where it is asked to.
pub(crate) fn go_on(
    progress: &(dyn Fn(f64) -> bool + Sync),
    share: f64,
) -> Result<(), BaselineError> {
    if progress(share) { Ok(()) } else { Err(BaselineError::Interrupted) }
}

/// A fitted model as a [`Predictor`] from the first sample, for [`pam_train::evaluate_with`]. Pressures
/// that the model does not have are those measured.
pub struct FreeRun<'a>(pub &'a dyn FittedModel);

impl Predictor for FreeRun<'_> {
    fn predict(
        &self,
        recording: &Recording,
        masses: SealedMasses,
        _settings: &SolverSettings,
    ) -> Result<Prediction, Box<PredictError>> {
        let run = Run { recording, masses, start: 0 };
        let statistics = pam_solvers::Statistics::default();
        match self.0.simulate(&run) {
            Ok(mut channels) => {
                for (own, measured) in [
                    (&mut channels.pf, &recording.pressure_flexor_kpa),
                    (&mut channels.pe, &recording.pressure_extensor_kpa),
                ] {
                    if own.is_empty() {
                        own.clone_from(measured);
                    }
                }
                Ok(Prediction { channels, statistics })
            }
            Err(stopped) => Err(Box::new(PredictError {
                name: recording.name.clone(),
                why: stopped.why,
                partial: Prediction { channels: PerChannel::default(), statistics },
            })),
        }
    }
}

/// The largest displacement (mm) that counts as a motion of the joint; past it a prediction has diverged.
pub const LARGEST_DISPLACEMENT_MM: f64 = 100.0;

/// True for a displacement outside the range of the joint, and for NaN.
pub(crate) fn out_of_range(x_mm: f64) -> bool {
    x_mm.is_nan() || x_mm.abs() >= LARGEST_DISPLACEMENT_MM
}

/// True if a number is positive; false for NaN.
pub(crate) fn is_positive(value: f64) -> bool {
    value > 0.0
}

/// A prediction that left the range of the joint.
pub(crate) fn diverged(run: &Run<'_>, sample: usize, x: f64) -> Stopped {
    Stopped {
        why: format!(
            "x = {x:.3e} mm at t = {:.3} s: the prediction diverges",
            run.recording.time_s[(run.start + sample).min(run.recording.len() - 1)]
        ),
    }
}
