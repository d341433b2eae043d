//! Tangents of the accepted steps.

use super::direction::{Blocks, Direction};
use super::{
    Gradient, GradientMethod, GradientStatistics, Loss, MethodSetup, NamedMethod, Problem, loss,
};
use crate::error::SolveError;
use crate::grid::Grid;
use crate::input::{ParametricInput, Side};
use crate::observations::Observations;
use crate::replay::Replay;
use crate::step::combine_into;
use pam_autodiff::{At, ByTape, DifferentiableField, Differentiation, Tangent};
use pam_core::ParametricField;

/// Forward mode through the steps of the solver (discretise, then differentiate).
///
/// Every direction of change (parameter of the field, initial state, parameter of the input) is carried
/// through the accepted steps,
///
/// ```text
/// Ẏ_i = ẏ + h Σ_j a_ij k̇_j,     k̇_i = ∂f/∂y Ẏ_i + ∂f/∂u u̇ + ∂f/∂p ṗ,     ẏ⁺ = ẏ + h Σ_i b_i k̇_i
/// ```
///
/// exact to rounding. Cost: `s` Jacobian–vector products a step *and direction*; memory for two tangents
/// a direction. The method of choice for few directions, and when the derivative of the trajectory
/// itself is wanted: [`sensitivities`](Self::sensitivities).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ForwardSensitivity<D> {
    /// How the field is differentiated.
    pub differentiation: D,
    /// Directions of the derivative; all of them if absent. The gradient is 0 in the others.
    pub directions: Option<Vec<Direction>>,
}

/// The observed states and their derivatives.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensitivities {
    /// The observed states, row-major `[times, states]`.
    pub states: Vec<f64>,
    /// Directions of the derivative.
    pub directions: Vec<Direction>,
    /// Derivative of every observed state in every direction, row-major `[times, directions, states]`.
    pub tangents: Vec<f64>,
    /// The accepted steps.
    pub grid: Grid,
    /// Cost.
    pub statistics: GradientStatistics,
}

impl<D> ForwardSensitivity<D> {
    /// Forward sensitivities by `differentiation` in all directions.
    pub fn new(differentiation: D) -> Self {
        Self { differentiation, directions: None }
    }

    /// The same in some directions.
    #[must_use]
    pub fn with_directions(mut self, directions: Vec<Direction>) -> Self {
        self.directions = Some(directions);
        self
    }

    /// The observed states of `problem` and their derivatives.
    ///
    /// # Errors
    /// [`SolveError`] if the request is inconsistent or the solve stops early.
    pub fn sensitivities<F, I>(
        &self,
        problem: &Problem<'_, F, I>,
    ) -> Result<Sensitivities, Box<SolveError<f64>>>
    where
        F: ParametricField,
        I: ParametricInput,
        D: Differentiation<F>,
    {
        let wanted = self.directions.as_deref();
        let directions = Blocks::zeros(problem).directions(wanted, problem)?;
        let (states, grid, mut statistics) = problem.solve_on_grid()?;
        let field = self.differentiation.of(problem.field);
        let n = problem.y0.len();
        let mut tangents = vec![0.0; problem.observations_s.len() * directions.len() * n];
        let run = Propagation::new(problem, &grid, field, &directions);
        run.run(&mut statistics, |observation, direction, tangent| {
            let at = (observation * directions.len() + direction) * n;
            tangents[at..at + n].copy_from_slice(tangent);
        });
        Ok(Sensitivities { states, directions, tangents, grid, statistics })
    }
}

impl<C> NamedMethod<C> for ForwardSensitivity<ByTape> {
    const PAYS_BY_DIRECTION: bool = true;

    fn from_setup(setup: MethodSetup<C>) -> Self {
        Self { differentiation: ByTape, directions: setup.directions }
    }
}

impl<F, I, D> GradientMethod<F, I> for ForwardSensitivity<D>
where
    F: ParametricField,
    I: ParametricInput,
    D: Differentiation<F>,
{
    fn name(&self) -> String {
        format!("forward sensitivity, {}", self.differentiation.name())
    }

    fn value_and_gradient(
        &self,
        problem: &Problem<'_, F, I>,
        loss: &mut dyn Loss,
    ) -> Result<Gradient, Box<SolveError<f64>>> {
        let mut sums = Blocks::zeros(problem);
        let directions = sums.directions(self.directions.as_deref(), problem)?;
        let (states, grid, mut statistics) = problem.solve_on_grid()?;
        let mut cotangents = Vec::new();
        let value = loss::evaluate(loss, problem.observations_s, &states, &mut cotangents);
        let field = self.differentiation.of(problem.field);
        let n = problem.y0.len();
        let run = Propagation::new(problem, &grid, field, &directions);
        run.run(&mut statistics, |observation, direction, tangent| {
            let w = &cotangents[observation * n..(observation + 1) * n];
            *sums.at(directions[direction]) +=
                w.iter().zip(tangent).map(|(w, y)| w * y).sum::<f64>();
        });
        let Blocks { parameters, initial_state, input } = sums;
        Ok(Gradient { value, parameters, initial_state, input, states, grid, statistics })
    }
}

/// All tangents on their way along a grid.
struct Propagation<'a, V: DifferentiableField, F, I> {
    problem: &'a Problem<'a, F, I>,
    grid: &'a Grid,
    directions: &'a [Direction],
    field: V,
    field_work: V::Workspace,
    /// ẏ at the start of the step, direction by direction.
    y_dot: Vec<f64>,
    /// k̇ of the first stage, direction by direction.
    k1_dot: Vec<f64>,
    /// Stage states of the step, the end state last.
    stages: Vec<f64>,
    /// Inputs of the stages, that of the FSAL stage last.
    inputs: Vec<f64>,
    jvps: usize,
}

/// One step of one direction: where its stages are and which tangents it needs.
struct Scratch {
    k_dot: Vec<f64>,
    stage_dot: Vec<f64>,
    u_dot: Vec<f64>,
    /// A unit vector of the field's parameters, zero between uses.
    p_dot: Vec<f64>,
    /// A unit vector of the input's parameters, zero between uses.
    q_dot: Vec<f64>,
}

impl<'a, V, F, I> Propagation<'a, V, F, I>
where
    V: DifferentiableField,
    F: ParametricField,
    I: ParametricInput,
{
    fn new(
        problem: &'a Problem<'a, F, I>,
        grid: &'a Grid,
        field: V,
        directions: &'a [Direction],
    ) -> Self {
        let n = problem.y0.len();
        let stages = problem.integrator.tableau().stages_with_fsal();
        let mut y_dot = vec![0.0; directions.len() * n];
        for (y_dot, direction) in y_dot.chunks_exact_mut(n).zip(directions) {
            if let Direction::InitialState(i) = *direction {
                y_dot[i] = 1.0;
            }
        }
        Self {
            problem,
            grid,
            directions,
            field_work: field.workspace(),
            field,
            y_dot,
            k1_dot: vec![0.0; directions.len() * n],
            stages: vec![0.0; stages * n],
            inputs: vec![0.0; stages * problem.input.input_len()],
            jvps: 0,
        }
    }

    /// Calls `sink(observation, direction, tangent of the state)` for every observation and direction.
    fn run(
        mut self,
        statistics: &mut GradientStatistics,
        mut sink: impl FnMut(usize, usize, &[f64]),
    ) {
        let problem = self.problem;
        let tableau = problem.integrator.tableau();
        let (n, s) = (problem.y0.len(), tableau.stages());
        let q = problem.input.parameter_len();
        let observations = Observations { times_s: problem.observations_s };
        let mut next = observations.at_start(problem.t0);
        if next == 1 {
            for (direction, y_dot) in self.y_dot.chunks_exact(n).enumerate() {
                sink(0, direction, y_dot);
            }
        }
        let mut scratch = Scratch {
            k_dot: vec![0.0; (s + 1) * n],
            stage_dot: vec![0.0; n],
            u_dot: vec![0.0; problem.input.input_len()],
            p_dot: vec![0.0; self.field.parameter_len()],
            q_dot: vec![0.0; q],
        };
        let term = problem.term();
        let mut replay = Replay::new(tableau, &term, self.grid, problem.y0);
        replay.begin();
        for step in 0..self.grid.steps() {
            let (t, t_new) = self.grid.step_s(step);
            let h = t_new - t;
            replay.take(step);
            let observed = observations.from(t_new, next);
            next = observed.end + usize::from(observed.at_end);
            let continues = step + 1 < self.grid.steps() && !self.grid.is_restart(step + 1);
            let closes = continues || observed.any_inside();
            self.prepare(t, t_new, &replay.work.y, &replay.work.k);
            for direction in 0..self.directions.len() {
                let first = usize::from(!self.grid.is_restart(step));
                scratch.k_dot[..n].copy_from_slice(&self.k1_dot[direction * n..][..n]);
                for i in first..s + usize::from(closes) {
                    let y_dot = &self.y_dot[direction * n..][..n];
                    combine_into(tableau.row(i), h, y_dot, &scratch.k_dot, &mut scratch.stage_dot);
                    let (time, side) = tableau.stage_time(i, t, t_new);
                    self.push_forward(time, side, i, direction, &mut scratch);
                }
                let y_dot = &mut self.y_dot[direction * n..][..n];
                for o in observed.first..observed.end {
                    let theta = (problem.observations_s[o] - t) / h;
                    let (k_dot, out) = (&scratch.k_dot, &mut scratch.stage_dot);
                    tableau.interpolate_into(theta, h, y_dot, k_dot, out);
                    sink(o, direction, &scratch.stage_dot);
                }
                combine_into(&tableau.b, h, y_dot, &scratch.k_dot, &mut scratch.stage_dot);
                y_dot.copy_from_slice(&scratch.stage_dot);
                if observed.at_end {
                    sink(observed.end, direction, y_dot);
                }
                self.k1_dot[direction * n..][..n].copy_from_slice(&scratch.k_dot[s * n..]);
            }
            replay.proceed(step);
        }
        statistics.jvps = self.jvps;
        statistics.replayed = self.grid.steps();
        statistics.evaluations += replay.work.evaluations;
        statistics.checkpoint_bytes = (self.y_dot.len() + self.k1_dot.len()) * size_of::<f64>();
    }

    /// Stage states and inputs of the step from `t` to `t_new`, which all directions share.
    fn prepare(&mut self, t: f64, t_new: f64, y: &[f64], k: &[f64]) {
        let tableau = self.problem.integrator.tableau();
        let (n, m) = (y.len(), self.problem.input.input_len());
        for i in 0..tableau.stages_with_fsal() {
            let stage = &mut self.stages[i * n..(i + 1) * n];
            combine_into(tableau.row(i), t_new - t, y, k, stage);
            let (time, side) = tableau.stage_time(i, t, t_new);
            self.problem.input.value_into(time, side, &mut self.inputs[i * m..(i + 1) * m]);
        }
    }

    /// The tangent of derivative `i`, from the tangent of its stage state.
    fn push_forward(
        &mut self,
        t: f64,
        side: Side,
        i: usize,
        direction: usize,
        scratch: &mut Scratch,
    ) {
        let (n, m) = (scratch.stage_dot.len(), scratch.u_dot.len());
        let direction = self.directions[direction];
        scratch.u_dot.fill(0.0);
        match direction {
            Direction::Parameter(p) => scratch.p_dot[p] = 1.0,
            Direction::InitialState(_) => {}
            Direction::Input(q) => {
                scratch.q_dot[q] = 1.0;
                self.problem.input.jvp_into(t, side, &scratch.q_dot, &mut scratch.u_dot);
                scratch.q_dot[q] = 0.0;
            }
        }
        self.field.jvp_into(
            At { t, y: &self.stages[i * n..(i + 1) * n], u: &self.inputs[i * m..(i + 1) * m] },
            Tangent { y: &scratch.stage_dot, u: &scratch.u_dot, p: &scratch.p_dot },
            &mut scratch.k_dot[i * n..(i + 1) * n],
            &mut self.field_work,
        );
        if let Direction::Parameter(p) = direction {
            scratch.p_dot[p] = 0.0;
        }
        self.jvps += 1;
    }
}
