//! Free-run prediction of a recording.

use crate::engine::pressures::SealedGas;
use crate::metrics::PerChannel;
use pam_core::{ForceModel, JointModel, ModelError, SealedMasses};
use pam_data::Recording;
use pam_exact::{ExactMotion, ExactProblem, ExactSolver, ForceSignal, ReluNetwork};
use pam_solvers::{
    ConstantStep, FailureKind, Integrator, Interpolation, PidController, SampledInput, SaveAt,
    Solution, Statistics, StepBudget, StepController, Tableau, Term,
};
use pam_surrogate::{SurrogateProblem, SurrogateSolver};
use serde::Serialize;
use std::sync::Arc;
use thiserror::Error;

/// How steps are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum StepChoice {
    /// Steps of one size.
    Constant {
        /// Step size, s.
        step_s: f64,
    },
    /// Steps under error control.
    Adaptive {
        /// Relative tolerance.
        rtol: f64,
        /// Absolute tolerance, in the units of the states.
        atol: f64,
    },
    /// No steps: closed-form segments of a (leaky) ReLU network (see [`pam_exact`]). Of the settings only
    /// the reading of the input counts, and it may not be cubic.
    Exact,
    /// Steps on a piecewise polynomial of a smooth force (see [`pam_surrogate`]), at its default accuracy. Of the settings only
    /// the reading of the input counts, and it may not be cubic.
    Surrogate,
    /// As [`Surrogate`](Self::Surrogate) where a polynomial follows the force within its error bound, elsewhere steps under error
    /// control: the [statistics](Prediction::statistics) of a prediction count evaluations of the field then.
    SurrogateElse {
        /// Relative tolerance of the steps.
        rtol: f64,
        /// Absolute tolerance of the steps, in the units of the states.
        atol: f64,
    },
}

impl StepChoice {
    /// The step control, or `None` if there are no steps.
    #[must_use]
    pub fn controller(&self) -> Option<Arc<dyn StepController>> {
        match *self {
            Self::Exact | Self::Surrogate => None,
            Self::Constant { step_s } => Some(Arc::new(ConstantStep::new(step_s))),
            Self::Adaptive { rtol, atol } | Self::SurrogateElse { rtol, atol } => {
                Some(Arc::new(PidController::new(rtol, atol)))
            }
        }
    }
}

/// With which method, steps and reading of the input a recording is predicted.
///
/// ```
/// use pam_solvers::{Interpolation, Tableau};
/// use pam_trajectory::{SolverSettings, StepChoice};
///
/// let settings = SolverSettings {
///     tableau: Tableau::rk4(),
///     step: StepChoice::Constant { step_s: 5e-3 },
///     interpolation: Interpolation::Linear,
/// };
/// assert_eq!(settings.describe(), "rk4, constant steps of 5 ms; the force is linear between samples");
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SolverSettings {
    /// The method.
    pub tableau: Tableau,
    /// How steps are chosen.
    pub step: StepChoice,
    /// How the measured force is read between samples.
    pub interpolation: Interpolation,
}

impl Default for SolverSettings {
    /// Tsit5 at rtol = atol = 1e-6 with a zero-order hold, the input of the published path done exactly.
    fn default() -> Self {
        Self {
            tableau: Tableau::tsit5(),
            step: StepChoice::Adaptive { rtol: 1e-6, atol: 1e-6 },
            interpolation: Interpolation::Hold,
        }
    }
}

impl SolverSettings {
    /// The exact method with this reading of the force.
    #[must_use]
    pub fn exact(interpolation: Interpolation) -> Self {
        Self { step: StepChoice::Exact, interpolation, ..Self::default() }
    }

    /// Steps on a surrogate of the force, with this reading of the measured one.
    #[must_use]
    pub fn surrogate(interpolation: Interpolation) -> Self {
        Self { step: StepChoice::Surrogate, interpolation, ..Self::default() }
    }

    /// Steps on a surrogate of the force where it holds its error bound, else those of these settings.
    #[must_use]
    pub fn surrogate_first(&self) -> Self {
        let step = match self.step {
            StepChoice::Adaptive { rtol, atol } => StepChoice::SurrogateElse { rtol, atol },
            other => other,
        };
        Self { step, ..self.clone() }
    }

    /// The settings that `auto` predicts with: [`surrogate_first`](Self::surrogate_first) where surrogates
    /// [apply](Self::surrogate_applies_to), else these.
    #[must_use]
    pub fn for_prediction_of(self, force: &impl ForceModel<f64>) -> Self {
        if self.surrogate_applies_to(force) { self.surrogate_first() } else { self }
    }

    /// Whether surrogates apply to a force that is read as in these settings: a network that is not piecewise affine. How closely
    /// they follow it, the solver finds out.
    #[must_use]
    pub fn surrogate_applies_to(&self, force: &impl ForceModel<f64>) -> bool {
        self.interpolation != Interpolation::Cubic
            && force.network().is_some()
            && !ReluNetwork::applies_to(force)
    }

    /// Whether the exact method applies to a force that is read as in these settings.
    #[must_use]
    pub fn exact_applies_to(&self, force: &impl ForceModel<f64>) -> bool {
        self.interpolation != Interpolation::Cubic && ReluNetwork::applies_to(force)
    }

    /// The largest number of steps. `None` for the exact method and surrogates, which have limits of their own.
    #[must_use]
    pub fn step_budget(&self) -> Option<StepBudget> {
        match self.step {
            StepChoice::Adaptive { rtol, atol } | StepChoice::SurrogateElse { rtol, atol } => {
                Some(StepBudget::at_tolerance(rtol.min(atol)))
            }
            StepChoice::Constant { .. } => Some(StepBudget::CONSTANT),
            StepChoice::Exact | StepChoice::Surrogate => None,
        }
    }

    /// The settings in one line, for reports.
    #[must_use]
    pub fn describe(&self) -> String {
        let step = match self.step {
            StepChoice::Exact => {
                return format!("the closed form; {}", force_between_samples(self.interpolation));
            }
            StepChoice::Surrogate => {
                return format!(
                    "polynomial surrogates of the network; {}",
                    force_between_samples(self.interpolation)
                );
            }
            StepChoice::SurrogateElse { rtol, atol } => {
                return format!(
                    "polynomial surrogates of the network, or {} (rtol {rtol:e}, atol {atol:e}) where it bends too sharply; {}",
                    self.tableau.name,
                    force_between_samples(self.interpolation)
                );
            }
            StepChoice::Constant { step_s } => format!("constant steps of {} ms", step_s * 1e3),
            StepChoice::Adaptive { rtol, atol } => {
                format!("adaptive, rtol {rtol:e}, atol {atol:e}")
            }
        };
        format!("{}, {step}; {}", self.tableau.name, force_between_samples(self.interpolation))
    }
}

/// A predicted trajectory at the sample times of a recording.
#[derive(Debug, Clone)]
pub struct Prediction {
    /// Predicted channels: mm, mm/s, kPa, kPa.
    pub channels: PerChannel<Vec<f64>>,
    /// Steps and evaluations of the solve.
    pub statistics: Statistics,
}

impl Prediction {
    fn from_solution(solution: &Solution<f64>) -> Self {
        let column = |i| solution.component(i).collect();
        Self {
            channels: PerChannel { x: column(0), v: column(1), pf: column(2), pe: column(3) },
            statistics: solution.statistics,
        }
    }

    /// Every `stride`-th sample, from the first one on.
    ///
    /// # Panics
    /// If the stride is 0.
    #[must_use]
    pub fn every(&self, stride: usize) -> Self {
        let of = |channel: &Vec<f64>| channel.iter().step_by(stride).copied().collect();
        let c = &self.channels;
        Self {
            channels: PerChannel { x: of(&c.x), v: of(&c.v), pf: of(&c.pf), pe: of(&c.pe) },
            statistics: self.statistics,
        }
    }

    fn truncate(&mut self, len: usize) {
        let c = &mut self.channels;
        for channel in [&mut c.x, &mut c.v, &mut c.pf, &mut c.pe] {
            channel.truncate(len);
        }
    }

    /// Number of predicted samples.
    #[must_use]
    pub fn len(&self) -> usize {
        self.channels.x.len()
    }

    /// Whether nothing was predicted.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The prediction as a recording: predicted channels with the measured force.
    #[must_use]
    pub fn to_recording(&self, measured: &Recording, masses: SealedMasses) -> Recording {
        Recording {
            time_s: measured.time_s[..self.len()].to_vec(),
            displacement_mm: self.channels.x.clone(),
            velocity_mm_s: self.channels.v.clone(),
            pressure_flexor_kpa: self.channels.pf.clone(),
            pressure_extensor_kpa: self.channels.pe.clone(),
            force_mn: measured.force_mn[..self.len()].to_vec(),
            given_masses: Some(masses),
            preprocessing: "predicted".into(),
            ..measured.without_samples()
        }
    }
}

/// A prediction that stopped early.
#[derive(Debug, Clone, Error)]
#[error("{name}: {why}")]
pub struct PredictError {
    /// Name of the recording.
    pub name: String,
    /// Why it stopped.
    pub why: String,
    /// The prediction until then.
    pub partial: Prediction,
}

/// A model that predicts a recording from its first sample: a joint model, or one with effects.
///
/// ```
/// use pam_core::{JointModel, SpringDamper};
/// use pam_data::{Recording, Subject};
/// use pam_trajectory::{Predictor, SolverSettings};
///
/// let model = JointModel::datasheet(SpringDamper::published());
/// let time_s = (0..2000).map(|k| 1e-3 * f64::from(k)).collect();
/// let measured = Recording::at_rest("a", time_s, [412.0, 412.0]).with_force(|_t| 1e5); // 100 N
/// let subject = Subject::of(measured, &model)?;
/// let prediction = model.predict(&subject.recording, subject.masses, &SolverSettings::default())?;
/// let end_mm = prediction.channels.x[1999];
/// assert!((0.5..0.8).contains(&end_mm), "{end_mm}");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not predict recordings",
    label = "a predictor is needed here",
    note = "a `JointModel` of any force model predicts, and an `ExtendedModel`; implement `Predictor` for others"
)]
pub trait Predictor: Sync {
    /// The prediction at the recording's sample times, driven by its measured force alone.
    ///
    /// # Errors
    /// [`PredictError`] with the recording's name, the time and what was predicted until then.
    fn predict(
        &self,
        recording: &Recording,
        masses: SealedMasses,
        settings: &SolverSettings,
    ) -> Result<Prediction, Box<PredictError>>;
}

impl<F: ForceModel<f64> + Sync> Predictor for JointModel<f64, F> {
    fn predict(
        &self,
        recording: &Recording,
        masses: SealedMasses,
        settings: &SolverSettings,
    ) -> Result<Prediction, Box<PredictError>> {
        predict(self, recording, masses, settings)
    }
}

/// Predicts a recording from its first sample, driven by its measured force alone.
///
/// # Errors
/// [`PredictError`] with the recording's name, the time and the partial trajectory, if the solve fails
/// or the joint leaves the range in which both chambers have a volume.
pub fn predict<F: ForceModel<f64>>(
    model: &JointModel<f64, F>,
    recording: &Recording,
    masses: SealedMasses,
    settings: &SolverSettings,
) -> Result<Prediction, Box<PredictError>> {
    predict_from(model, recording, masses, settings, recording.initial_state())
}

/// As [`predict`], from the state `y0`.
pub(crate) fn predict_from<F: ForceModel<f64>>(
    model: &JointModel<f64, F>,
    recording: &Recording,
    masses: SealedMasses,
    settings: &SolverSettings,
    y0: [f64; 4],
) -> Result<Prediction, Box<PredictError>> {
    let fail = |why: String, partial: Prediction| {
        Box::new(PredictError { name: recording.name.clone(), why, partial })
    };
    let nothing =
        || Prediction { channels: PerChannel::default(), statistics: Statistics::default() };
    let times = &recording.time_s;
    let input = SampledInput::new(times, &recording.force_mn, settings.interpolation)
        .map_err(|e| fail(e.to_string(), nothing()))?;
    let else_steps = matches!(settings.step, StepChoice::SurrogateElse { .. });
    if else_steps || settings.step == StepChoice::Surrogate {
        let problem = surrogate_problem(recording, masses, settings.interpolation, y0);
        let (motion, stopped) = SurrogateSolver::default().trajectory(model, &problem);
        let reached = stopped.as_ref().map_or(f64::INFINITY, |(_, time_s)| *time_s);
        let prediction = with_pressures(model, recording, masses, y0, &motion, reached);
        match stopped {
            None => return within_limits(model, recording, prediction),
            Some((FailureKind::Request(_), _)) if else_steps => {}
            Some((kind, time_s)) => return Err(fail(kind.describe(time_s), prediction)),
        }
    }
    let Some(controller) = settings.step.controller() else {
        let (prediction, stopped) = exact(model, recording, masses, settings.interpolation, y0)
            .map_err(|e| fail(e.to_string(), nothing()))?;
        return match stopped {
            None => within_limits(model, recording, prediction),
            Some(why) => Err(fail(why, prediction)),
        };
    };
    let term = Term::new(model.sealed(masses), input);
    let (t0, t1) = recording.span_s();
    let save = SaveAt::Times(times);
    let tableau = settings.tableau.clone();
    let mut integrator = Integrator::new(tableau, controller);
    if let Some(budget) = settings.step_budget() {
        let most = budget.steps(t1 - t0, recording.len());
        integrator = integrator.with_max_steps(most).with_step_budget(budget);
    }
    match integrator.solve(&term, t0, t1, &y0, save) {
        Ok(solution) => within_limits(model, recording, Prediction::from_solution(&solution)),
        Err(e) => Err(fail(e.to_string(), Prediction::from_solution(&e.partial))),
    }
}

/// Passes on a prediction that stays where both chambers have a volume. Past the limit the cylinder
/// model has no chamber left; the equations would go on.
fn within_limits<F>(
    model: &JointModel<f64, F>,
    recording: &Recording,
    mut prediction: Prediction,
) -> Result<Prediction, Box<PredictError>> {
    let limit = model.geometry.displacement_limit_mm(model.physical().deformation);
    match prediction.channels.x.iter().position(|x| x.abs() >= limit) {
        None => Ok(prediction),
        Some(i) => {
            let why = format!(
                "x = {:.1} mm at t = {:.4} s is past ±{limit:.1} mm, where a chamber has no volume \
                 left; the force or the model is not of this joint",
                prediction.channels.x[i], recording.time_s[i]
            );
            prediction.truncate(i);
            Err(Box::new(PredictError { name: recording.name.clone(), why, partial: prediction }))
        }
    }
}

/// A motion `[x, ẋ]` at the sample times with its pressures, until the time that was reached.
fn with_pressures<F: ForceModel<f64>>(
    model: &JointModel<f64, F>,
    recording: &Recording,
    masses: SealedMasses,
    y0: [f64; 4],
    motion: &[f64],
    reached_s: f64,
) -> Prediction {
    let mut states = vec![[0.0; 4]; recording.len()];
    SealedGas::new(model, masses, y0).complete(motion, &mut states);
    let column = |c: usize| states.iter().map(|y| y[c]).collect();
    let mut prediction = Prediction {
        channels: PerChannel { x: column(0), v: column(1), pf: column(2), pe: column(3) },
        statistics: Statistics::default(),
    };
    prediction.truncate(recording.time_s.partition_point(|&t| t <= reached_s));
    prediction
}

/// The exact prediction, and why it stopped early if it did.
fn exact<F: ForceModel<f64>>(
    model: &JointModel<f64, F>,
    recording: &Recording,
    masses: SealedMasses,
    interpolation: Interpolation,
    y0: [f64; 4],
) -> Result<(Prediction, Option<String>), ModelError> {
    let motion = ExactMotion::new(model)?;
    let problem = exact_problem(recording, masses, interpolation, y0);
    let mut solver = ExactSolver::new();
    let failures = solver.solve(&motion, &[problem]);
    let counts = solver.statistics(0);
    let reached = failures.first().map_or(f64::INFINITY, |f| f.time_s);
    let mut prediction = with_pressures(model, recording, masses, y0, solver.observed(0), reached);
    prediction.statistics.accepted = counts.segments;
    let stopped = failures.first().map(|f| f.kind.describe(f.time_s));
    Ok((prediction, stopped))
}

/// The measured force of a recording.
fn force_signal(recording: &Recording, interpolation: Interpolation) -> ForceSignal<'_> {
    ForceSignal { times_s: &recording.time_s, force_mn: &recording.force_mn, interpolation }
}

/// The problem of the exact solver for a recording that starts at `y0`.
pub(crate) fn exact_problem<'a>(
    recording: &'a Recording,
    masses: SealedMasses,
    interpolation: Interpolation,
    y0: [f64; 4],
) -> ExactProblem<'a> {
    let (t0, t1) = recording.span_s();
    ExactProblem {
        masses,
        signal: force_signal(recording, interpolation),
        t0,
        t1,
        y0: [y0[0], y0[1]],
        observe_s: &recording.time_s,
    }
}

/// The problem of the surrogate solver for a recording that starts at `y0`.
pub(crate) fn surrogate_problem<'a>(
    recording: &'a Recording,
    masses: SealedMasses,
    interpolation: Interpolation,
    y0: [f64; 4],
) -> SurrogateProblem<'a> {
    let (t0, t1) = recording.span_s();
    SurrogateProblem {
        masses,
        signal: force_signal(recording, interpolation),
        t0,
        t1,
        y0: [y0[0], y0[1]],
        observe_s: &recording.time_s,
        expected: [&recording.displacement_mm, &recording.velocity_mm_s],
    }
}

/// How the measured force goes between its samples, in words.
fn force_between_samples(interpolation: Interpolation) -> &'static str {
    match interpolation {
        Interpolation::Hold => "the force is a zero-order hold",
        Interpolation::Linear => "the force is linear between samples",
        Interpolation::Ramp => "the force is linear between the middles of the sampling intervals",
        Interpolation::Cubic => "the force is cubic between samples",
    }
}
