//! The fast path: a network force, sealed chambers, the discrete adjoint in lanes.

use super::pressures::{GasCotangents, SealedGas};
use super::{GradientStatistics, JointGradient};
use crate::loss::TrajectoryLoss;
use crate::predict::{SolverSettings, StepChoice, exact_problem};
use pam_autodiff::batch::SealedMotion;
use pam_autodiff::batch::sealed_motion::{DAMPING, MASS};
use pam_core::simd::Float;
use pam_core::{Activation, JointModel, NetworkForce, RawParameters, Scalar, SealedMasses};
use pam_data::Recording;
use pam_data::Subject;
use pam_exact::{ExactGradient, ExactMotion, ExactSolver};
use pam_solvers::input::InputError;
use pam_solvers::{
    BatchGradient, BatchWorkspace, BatchedIntegrator, ConstantStep, FailureKind, PidController,
    SampledInput, StepController, TrajectoryFailure, TrajectoryProblem,
};
use std::sync::Mutex;

/// Value and gradient of a loss over recordings, again and again for changing models. Keeps its
/// memory between calls; the network runs in `T`, everything else in doubles.
///
/// With [`StepChoice::Exact`] steps and derivatives are in closed form, and everything runs in doubles.
/// Under error control the tolerances hold for the motion `[x, ẋ]`; the pressures follow from it
/// exactly.
#[derive(Debug)]
pub struct SealedGradient<T: Float> {
    settings: SolverSettings,
    memory: BatchWorkspace<SealedMotion<T>>,
    exact: ExactSolver,
    gas: GasBuffers,
}

/// A loss of one recording, by its index: as
/// [`value_and_cotangents`](TrajectoryLoss::value_and_cotangents) with the index in front.
pub type IndexedLoss<'a> =
    dyn Fn(usize, &Recording, &[[f64; 4]], &mut [[f64; 4]]) -> f64 + Sync + 'a;

/// A loss that is the same for all recordings.
fn of_any_index(
    loss: &dyn TrajectoryLoss,
) -> impl Fn(usize, &Recording, &[[f64; 4]], &mut [[f64; 4]]) -> f64 + Sync {
    move |_, measured, predicted, cotangents| {
        loss.value_and_cotangents(measured, predicted, cotangents)
    }
}

fn measured_starts(subjects: &[Subject]) -> Vec<[f64; 4]> {
    subjects.iter().map(|s| s.recording.initial_state()).collect()
}

/// Memory for full states and their cotangents.
#[derive(Debug, Default)]
struct GasBuffers {
    recordings: Vec<Mutex<RecordingGas>>,
    /// Cotangents of full states, one buffer for each thread at work: they are of no use afterwards, and
    /// memory that is used again at once is fast.
    cotangents: Mutex<Vec<Vec<[f64; 4]>>>,
}

/// Full states of one recording, and what its pressures give.
#[derive(Debug, Default)]
struct RecordingGas {
    states: Vec<[f64; 4]>,
    gas: GasCotangents,
}

/// The loss of an observed motion `[times, (x, ẋ)]`: pressures are added, and their cotangents pulled
/// back.
fn observed_loss<'a>(
    buffers: &'a GasBuffers,
    model: &'a JointModel<f64, NetworkForce<f64>>,
    subjects: &'a [Subject],
    starts: &'a [[f64; 4]],
    loss: &'a IndexedLoss<'_>,
    backward: bool,
) -> impl Fn(usize, &[f64], &mut [f64]) -> f64 + Sync + 'a {
    move |index, observed, cotangents| {
        let subject = &subjects[index];
        let measured = &subject.recording;
        let gas = SealedGas::new(model, subject.masses, starts[index]);
        let mut own = buffers.recordings[index].lock().expect("no loss panics");
        own.states.resize(measured.len(), [0.0; 4]);
        gas.complete(observed, &mut own.states);
        let spare = || buffers.cotangents.lock().expect("no loss panics");
        let mut of_states = spare().pop().unwrap_or_default();
        of_states.resize(measured.len(), [0.0; 4]);
        let value = loss(index, measured, &own.states, &mut of_states);
        if backward {
            own.gas = gas.pull_back(observed, &of_states, cotangents);
        }
        spare().push(of_states);
        value
    }
}

/// A gradient in closed form in the layout of batched trajectories. Its segments count as steps, its region
/// crossings as evaluations and its regions as linearised points.
fn as_batch(exact: ExactGradient) -> BatchGradient {
    let mut shared = exact.network;
    shared.extend([exact.mass, exact.damping]);
    BatchGradient {
        value: exact.value,
        values: exact.values,
        shared,
        own: exact.masses.iter().map(|g| g.to_vec()).collect(),
        initial_state: exact.initial_states.iter().map(|g| g.to_vec()).collect(),
        failures: exact.failures,
        accepted: exact.statistics.segments,
        rejected: 0,
        evaluations: exact.statistics.crossings,
        linearised: exact.statistics.regions,
        stored_bytes: exact.stored_bytes,
    }
}

/// The gradient of a request that no recording can meet.
fn refused(
    model: &JointModel<f64, NetworkForce<f64>>,
    subjects: &[Subject],
    why: &str,
) -> BatchGradient {
    let failure = |problem: usize| TrajectoryFailure {
        problem,
        kind: FailureKind::Request(why.to_owned()),
        time_s: subjects[problem].recording.span_s().0,
    };
    BatchGradient {
        values: vec![f64::NAN; subjects.len()],
        shared: vec![0.0; model.force.mlp().parameter_count() + 2],
        own: vec![vec![0.0; 2]; subjects.len()],
        initial_state: vec![vec![0.0; 2]; subjects.len()],
        failures: (0..subjects.len()).map(failure).collect(),
        ..BatchGradient::default()
    }
}

impl<T: Float> SealedGradient<T> {
    /// Gradients by the given method, steps and reading of the input.
    #[must_use]
    pub fn new(settings: SolverSettings) -> Self {
        Self {
            settings,
            memory: BatchWorkspace::default(),
            exact: ExactSolver::new(),
            gas: GasBuffers::default(),
        }
    }

    /// Value and gradient of the mean loss of `model` over `subjects`, each predicted from its first
    /// sample, on all threads of the current pool. The result is the same bits at any number of
    /// threads.
    ///
    /// # Errors
    /// [`InputError`] if a recording has no samples or its times do not increase.
    pub fn value_and_gradient(
        &mut self,
        model: &JointModel<f64, NetworkForce<f64>>,
        subjects: &[Subject],
        loss: &dyn TrajectoryLoss,
    ) -> Result<JointGradient, InputError> {
        let starts = measured_starts(subjects);
        self.run(model, subjects, &starts, &of_any_index(loss), true)
    }

    /// As [`value_and_gradient`](Self::value_and_gradient), with the recordings predicted from states
    /// of the caller's (mm, mm/s, kPa, kPa), and a loss that knows the index of the recording.
    ///
    /// # Errors
    /// As [`value_and_gradient`](Self::value_and_gradient).
    ///
    /// # Panics
    /// If there are not as many starts as recordings.
    pub fn value_and_gradient_from(
        &mut self,
        model: &JointModel<f64, NetworkForce<f64>>,
        subjects: &[Subject],
        starts: &[[f64; 4]],
        loss: &IndexedLoss<'_>,
    ) -> Result<JointGradient, InputError> {
        self.run(model, subjects, starts, loss, true)
    }

    /// As [`value_and_gradient_from`](Self::value_and_gradient_from) without the gradient, which is
    /// of no meaning in the result.
    ///
    /// # Errors
    /// As [`value_and_gradient`](Self::value_and_gradient).
    ///
    /// # Panics
    /// If there are not as many starts as recordings.
    pub fn values_from(
        &mut self,
        model: &JointModel<f64, NetworkForce<f64>>,
        subjects: &[Subject],
        starts: &[[f64; 4]],
        loss: &IndexedLoss<'_>,
    ) -> Result<JointGradient, InputError> {
        self.run(model, subjects, starts, loss, false)
    }

    /// The mean loss alone.
    ///
    /// # Errors
    /// As [`value_and_gradient`](Self::value_and_gradient).
    pub fn value(
        &mut self,
        model: &JointModel<f64, NetworkForce<f64>>,
        subjects: &[Subject],
        loss: &dyn TrajectoryLoss,
    ) -> Result<f64, InputError> {
        let starts = measured_starts(subjects);
        Ok(self.run(model, subjects, &starts, &of_any_index(loss), false)?.value)
    }

    fn run(
        &mut self,
        model: &JointModel<f64, NetworkForce<f64>>,
        subjects: &[Subject],
        starts: &[[f64; 4]],
        loss: &IndexedLoss<'_>,
        backward: bool,
    ) -> Result<JointGradient, InputError> {
        let tableau = self.settings.tableau.clone();
        match self.settings.step {
            StepChoice::Exact => Ok(self.exact(model, subjects, starts, loss, backward)),
            StepChoice::Constant { step_s } => {
                let lanes = BatchedIntegrator::new(tableau, ConstantStep::new(step_s));
                self.with_lanes(&lanes, model, subjects, starts, loss, backward)
            }
            StepChoice::Adaptive { rtol, atol } => {
                let lanes = BatchedIntegrator::new(tableau, PidController::new(rtol, atol));
                self.with_lanes(&lanes, model, subjects, starts, loss, backward)
            }
        }
    }

    fn with_lanes<C: StepController + Sync>(
        &mut self,
        lanes: &BatchedIntegrator<C>,
        model: &JointModel<f64, NetworkForce<f64>>,
        subjects: &[Subject],
        starts: &[[f64; 4]],
        loss: &IndexedLoss<'_>,
        backward: bool,
    ) -> Result<JointGradient, InputError> {
        assert_eq!(starts.len(), subjects.len(), "one start for each recording");
        let motion = SealedMotion::<T, Activation>::new(model, &model.force);
        let problems = subjects
            .iter()
            .zip(starts)
            .map(|(s, y0)| {
                let r = &s.recording;
                let (t0, t1) = r.span_s();
                Ok(TrajectoryProblem {
                    condition: motion.condition(s.masses),
                    input: SampledInput::new(&r.time_s, &r.force_mn, self.settings.interpolation)?,
                    t0,
                    t1,
                    y0: vec![y0[0], y0[1]],
                    observe_s: &r.time_s,
                })
            })
            .collect::<Result<Vec<_>, InputError>>()?;
        self.reserve(subjects.len());
        let gradient = {
            let one = observed_loss(&self.gas, model, subjects, starts, loss, backward);
            let memory = &mut self.memory;
            if backward {
                lanes.value_and_gradient(&motion, &problems, &one, memory)
            } else {
                lanes.value(&motion, &problems, &one, memory)
            }
        };
        Ok(self.assemble(model, gradient))
    }

    /// As [`with_lanes`](Self::with_lanes), in closed form. A force that is not a ReLU network is
    /// a failure of every recording.
    fn exact(
        &mut self,
        model: &JointModel<f64, NetworkForce<f64>>,
        subjects: &[Subject],
        starts: &[[f64; 4]],
        loss: &IndexedLoss<'_>,
        backward: bool,
    ) -> JointGradient {
        assert_eq!(starts.len(), subjects.len(), "one start for each recording");
        self.reserve(subjects.len());
        let gradient = match ExactMotion::new(model) {
            Ok(motion) => {
                let problems: Vec<_> = subjects
                    .iter()
                    .zip(starts)
                    .map(|(s, y0)| exact_problem(&s.recording, s.masses, &self.settings, *y0))
                    .collect();
                let one = observed_loss(&self.gas, model, subjects, starts, loss, backward);
                let gradient = if backward {
                    self.exact.value_and_gradient(&motion, &problems, &one)
                } else {
                    self.exact.value(&motion, &problems, &one)
                };
                as_batch(gradient)
            }
            Err(why) => refused(model, subjects, &why.to_string()),
        };
        self.assemble(model, gradient)
    }

    /// Makes room for the pressures of this many recordings.
    fn reserve(&mut self, recordings: usize) {
        if self.gas.recordings.len() < recordings {
            self.gas.recordings.resize_with(recordings, Mutex::default);
        }
    }

    /// Joins the motion's gradient with that of the pressures.
    fn assemble(
        &mut self,
        model: &JointModel<f64, NetworkForce<f64>>,
        gradient: BatchGradient,
    ) -> JointGradient {
        let failed = |i: usize| gradient.failures.iter().any(|f| f.problem == i);
        let predicted = gradient.values.len() - gradient.failures.len();
        let mean = 1.0 / predicted.max(1) as f64;
        let gas: Vec<GasCotangents> = self
            .gas
            .recordings
            .iter_mut()
            .zip(0..gradient.values.len())
            .map(|(own, i)| {
                if failed(i) {
                    GasCotangents::default()
                } else {
                    own.get_mut().expect("no loss panics").gas
                }
            })
            .collect();
        let (network, physical) = gradient.shared.split_at(gradient.shared.len() - 2);
        let sum = |part: fn(&GasCotangents) -> f64| gas.iter().map(part).sum::<f64>();
        let masses = gradient.own.iter().zip(&gas).map(|(own, gas)| SealedMasses {
            flexor_g: mean * (own[0] + gas.masses[0]),
            extensor_g: mean * (own[1] + gas.masses[1]),
        });
        let initial_states = gradient.initial_state.iter().zip(&gas).map(|(own, gas)| {
            let state = [own[0] + gas.start_mm, own[1], gas.start_kpa[0], gas.start_kpa[1]];
            state.map(|g| mean * g)
        });
        JointGradient {
            extension: Vec::new(),
            value: mean * gradient.value,
            force: network.iter().map(|g| mean * g).collect(),
            // d softplus(r)/dr is the logistic function.
            raw: RawParameters {
                mass: mean * physical[MASS] * model.raw.mass.sigmoid(),
                gas_coefficient: mean
                    * sum(|g| g.gas_coefficient)
                    * model.raw.gas_coefficient.sigmoid(),
                deformation: mean * sum(|g| g.deformation) * model.raw.deformation.sigmoid(),
            },
            auxiliary_damping: mean * physical[DAMPING],
            masses: masses.collect(),
            initial_states: initial_states.collect(),
            states: Vec::new(),
            statistics: GradientStatistics {
                accepted: gradient.accepted,
                rejected: gradient.rejected,
                evaluations: gradient.evaluations,
                pullbacks: gradient.linearised,
                stored_bytes: gradient.stored_bytes,
            },
            values: gradient.values,
            failures: gradient.failures,
        }
    }

    /// The predicted states `[x, ẋ, P_f, P_e]` of a recording at its sample times, from the last call;
    /// of no meaning if its prediction stopped early.
    ///
    /// # Panics
    /// If there was no such recording.
    pub fn predicted(&mut self, index: usize) -> &[[f64; 4]] {
        &self.gas.recordings[index].get_mut().expect("no loss panics").states
    }
}
