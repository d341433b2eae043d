//! Runge–Kutta methods at constant steps for a given network, over the training conditions.

use super::cells::{Cells, blank, finite};
use super::measure::measure;
use super::method::Kind;
use super::result::Row;
use super::solver::Solver;
use crate::TRAINING_PSI;
use pam_autodiff::batch::SealedMotion;
use pam_core::units::{ATMOSPHERE_KPA, KPA_PER_PSI, tendon_force_mn_per_a};
use pam_core::{Activation, JointModel, NetworkForce};
use pam_exact::{ExactMotion, ExactProblem, ExactSolver, ForceSignal};
use pam_solvers::{
    BatchWorkspace, BatchedIntegrator, ConstantStep, InputFn, Interpolation, Tableau,
    TrajectoryProblem,
};
use std::f64::consts::TAU;

/// Name of the problem.
pub const NAME: &str = "training-conditions";
/// Name of the method: there is no gradient.
pub const METHOD: &str = "solve";
/// Size of the steps of the truth, s.
const TRUTH_STEP_S: f64 = 1e-4;
/// Points of the finer grid from one observation to the next, on which the closed form reads the force.
const POINTS: usize = 200;
/// Observations a second.
const OBSERVED_HZ: f64 = 100.0;

/// A joint with sealed air in each of the training conditions, from rest under the strongest published
/// excitation (2 Hz, 1.5 A): the largest error of x over all of them, at constant steps. The truth is
/// the closed form from kink to kink, or, for a smooth network, Dormand and Prince's method with steps of
/// 0.1 ms.
#[derive(Debug, Clone)]
pub struct ConditionGrid {
    /// Part of the study.
    pub part: String,
    /// The joint.
    pub model: JointModel<f64, NetworkForce<f64>>,
    /// Length of the solves, s.
    pub horizon_s: f64,
    /// The solvers, with constant steps.
    pub solvers: Vec<(Tableau, f64)>,
}

/// The tendon force, mN.
fn drive(t: f64, u: &mut [f64]) {
    u[0] = 1.5 * tendon_force_mn_per_a() * (TAU * 2.0 * t).sin();
}

/// Displacements of all trajectories at all observations, evaluations and steps.
type Solved = Result<(Vec<f64>, usize, usize), String>;

impl ConditionGrid {
    fn solve(&self, tableau: &Tableau, step_s: f64) -> Solved {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
        pool.map_err(|e| e.to_string())?.install(|| self.solve_here(tableau, step_s))
    }

    fn solve_here(&self, tableau: &Tableau, step_s: f64) -> Solved {
        let motion = SealedMotion::<f64, Activation>::new(&self.model, &self.model.force);
        let count = (OBSERVED_HZ * self.horizon_s).round() as usize;
        let times = super::case::evenly(count, self.horizon_s);
        let problems: Vec<_> = TRAINING_PSI
            .iter()
            .map(|condition| {
                let kpa = condition.map(|psi| f64::from(psi) * KPA_PER_PSI + ATMOSPHERE_KPA);
                TrajectoryProblem {
                    condition: motion.condition(self.model.gas_law_masses(0.0, kpa)),
                    input: InputFn::new(1, drive),
                    t0: 0.0,
                    t1: self.horizon_s,
                    y0: vec![0.0; 2],
                    observe_s: &times,
                }
            })
            .collect();
        let batched = BatchedIntegrator::new(tableau.clone(), ConstantStep::new(step_s));
        let mut memory = BatchWorkspace::default();
        let failures = batched.solve(&motion, &problems, &mut memory);
        if let Some(failure) = failures.first() {
            let of = problems.len();
            return Err(format!("{} of {of} solves stopped early: {failure}", failures.len()));
        }
        let mut states = vec![0.0; 2 * count];
        let (mut x, mut evaluations, mut steps) = (Vec::new(), 0, 0);
        for index in 0..problems.len() {
            memory.trajectory(index).observe(tableau, &times, &mut states);
            x.extend(states.iter().step_by(2));
            let trajectory = memory.trajectory(index);
            evaluations += trajectory.evaluations;
            steps += trajectory.steps();
        }
        Ok((x, evaluations, steps))
    }
}

impl ConditionGrid {
    /// The displacements in closed form, if the network has kinks: with the force linear between the points
    /// of two grids, extrapolated to the smooth one.
    fn in_closed_form(&self) -> Option<Vec<f64>> {
        let motion = ExactMotion::new(&self.model).ok()?;
        let [fine, coarse] = [POINTS, POINTS / 2].map(|points| self.on_grid(&motion, points));
        Some(fine?.iter().zip(coarse?).map(|(f, c)| f + (f - c) / 3.0).collect())
    }

    fn on_grid(&self, motion: &ExactMotion, points: usize) -> Option<Vec<f64>> {
        let count = (OBSERVED_HZ * self.horizon_s).round() as usize;
        let mut times = vec![0.0];
        times.extend(super::case::evenly(points * count, self.horizon_s));
        let force: Vec<f64> = times
            .iter()
            .map(|&t| {
                let mut u = [0.0];
                drive(t, &mut u);
                u[0]
            })
            .collect();
        let problems: Vec<ExactProblem<'_>> = TRAINING_PSI
            .iter()
            .map(|condition| {
                let kpa = condition.map(|psi| f64::from(psi) * KPA_PER_PSI + ATMOSPHERE_KPA);
                ExactProblem {
                    masses: self.model.gas_law_masses(0.0, kpa),
                    signal: ForceSignal {
                        times_s: &times,
                        force_mn: &force,
                        interpolation: Interpolation::Linear,
                    },
                    t0: 0.0,
                    t1: self.horizon_s,
                    y0: [0.0; 2],
                    observe_s: &times,
                }
            })
            .collect();
        let mut solver = ExactSolver::new();
        if !solver.solve(motion, &problems).is_empty() {
            return None;
        }
        let x = |index: usize| -> Vec<f64> {
            solver.observed(index).iter().step_by(2).skip(points).step_by(points).copied().collect()
        };
        Some((0..problems.len()).flat_map(x).collect())
    }
}

impl Cells for ConditionGrid {
    fn names(&self) -> Vec<(String, String)> {
        self.solvers.iter().map(|_| (NAME.to_owned(), METHOD.to_owned())).collect()
    }

    fn run(&self, repeat: usize, wanted: &dyn Fn(&str, &str) -> bool, found: &mut dyn FnMut(Row)) {
        if !wanted(NAME, METHOD) {
            return;
        }
        let truth = match self.in_closed_form() {
            Some(x) => Ok((x, 0, 0)),
            None => self.solve(&Tableau::dormand_prince5(), TRUTH_STEP_S),
        };
        let mlp = self.model.force.mlp();
        for (tableau, step_s) in &self.solvers {
            let (solved, measured) = measure(repeat, || self.solve(tableau, *step_s));
            let mut row = Row {
                part: self.part.clone(),
                problem: NAME.into(),
                activation: Some(mlp.activation().name().into()),
                width: mlp.layers().first().map(|layer| layer.outputs()),
                parameters: mlp.parameter_count() + 6,
                trajectories: TRAINING_PSI.len(),
                horizon_s: self.horizon_s,
                method: METHOD.into(),
                differentiation: "none".into(),
                kind: Kind::Value,
                ..blank(&Solver::constant(tableau.clone(), *step_s))
            };
            match (solved, &truth) {
                (Ok((x, evaluations, steps)), Ok((exact, ..))) => {
                    let off = x.iter().zip(exact).map(|(a, b)| (a - b).abs());
                    row.state_error = finite(off.fold(0.0, f64::max));
                    row.seconds = Some(measured.seconds);
                    row.peak_bytes = measured.peak_bytes;
                    (row.evaluations, row.steps) = (evaluations, steps);
                }
                (Err(why), _) => row.failure = Some(why),
                (_, Err(why)) => row.failure = Some(format!("no truth: {why}")),
            }
            found(row);
        }
    }
}
