//! The adjoint of the accepted steps: the exact gradient of the computed solution.

mod checkpointing;
mod record;
mod revolve;
mod sweep;

pub use checkpointing::Checkpointing;

use super::{
    Gradient, GradientMethod, GradientStatistics, Loss, MethodSetup, NamedMethod, Problem, loss,
};
use crate::error::SolveError;
use crate::grid::Grid;
use crate::input::ParametricInput;
use crate::replay::Replay;
use pam_autodiff::{ByTape, DifferentiableField, Differentiation};
use pam_core::ParametricField;
use record::{ForwardRecord, Rows};
use sweep::{Sweep, SweepMemory};

/// Reverse mode through the steps of the solver (discretise, then differentiate).
///
/// The gradient is that of the computed solution with its accepted steps frozen, exact to rounding:
/// it agrees with a tape through the solver, with dual numbers and with forward sensitivities at any
/// tolerance. Cost: `s` vector–Jacobian products a step with `s` stages, independent of the number of
/// parameters, one more where the input jumps between steps or a step has observations inside; memory
/// as [`Checkpointing`] says.
///
/// Forward and reverse sweep allocate nothing per step once an [`AdjointWorkspace`] is warm.
///
/// ```
/// use pam_autodiff::ByTape;
/// use pam_core::field_fn;
/// use pam_solvers::sensitivity::{DiscreteAdjoint, GradientMethod, Problem};
/// use pam_solvers::{Integrator, PidController, Tableau};
///
/// // ẏ = −p y: the state at t = 2 is exp(−2 p), its derivative −2 exp(−2 p).
/// let field = field_fn!([0.7], 0 => 1, |_t, y, _u, p, dy| dy[0] = -p[0] * y[0]);
/// let integrator = Integrator::new(Tableau::tsit5(), PidController::new(1e-10, 1e-10));
/// let problem = Problem::new(&field, &[1.0], &[2.0], &integrator);
/// // The loss writes its cotangents and returns its value.
/// let mut end = |_times: &[f64], states: &[f64], cotangents: &mut [f64]| {
///     cotangents[0] = 1.0;
///     states[0]
/// };
/// let gradient = DiscreteAdjoint::new(ByTape).value_and_gradient(&problem, &mut end)?;
/// assert!((gradient.parameters[0] + 2.0 * (-1.4_f64).exp()).abs() < 1e-8);
/// # Ok::<(), Box<pam_solvers::SolveError<f64>>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DiscreteAdjoint<D> {
    /// How the field is differentiated.
    pub differentiation: D,
    /// States and stages that the forward solve stores.
    pub checkpointing: Checkpointing,
}

/// Memory of [`DiscreteAdjoint`] that can be reused from gradient to gradient, for any problem.
///
/// The scratch memory of the differentiated field is not in it: that may borrow the field, whose
/// parameters change from gradient to gradient.
#[derive(Debug, Clone, Default)]
pub struct AdjointWorkspace {
    grid: Grid,
    snapshots: Rows,
    stages: Rows,
    cotangents: Vec<f64>,
    sweep: SweepMemory,
}

impl AdjointWorkspace {
    /// An empty workspace; it grows with the first gradient.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }
}

impl<D> DiscreteAdjoint<D> {
    /// The adjoint by `differentiation`, all stages stored.
    pub fn new(differentiation: D) -> Self {
        Self { differentiation, checkpointing: Checkpointing::AllSave }
    }

    /// The same with another checkpointing.
    #[must_use]
    pub fn with_checkpointing(mut self, checkpointing: Checkpointing) -> Self {
        self.checkpointing = checkpointing;
        self
    }

    /// [`value_and_gradient`](GradientMethod::value_and_gradient) with memory that is reused: the number
    /// of allocations does not depend on the number of steps once `workspace` is warm.
    ///
    /// # Errors
    /// [`SolveError`] if the request is inconsistent or the solve stops early.
    pub fn value_and_gradient_with<F, I>(
        &self,
        problem: &Problem<'_, F, I>,
        loss: &mut dyn Loss,
        workspace: &mut AdjointWorkspace,
    ) -> Result<Gradient, Box<SolveError<f64>>>
    where
        F: ParametricField,
        I: ParametricInput,
        D: Differentiation<F>,
    {
        if let Err(why) = self.checkpointing.check() {
            return Err(SolveError::request(why, problem.t0, problem.y0));
        }
        let tableau = problem.integrator.tableau();
        let n = problem.y0.len();
        let AdjointWorkspace { grid, snapshots, stages, cotangents, sweep } = workspace;
        grid.restart(problem.t0);
        snapshots.restart(2 * n);
        stages.restart((tableau.stages() + 1) * n);
        let checkpointing = self.checkpointing;
        let mut record = ForwardRecord { checkpointing, grid, snapshots, stages };
        let solution = problem.solve(&mut record)?;
        let forward = GradientStatistics::of_forward(solution.statistics);
        let states = solution.into_states();
        let value = loss::evaluate(loss, problem.observations_s, &states, cotangents);

        let grid = &*grid;
        let term = problem.term();
        let mut backward = Backward {
            replay: Replay::new(tableau, &term, grid, problem.y0),
            sweep: Sweep::new(
                problem,
                grid,
                self.differentiation.of(problem.field),
                cotangents,
                sweep,
            ),
            snapshots,
            stages,
            replayed: 0,
        };
        let steps = grid.steps();
        match checkpointing {
            Checkpointing::AllSave => backward.stored(0, steps, n),
            Checkpointing::Interval(every) => backward.by_segments(every, steps, n),
            Checkpointing::Binomial { snapshots } => {
                if steps > 0 {
                    backward.replay.begin();
                    backward.snapshot();
                    backward.binomial(0, steps, snapshots);
                }
            }
        }
        backward.sweep.finish();
        let statistics = GradientStatistics {
            replayed: backward.replayed,
            evaluations: forward.evaluations + backward.replay.work.evaluations,
            vjps: backward.sweep.vjps,
            checkpoint_bytes: backward.snapshots.peak_bytes() + backward.stages.peak_bytes(),
            ..forward
        };
        Ok(Gradient {
            value,
            initial_state: backward.sweep.state().to_vec(),
            parameters: backward.sweep.parameters,
            input: backward.sweep.input_parameters,
            states,
            grid: grid.clone(),
            statistics,
        })
    }
}

/// Brings the stages of each step to the sweep, last step first.
struct Backward<'a, V: DifferentiableField, F, I> {
    replay: Replay<'a, f64, &'a F, &'a I>,
    sweep: Sweep<'a, V, I>,
    snapshots: &'a mut Rows,
    stages: &'a mut Rows,
    replayed: usize,
}

impl<V, F, I> Backward<'_, V, F, I>
where
    V: DifferentiableField,
    F: ParametricField,
    I: ParametricInput,
{
    /// Steps `first` to `end`, whose stages are stored.
    fn stored(&mut self, first: usize, end: usize, n: usize) {
        for step in (first..end).rev() {
            let (y, k) = self.stages.row(step - first, n);
            self.sweep.reverse(step, y, k);
        }
    }

    /// All `steps` steps, from one snapshot for every `every` of them.
    fn by_segments(&mut self, every: usize, steps: usize, n: usize) {
        for segment in (0..steps.div_ceil(every)).rev() {
            let (first, end) = (segment * every, ((segment + 1) * every).min(steps));
            let (y, k1) = self.snapshots.row(segment, n);
            self.replay.restore(y, k1);
            self.stages.clear();
            for step in first..end {
                self.take(step);
                let work = &self.replay.work;
                self.stages.push(&work.y, &work.k[..work.k.len() - n]);
                if step + 1 < end {
                    self.replay.proceed(step);
                }
            }
            self.stored(first, end, n);
        }
    }

    /// Steps `first` to `end`, of which the last snapshot holds the start, with `free` snapshots, that
    /// one included.
    fn binomial(&mut self, first: usize, end: usize, free: usize) {
        if end - first == 1 || free == 1 {
            for step in (first..end).rev() {
                self.run_to(first, step);
                self.take(step);
                self.sweep.reverse(step, &self.replay.work.y, &self.replay.work.k);
            }
            return;
        }
        let middle = first + revolve::advance(end - first, free);
        self.run_to(first, middle);
        self.snapshot();
        self.binomial(middle, end, free - 1);
        self.snapshots.pop();
        self.binomial(first, middle, free);
    }

    /// From the last snapshot, which is the start of step `first`, to the start of step `step`.
    fn run_to(&mut self, first: usize, step: usize) {
        let (y, k1) = self.snapshots.top();
        self.replay.restore(y, k1);
        for s in first..step {
            self.take(s);
            self.replay.proceed(s);
        }
    }

    fn take(&mut self, step: usize) {
        self.replay.take(step);
        self.replayed += 1;
    }

    /// Stores where the replay stands.
    fn snapshot(&mut self) {
        let work = &self.replay.work;
        self.snapshots.push(&work.y, &work.k[..work.y.len()]);
    }
}

impl<C> NamedMethod<C> for DiscreteAdjoint<ByTape> {
    fn from_setup(_: MethodSetup<C>) -> Self {
        Self::new(ByTape)
    }
}

impl<F, I, D> GradientMethod<F, I> for DiscreteAdjoint<D>
where
    F: ParametricField,
    I: ParametricInput,
    D: Differentiation<F>,
{
    fn name(&self) -> String {
        let how = self.differentiation.name();
        format!("discrete adjoint, {how}, {}", self.checkpointing.name())
    }

    fn value_and_gradient(
        &self,
        problem: &Problem<'_, F, I>,
        loss: &mut dyn Loss,
    ) -> Result<Gradient, Box<SolveError<f64>>> {
        self.value_and_gradient_with(problem, loss, &mut AdjointWorkspace::new())
    }
}
