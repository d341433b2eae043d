//! Any force model and any gradient method: the joint's four states, one recording at a time.

use super::{
    EngineError, GradientChoice, GradientSums, IndexedLoss, TrajectoryEngine, TrajectoryGradient,
    TrajectoryRequest,
};
use crate::predict::{SolverSettings, predict_from};
use pam_core::parallel;
use pam_core::{JointField, ParametricField, ParametricForce};
use pam_data::Recording;
use pam_solvers::sensitivity::{Direction, Gradient, MethodSetup, Problem};
use pam_solvers::{
    FailureKind, Fixed, Integrator, PidController, SampledInput, StepController, TrajectoryFailure,
};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Smallest scale of the numbers that differences step by.
const FLOORS: [f64; 3] = [1.0; 3];
/// Numbers that one task differentiates by when each of them costs solves of its own.
const DIRECTIONS_AT_ONCE: usize = 64;
/// Parameters of the joint besides those of its force: raw m, C, ν, then B, m_f, m_e.
const OWN: usize = 6;
/// States of the joint with sealed chambers.
const STATES: usize = 4;

type Field<'a, F> = JointField<f64, &'a F>;
type Force<'a> = Fixed<SampledInput<'a, f64>>;
type Outcome = Result<Gradient, TrajectoryFailure>;

/// Any force model and any gradient method, in doubles, one recording at a time. Tasks run in parallel; sums
/// are in the order of the recordings.
#[derive(Debug)]
pub struct GeneralEngine {
    choice: GradientChoice,
    settings: SolverSettings,
    states: Vec<Vec<[f64; 4]>>,
}

/// A recording and, where each number to differentiate by has a cost of its own, some of the parameters and
/// initial states.
#[derive(Debug, Clone)]
struct Task {
    window: usize,
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

impl GeneralEngine {
    /// An engine with this gradient method and these steps, which may not be [`StepChoice::Exact`](crate::StepChoice::Exact).
    #[must_use]
    pub fn new(choice: GradientChoice, settings: SolverSettings) -> Self {
        Self { choice, settings, states: Vec::new() }
    }

    /// Predicts every window and evaluates its loss.
    fn values<F: ParametricForce + Sync>(
        &mut self,
        request: &TrajectoryRequest<'_, F>,
        loss: &IndexedLoss<'_>,
    ) -> TrajectoryGradient {
        let n = request.len();
        self.states.resize_with(n.max(self.states.len()), Vec::new);
        let settings = &self.settings;
        let one = |(k, states): (usize, &mut Vec<[f64; 4]>)| {
            let s = request.subject(k);
            let start = request.start(k);
            let predicted = predict_from(request.model, &s.recording, s.masses, settings, start);
            let (prediction, why) = match predicted {
                Ok(prediction) => (prediction, None),
                Err(e) => (e.partial, Some(e.why)),
            };
            let c = &prediction.channels;
            states.clear();
            states.extend((0..c.x.len()).map(|i| [c.x[i], c.v[i], c.pf[i], c.pe[i]]));
            match why {
                None => {
                    let mut unused = vec![[0.0; 4]; states.len()];
                    (loss(k, &s.recording, states, &mut unused), None)
                }
                Some(why) => {
                    let time_s = s.recording.time_s[states.len().saturating_sub(1)];
                    let kind = FailureKind::Request(why);
                    (f64::NAN, Some(TrajectoryFailure { problem: k, kind, time_s }))
                }
            }
        };
        let (values, failures): (Vec<f64>, Vec<_>) =
            self.states[..n].par_iter_mut().enumerate().with_max_len(1).map(one).unzip();
        let failures = failures.into_iter().flatten().collect();
        TrajectoryGradient::mean_of(GradientSums { values, failures, ..GradientSums::default() })
    }

    /// The gradient of one task.
    fn one<F: ParametricForce>(
        &self,
        request: &TrajectoryRequest<'_, F>,
        loss: &IndexedLoss<'_>,
        task: &Task,
    ) -> Result<Outcome, EngineError> {
        let controller = self.settings.step.controller().ok_or_else(|| {
            EngineError::Request(
                "the exact method has a gradient of its own and takes no other method's".into(),
            )
        })?;
        let subject = request.subject(task.window);
        let measured: &Recording = &subject.recording;
        let mut integrator = Integrator::new(self.settings.tableau.clone(), controller);
        let length_s = measured.span_s().1 - measured.span_s().0;
        if let Some(budget) = self.settings.step_budget() {
            let most = budget.steps(length_s, measured.len());
            integrator = integrator.with_max_steps(most).with_step_budget(budget);
        }
        let force =
            SampledInput::new(&measured.time_s, &measured.force_mn, self.settings.interpolation)?;
        let (input, field) = (Fixed(force), request.model.sealed(subject.masses));
        let (t0, t1) = measured.span_s();
        let problem = Problem {
            field: &field,
            input: &input,
            t0,
            t1,
            y0: &request.start(task.window),
            observations_s: &measured.time_s,
            integrator: &integrator,
        };
        let setup = MethodSetup {
            integrator: integrator.clone(),
            directions: Some(task.list(field.parameter_len())),
            floors: FLOORS,
        };
        let method = self.choice.method::<Field<'_, F>, Force<'_>, Arc<dyn StepController>>(setup);
        let mut on_states = |_: &[f64], states: &[f64], cotangents: &mut [f64]| {
            let (states, _) = states.as_chunks::<4>();
            let (cotangents, _) = cotangents.as_chunks_mut::<4>();
            loss(task.window, measured, states, cotangents)
        };
        Ok(method.value_and_gradient(&problem, &mut on_states).map_err(|e| TrajectoryFailure {
            problem: task.window,
            kind: e.kind,
            time_s: e.time_s,
        }))
    }

    /// Adds up the tasks, and keeps the predicted states.
    fn sums(
        &mut self,
        windows: usize,
        force_len: usize,
        tasks: &[Task],
        results: Vec<Outcome>,
    ) -> GradientSums {
        let mut failures: Vec<TrajectoryFailure> = Vec::new();
        for failure in results.iter().filter_map(|r| r.as_ref().err()) {
            if failures.last().is_none_or(|f| f.problem != failure.problem) {
                failures.push(failure.clone());
            }
        }
        let mut sums = GradientSums {
            values: vec![f64::NAN; windows],
            force: vec![0.0; force_len],
            joint_by_raw: [1.0; 3],
            masses: vec![[0.0; 2]; windows],
            initial_states: vec![[0.0; 4]; windows],
            ..GradientSums::default()
        };
        self.states.clear();
        self.states.resize(windows, Vec::new());
        for (task, gradient) in tasks.iter().zip(results) {
            let Ok(gradient) = gradient else { continue };
            let i = task.window;
            if failures.iter().any(|f| f.problem == i) {
                continue;
            }
            // A direction that was not asked for is zero.
            let (force, own) = gradient.parameters.split_at(force_len);
            let add = |sums: &mut [f64], values: &[f64]| {
                sums.iter_mut().zip(values).for_each(|(sum, v)| *sum += v);
            };
            add(&mut sums.force, force);
            add(&mut sums.joint, &own[..3]);
            sums.auxiliary_damping += own[3];
            add(&mut sums.masses[i], &own[4..]);
            add(&mut sums.initial_states[i], &gradient.initial_state);
            let (s, counts) = (gradient.statistics, &mut sums.statistics);
            counts.evaluations += s.evaluations;
            counts.pullbacks += s.vjps + s.jvps;
            counts.stored_bytes = counts.stored_bytes.max(s.checkpoint_bytes);
            if sums.values[i].is_nan() {
                sums.values[i] = gradient.value;
                counts.accepted += s.steps;
                counts.rejected += s.rejected;
                self.states[i] = gradient.states.as_chunks::<4>().0.to_vec();
            }
        }
        GradientSums { failures, ..sums }
    }
}

impl<F: ParametricForce + Sync> TrajectoryEngine<F> for GeneralEngine {
    fn evaluate(
        &mut self,
        request: &TrajectoryRequest<'_, F>,
        loss: &IndexedLoss<'_>,
        backward: bool,
    ) -> Result<TrajectoryGradient, EngineError> {
        request.check()?;
        if !backward {
            return Ok(self.values(request, loss));
        }
        let force_len = request.model.force.parameter_len();
        let len = force_len + OWN + STATES;
        // The step control does not matter for that.
        let shared = self.choice.pays_by_direction::<PidController>();
        let at_once = if shared { DIRECTIONS_AT_ONCE } else { len };
        let tasks: Vec<Task> = (0..request.len())
            .flat_map(|window| {
                (0..len).step_by(at_once).map(move |first| Task {
                    window,
                    directions: first..(first + at_once).min(len),
                })
            })
            .collect();
        if let Some(progress) = request.progress {
            progress.planned(tasks.len());
        }
        let results = parallel::map(tasks.len(), |k| {
            let result = self.one(request, loss, &tasks[k]);
            if let Some(progress) = request.progress {
                progress.done();
            }
            result
        })
        .into_iter()
        .collect::<Result<Vec<_>, EngineError>>()?;
        Ok(TrajectoryGradient::mean_of(self.sums(request.len(), force_len, &tasks, results)))
    }

    fn predicted(&mut self, index: usize) -> &[[f64; 4]] {
        &self.states[index]
    }
}
