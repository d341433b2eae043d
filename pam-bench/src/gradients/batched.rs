//! Batched trajectories against the exact adjoint, trajectory by trajectory.

use super::cells::{Cells, blank, finite};
use super::measure::{Measured, measure};
use super::method::Kind;
use super::problems::joint;
use super::result::Row;
use super::solver::Solver;
use super::truth::{TIGHT, relative_error};
use pam_autodiff::ByTape;
use pam_autodiff::batch::SealedMotion;
use pam_core::simd::Float;
use pam_core::{Activation, ActivationFunction, JointModel, NetworkForce};
use pam_solvers::sensitivity::{DiscreteAdjoint, GradientMethod, Problem};
use pam_solvers::{
    BatchGradient, BatchWorkspace, BatchedIntegrator, ConstantStep, SolveError, Tableau,
    TrajectoryProblem,
};

/// Name of the method.
pub const NAME: &str = "batched";
/// Parameters of the joint after those of its network.
const OWN: usize = 6;

/// Joints that differ in their air and share a network, under constant steps and a loss of the motion.
///
/// Three rows for each number of trajectories: the exact adjoint one by one, and batched in each float of the
/// network. What is compared is the gradient of the sum of the losses with respect to the network. The
/// adjoint one by one stands for the frozen steps here; the grids of the study hold it against dual
/// numbers.
#[derive(Debug, Clone)]
pub struct BatchGrid {
    /// Part of the study.
    pub part: String,
    /// Activation of the network.
    pub activation: Activation,
    /// Its width.
    pub width: usize,
    /// Length of the solves, s.
    pub horizon_s: f64,
    /// Numbers of trajectories.
    pub trajectories: Vec<usize>,
    /// The method.
    pub tableau: Tableau,
    /// Size of its steps, s.
    pub step_s: f64,
}

type Model = JointModel<f64, NetworkForce<f64>>;

/// A sum over trajectories with its gradient with respect to the network, and what it cost.
struct Sum {
    value: f64,
    network: Vec<f64>,
    /// Largest stored bytes, evaluations, products, steps.
    counts: [usize; 4],
}

impl BatchGrid {
    /// Trajectory by trajectory.
    fn one_by_one(
        &self,
        model: &Model,
        solver: &Solver,
        count: usize,
    ) -> Result<Sum, Box<SolveError<f64>>> {
        let weights = model.force.mlp().parameter_count();
        let mut sum = Sum { value: 0.0, network: vec![0.0; weights], counts: [0; 4] };
        let integrator = solver.integrator();
        for index in 0..count {
            let masses = joint::masses(index);
            let problem = Problem {
                field: &model.sealed(masses),
                input: &joint::input(),
                t0: 0.0,
                t1: self.horizon_s,
                y0: &joint::start(model, masses),
                observations_s: &joint::observations_s(self.horizon_s),
                integrator: &integrator,
            };
            let g = DiscreteAdjoint::new(ByTape).value_and_gradient(&problem, &mut on_motion)?;
            sum.value += g.value;
            for (sum, g) in sum.network.iter_mut().zip(&g.parameters) {
                *sum += g;
            }
            let s = g.statistics;
            let [stored, evaluations, vjps, steps] = &mut sum.counts;
            *stored = s.checkpoint_bytes.max(*stored);
            *evaluations += s.evaluations;
            *vjps += s.vjps;
            *steps += s.steps;
        }
        Ok(sum)
    }

    /// The sum in closed form from kink to kink, if the network has kinks.
    fn in_closed_form(&self, model: &Model, count: usize) -> Option<Sum> {
        self.activation.relu_slope()?;
        let observations_s = joint::observations_s(self.horizon_s);
        let weights = model.force.mlp().parameter_count();
        let mut sum = Sum { value: 0.0, network: vec![0.0; weights], counts: [0; 4] };
        for index in 0..count {
            let masses = joint::masses(index);
            let start = joint::start(model, masses);
            let truth = joint::kinked(model, masses, start, &observations_s).truth(&on_motion)?;
            sum.value += truth.value;
            sum.network.iter_mut().zip(&truth.parameters).for_each(|(sum, g)| *sum += g);
        }
        Some(sum)
    }

    /// All at once, the network in `T`.
    fn together<T: Float>(&self, model: &Model, count: usize) -> Result<Sum, String> {
        let motion = SealedMotion::<T, Activation>::new(model, &model.force);
        let times = joint::observations_s(self.horizon_s);
        let problem = |index: usize| TrajectoryProblem {
            condition: motion.condition(joint::masses(index)),
            input: joint::input(),
            t0: 0.0,
            t1: self.horizon_s,
            y0: joint::start(model, joint::masses(index))[..2].to_vec(),
            observe_s: &times,
        };
        let problems: Vec<_> = (0..count).map(problem).collect();
        let batched = BatchedIntegrator::new(self.tableau.clone(), ConstantStep::new(self.step_s));
        let loss =
            |_: usize, states: &[f64], out: &mut [f64]| joint::motion_loss()(&times, states, out);
        let mut memory = BatchWorkspace::default();
        let BatchGradient {
            value,
            mut shared,
            failures,
            accepted,
            evaluations,
            linearised,
            stored_bytes,
            ..
        } = batched.value_and_gradient(&motion, &problems, &loss, &mut memory);
        if let Some(failure) = failures.first() {
            return Err(failure.to_string());
        }
        shared.truncate(model.force.mlp().parameter_count());
        let counts = [stored_bytes, evaluations, linearised, accepted];
        Ok(Sum { value, network: shared, counts })
    }

    /// The row of a sum, held against the same steps one by one and against the truth.
    fn row(
        &self,
        (method, differentiation): (&str, &str),
        count: usize,
        (sum, measured): (Result<Sum, String>, Measured),
        truths: &Result<[Sum; 2], String>,
    ) -> Row {
        let mut row = Row {
            part: self.part.clone(),
            problem: joint::NAME.into(),
            activation: Some(self.activation.name().into()),
            width: Some(self.width),
            trajectories: count,
            horizon_s: self.horizon_s,
            method: method.into(),
            differentiation: differentiation.into(),
            kind: if differentiation == "f32" { Kind::SinglePrecision } else { Kind::Exact },
            ..blank(&self.solver())
        };
        match (sum, truths) {
            (Ok(sum), Ok([same, tight])) => {
                row.parameters = sum.network.len() + OWN;
                row.value = finite(sum.value);
                row.seconds = Some(measured.seconds);
                row.peak_bytes = measured.peak_bytes;
                [row.checkpoint_bytes, row.evaluations, row.vjps, row.steps] = sum.counts;
                row.value_error = finite(relative_error(&[sum.value], &[tight.value]));
                row.replay_error = finite(relative_error(&sum.network, &same.network));
                row.gradient_error = finite(relative_error(&sum.network, &tight.network));
            }
            (Err(why), _) => row.failure = Some(why),
            (_, Err(why)) => row.failure = Some(format!("no truth: {why}")),
        }
        row
    }

    fn solver(&self) -> Solver {
        Solver::constant(self.tableau.clone(), self.step_s)
    }
}

/// The loss of the motion, on the joint's four states.
fn on_motion(times: &[f64], states: &[f64], cotangents: &mut [f64]) -> f64 {
    let motion: Vec<f64> = states.chunks_exact(4).flat_map(|y| [y[0], y[1]]).collect();
    let mut own = vec![0.0; motion.len()];
    let value = joint::motion_loss()(times, &motion, &mut own);
    for (w, own) in cotangents.chunks_exact_mut(4).zip(own.chunks_exact(2)) {
        w[..2].copy_from_slice(own);
    }
    value
}

impl Cells for BatchGrid {
    fn names(&self) -> Vec<(String, String)> {
        let methods = ["adjoint", NAME, NAME].map(|m| (joint::NAME.to_owned(), m.to_owned()));
        self.trajectories.iter().flat_map(|_| methods.clone()).collect()
    }

    fn run(&self, repeat: usize, wanted: &dyn Fn(&str, &str) -> bool, found: &mut dyn FnMut(Row)) {
        let [adjoint, batched] = ["adjoint", NAME].map(|method| wanted(joint::NAME, method));
        if !(adjoint || batched) {
            return;
        }
        let model = joint::model(self.activation, self.width);
        // On one thread, as everything else in the study runs.
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        let mut tight = Solver::adaptive(Tableau::dormand_prince5(), TIGHT);
        tight.max_steps = 10_000_000;
        tight.stops_s = joint::observations_s(self.horizon_s);
        for &count in &self.trajectories {
            let one_by_one = |solver: &Solver| {
                self.one_by_one(&model, solver, count).map_err(|e| e.kind.describe(e.time_s))
            };
            let truth = || match self.in_closed_form(&model, count) {
                Some(truth) => Ok(truth),
                None => one_by_one(&tight),
            };
            let truths = one_by_one(&self.solver()).and_then(|same| Ok([same, truth()?]));
            if adjoint {
                let result = measure(repeat, || one_by_one(&self.solver()));
                found(self.row(("adjoint", "tape"), count, result, &truths));
            }
            if let (true, Ok(pool)) = (batched, &pool) {
                let of_double = || pool.install(|| self.together::<f64>(&model, count));
                found(self.row((NAME, f64::NAME), count, measure(repeat, of_double), &truths));
                let of_single = || pool.install(|| self.together::<f32>(&model, count));
                found(self.row((NAME, f32::NAME), count, measure(repeat, of_single), &truths));
            }
        }
    }
}
