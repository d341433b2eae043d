//! Any force model and any gradient method: the joint's four states, recording by recording.

use super::sealed::IndexedLoss;
use super::{GradientChoice, GradientStatistics, JointGradient};
use crate::loss::TrajectoryLoss;
use crate::predict::{SolverSettings, StepChoice};
use pam_core::{
    JointField, JointModel, ParametricField, ParametricForce, RawParameters, SealedMasses,
};
use pam_data::Recording;
use pam_data::Subject;
use pam_solvers::input::InputError;
use pam_solvers::sensitivity::{Direction, Gradient, MethodSetup, Problem};
use pam_solvers::{
    ConstantStep, FailureKind, Fixed, Integrator, PidController, SampledInput, StepController,
    TrajectoryFailure,
};
use rayon::prelude::*;
use std::ops::Range;

/// Smallest scale of the numbers that differences step by.
const FLOORS: [f64; 3] = [1.0; 3];
/// Numbers that one task differentiates by when each of them costs solves of its own.
const DIRECTIONS_AT_ONCE: usize = 64;

type Field<'a, F> = JointField<f64, &'a F>;
type Force<'a> = Fixed<SampledInput<'a, f64>>;

/// One piece of work: a recording, and where each number to differentiate by costs its own, some of
/// the parameters and initial states.
#[derive(Debug, Clone)]
struct Task {
    subject: usize,
    directions: Range<usize>,
}

impl Task {
    /// The directions of the task; parameters come before the initial states.
    fn list(&self, parameters: usize) -> Vec<Direction> {
        let direction = |i: usize| match i.checked_sub(parameters) {
            None => Direction::Parameter(i),
            Some(state) => Direction::InitialState(state),
        };
        self.directions.clone().map(direction).collect()
    }
}

/// Value and gradient of the mean loss of `model` over `subjects` by any method, each recording
/// predicted from its first sample.
///
/// Works with every force model, in doubles; [`SealedGradient`](super::SealedGradient) is the fast way
/// for networks. Tasks run in parallel, sums are in the order of the recordings. `planned` is called
/// once with the number of tasks, `done` after each.
///
/// # Errors
/// [`InputError`] if a recording has no samples or its times do not increase.
pub fn value_and_gradient<F: ParametricForce + Sync>(
    choice: GradientChoice,
    model: &JointModel<f64, F>,
    subjects: &[Subject],
    settings: &SolverSettings,
    loss: &dyn TrajectoryLoss,
    progress: (&dyn Fn(usize), &(dyn Fn() + Sync)),
) -> Result<JointGradient, InputError> {
    let starts: Vec<[f64; 4]> = subjects.iter().map(|s| s.recording.initial_state()).collect();
    let indexed = |_: usize, measured: &Recording, states: &[[f64; 4]], by: &mut [[f64; 4]]| {
        loss.value_and_cotangents(measured, states, by)
    };
    value_and_gradient_from(choice, model, (subjects, &starts), settings, &indexed, progress)
}

/// As [`value_and_gradient`], with the recordings predicted from states of the caller's (mm, mm/s, kPa,
/// kPa), and a loss that knows the index of the recording.
///
/// # Errors
/// As [`value_and_gradient`].
///
/// # Panics
/// If there are not as many starts as recordings.
pub fn value_and_gradient_from<F: ParametricForce + Sync>(
    choice: GradientChoice,
    model: &JointModel<f64, F>,
    (subjects, starts): (&[Subject], &[[f64; 4]]),
    settings: &SolverSettings,
    loss: &IndexedLoss<'_>,
    (planned, done): (&dyn Fn(usize), &(dyn Fn() + Sync)),
) -> Result<JointGradient, InputError> {
    assert_eq!(subjects.len(), starts.len(), "one start for each recording");
    let force_len = model.force.parameter_len();
    let len = force_len + OWN + STATES;
    // The step control does not matter for that.
    let shared = choice.pays_by_direction::<PidController>();
    let at_once = if shared { DIRECTIONS_AT_ONCE } else { len };
    let tasks: Vec<Task> = (0..subjects.len())
        .flat_map(|subject| {
            (0..len)
                .step_by(at_once)
                .map(move |first| Task { subject, directions: first..(first + at_once).min(len) })
        })
        .collect();
    planned(tasks.len());
    let results = tasks
        .par_iter()
        .with_max_len(1)
        .map(|task| {
            let start = &starts[task.subject];
            let result = one(choice, model, (&subjects[task.subject], start), settings, loss, task);
            done();
            result
        })
        .collect::<Result<Vec<_>, InputError>>()?;
    Ok(assemble(subjects.len(), force_len, &tasks, results))
}

/// Parameters of the joint besides those of its force: raw m, C, ν, then B, m_f, m_e.
const OWN: usize = 6;
/// States of the joint with sealed chambers.
const STATES: usize = 4;

type Outcome = Result<Gradient, TrajectoryFailure>;

fn one<F: ParametricForce>(
    choice: GradientChoice,
    model: &JointModel<f64, F>,
    (subject, start): (&Subject, &[f64; 4]),
    settings: &SolverSettings,
    loss: &IndexedLoss<'_>,
    task: &Task,
) -> Result<Outcome, InputError> {
    let r = &subject.recording;
    let input = Fixed(SampledInput::new(&r.time_s, &r.force_mn, settings.interpolation)?);
    let field = model.sealed(subject.masses);
    let tableau = settings.tableau.clone();
    Ok(match settings.step {
        StepChoice::Exact => Err(TrajectoryFailure {
            problem: task.subject,
            kind: FailureKind::Request(
                "the exact method has a gradient of its own and takes no other method's".into(),
            ),
            time_s: r.span_s().0,
        }),
        StepChoice::Constant { step_s } => {
            let integrator = Integrator::new(tableau, ConstantStep::new(step_s));
            with_integrator(choice, (&field, &input), (r, start), &integrator, loss, task)
        }
        StepChoice::Adaptive { rtol, atol } => {
            let integrator = Integrator::new(tableau, PidController::new(rtol, atol));
            with_integrator(choice, (&field, &input), (r, start), &integrator, loss, task)
        }
    })
}

fn with_integrator<F: ParametricForce, C: StepController + Clone + 'static>(
    choice: GradientChoice,
    (field, input): (&Field<'_, F>, &Force<'_>),
    (measured, start): (&Recording, &[f64; 4]),
    integrator: &Integrator<C>,
    loss: &IndexedLoss<'_>,
    task: &Task,
) -> Outcome {
    let (t0, t1) = measured.span_s();
    let problem =
        Problem { field, input, t0, t1, y0: start, observations_s: &measured.time_s, integrator };
    let setup = MethodSetup {
        integrator: integrator.clone(),
        directions: Some(task.list(field.parameter_len())),
        floors: FLOORS,
    };
    let method = choice.method::<Field<'_, F>, Force<'_>, C>(setup);
    let mut on_states = |_: &[f64], states: &[f64], cotangents: &mut [f64]| {
        let (states, _) = states.as_chunks::<4>();
        let (cotangents, _) = cotangents.as_chunks_mut::<4>();
        loss(task.subject, measured, states, cotangents)
    };
    method.value_and_gradient(&problem, &mut on_states).map_err(|e| TrajectoryFailure {
        problem: task.subject,
        kind: e.kind,
        time_s: e.time_s,
    })
}

fn assemble(
    recordings: usize,
    force_len: usize,
    tasks: &[Task],
    results: Vec<Outcome>,
) -> JointGradient {
    let mut failures: Vec<TrajectoryFailure> = Vec::new();
    for failure in results.iter().filter_map(|r| r.as_ref().err()) {
        if failures.last().is_none_or(|f| f.problem != failure.problem) {
            failures.push(failure.clone());
        }
    }
    let mean = 1.0 / (recordings - failures.len()).max(1) as f64;
    let mut values = vec![f64::NAN; recordings];
    let mut shared = vec![0.0; force_len + 4];
    let mut masses = vec![SealedMasses { flexor_g: 0.0, extensor_g: 0.0 }; recordings];
    let mut initial_states = vec![[0.0; 4]; recordings];
    let mut states = vec![Vec::new(); recordings];
    let mut statistics = GradientStatistics::default();
    for (task, gradient) in tasks.iter().zip(results) {
        let Ok(gradient) = gradient else { continue };
        let i = task.subject;
        if failures.iter().any(|f| f.problem == i) {
            continue;
        }
        // A direction that was not asked for is zero.
        let (joint, air) = gradient.parameters.split_at(force_len + 4);
        for (sum, g) in shared.iter_mut().zip(joint) {
            *sum += mean * g;
        }
        masses[i].flexor_g += mean * air[0];
        masses[i].extensor_g += mean * air[1];
        for (sum, g) in initial_states[i].iter_mut().zip(&gradient.initial_state) {
            *sum += mean * g;
        }
        let s = gradient.statistics;
        statistics.evaluations += s.evaluations;
        statistics.pullbacks += s.vjps + s.jvps;
        statistics.stored_bytes = statistics.stored_bytes.max(s.checkpoint_bytes);
        if values[i].is_nan() {
            values[i] = gradient.value;
            statistics.accepted += s.steps;
            statistics.rejected += s.rejected;
            states[i] = gradient.states.as_chunks::<4>().0.to_vec();
        }
    }
    let raw = &shared[force_len..];
    JointGradient {
        extension: Vec::new(),
        value: mean * values.iter().filter(|v| !v.is_nan()).sum::<f64>(),
        raw: RawParameters { mass: raw[0], gas_coefficient: raw[1], deformation: raw[2] },
        auxiliary_damping: raw[3],
        force: shared[..force_len].to_vec(),
        values,
        masses,
        initial_states,
        failures,
        states,
        statistics,
    }
}
