//! Many trajectories, their losses and the gradient of the sum.

use crate::adams::Adams;
use crate::cells::CellScheme;
use crate::method::Method;
use crate::nodes::{NodeForce, NodeNetwork, PointForces, SealedPoints};
use crate::problem::SurrogateProblem;
use crate::result::SurrogateGradient;
use crate::run::{Run, Scheme, Solved, Workspace};
use crate::settings::SurrogateSettings;
use crate::trajectory::{Mechanics, Stop};
use pam_core::simd::arch;
use pam_core::{ForceModel, JointModel, NetworkForce, parallel};
use pam_solvers::{FailureKind, TrajectoryFailure};
use std::sync::{Mutex, PoisonError};

/// A joint whose force is a smooth network, laid out for [`SurrogateSolver`].
#[derive(Debug)]
pub struct SurrogateMotion {
    network: NodeNetwork,
    mechanics: Mechanics,
}

impl SurrogateMotion {
    /// The motion of a joint with this network.
    #[must_use]
    pub fn new<F>(model: &JointModel<f64, F>, force: &NetworkForce<f64>) -> Self {
        Self { network: NodeNetwork::new(force), mechanics: Mechanics::of(model) }
    }
}

/// The loss of a trajectory: gets its index and the observed `[x, ẋ]` one after the other, and writes their cotangents.
pub type MotionLoss<'a> = dyn Fn(usize, &[f64], &mut [f64]) -> f64 + Sync + 'a;

/// Solves trajectories on surrogates, again and again; memory is kept from call to call. Results are the same bits at any
/// number of threads and do not depend on earlier calls.
///
/// ```
/// use pam_core::force::{Dense, Mlp};
/// use pam_core::{Activation, JointModel, NetworkForce, SealedMasses};
/// use pam_solvers::{ForceSignal, Interpolation};
/// use pam_surrogate::{SurrogateProblem, SurrogateSolver};
///
/// // f = 150 N/mm · tanh(x in mm): smooth, and stiff in the middle.
/// let hidden = Dense::from_rows(&[0.0, 0.0, 1.0, 0.0], vec![0.0])?;
/// let output = Dense::from_rows(&[150e3], vec![0.0])?;
/// let force = NetworkForce::new(Mlp::new(vec![hidden, output], Activation::from_name("tanh")?)?)?;
/// let model = JointModel::datasheet(force);
/// let times = [0.0, 0.01, 0.02];
/// let problem = SurrogateProblem {
///     masses: SealedMasses::new(0.08, 0.08)?,
///     signal: ForceSignal {
///         times_s: &times,
///         force_mn: &[0.0; 3],
///         interpolation: Interpolation::Linear,
///     },
///     t0: 0.0,
///     t1: 0.02,
///     y0: [0.01, 0.0],
///     observe_s: &times,
///     expected: [&[], &[]],
/// };
/// let (states, failure) = SurrogateSolver::default().trajectory(&model, &problem);
/// assert!(failure.is_none());
/// let omega = (150e3 / model.physical().mass_kg).sqrt(); // of small motions
/// assert!((states[4] - 0.01 * (0.02 * omega).cos()).abs() < 1e-6);
/// # Ok::<(), pam_core::ModelError>(())
/// ```
#[derive(Debug)]
pub struct SurrogateSolver {
    scheme: Scheme,
    states: Vec<Mutex<Vec<f64>>>,
    spare: Mutex<Vec<Workspace>>,
}

impl Default for SurrogateSolver {
    fn default() -> Self {
        Self::new(SurrogateSettings::default())
    }
}

impl SurrogateSolver {
    /// A solver of this accuracy.
    #[must_use]
    pub fn new(settings: SurrogateSettings) -> Self {
        let (method, adams, cells) = (Method::new(), Adams::new(), CellScheme::new());
        let scheme = Scheme { settings, method, adams, cells };
        Self { scheme, states: Vec::new(), spare: Mutex::default() }
    }

    /// The losses of trajectories; with `backward` the gradient of their sum.
    pub fn evaluate(
        &mut self,
        motion: &SurrogateMotion,
        problems: &[SurrogateProblem<'_>],
        loss: &MotionLoss<'_>,
        backward: bool,
    ) -> SurrogateGradient {
        if self.states.len() < problems.len() {
            self.states.resize_with(problems.len(), Mutex::default);
        }
        let this = &*self;
        let all =
            parallel::map(problems.len(), |i| this.solve(motion, i, &problems[i], loss, backward));
        let mut sum = SurrogateGradient {
            network: vec![0.0; if backward { motion.network.parameter_len() } else { 0 }],
            ..SurrogateGradient::default()
        };
        for (index, one) in all.into_iter().enumerate() {
            sum.add(&one, motion.mechanics.per_mass);
            if let Some((kind, time_s)) = self.failure(&one, &problems[index]) {
                sum.failures.push(TrajectoryFailure { problem: index, kind, time_s });
                if matches!(one.stop, Some(Stop::Rough { .. })) {
                    sum.rough.push(index);
                }
            }
        }
        sum
    }

    /// The observed `[x, ẋ]` of a trajectory of the last call, one after the other; zeros after it stopped.
    ///
    /// # Panics
    /// If there was none of this index.
    pub fn observed(&mut self, index: usize) -> &[f64] {
        self.states[index].get_mut().unwrap_or_else(PoisonError::into_inner)
    }

    /// The observed `[x, ẋ]` of one trajectory of a joint with any smooth force, zeros after it stopped, and why it did.
    pub fn trajectory<F: ForceModel<f64>>(
        &self,
        model: &JointModel<f64, F>,
        problem: &SurrogateProblem<'_>,
    ) -> (Vec<f64>, Option<(FailureKind, f64)>) {
        let forces = PointForces::new(&model.force);
        let memory = forces.memory();
        let mut force = SealedPoints { forces, masses: problem.masses, memory };
        self.trajectory_of(Mechanics::of(model), problem, &mut force)
    }

    /// The body of [`trajectory`](Self::trajectory), which is compiled once and not for every force model.
    fn trajectory_of(
        &self,
        mechanics: Mechanics,
        problem: &SurrogateProblem<'_>,
        force: &mut dyn NodeForce,
    ) -> (Vec<f64>, Option<(FailureKind, f64)>) {
        let mut states = Vec::new();
        let solved = arch().dispatch(Run {
            scheme: &self.scheme,
            mechanics,
            problem,
            force,
            states: &mut states,
            workspace: &mut Workspace::default(),
            loss: None,
        });
        let failure = self.failure(&solved, problem);
        (states, failure)
    }

    fn solve(
        &self,
        motion: &SurrogateMotion,
        index: usize,
        problem: &SurrogateProblem<'_>,
        loss: &MotionLoss<'_>,
        backward: bool,
    ) -> Solved {
        let spare = || self.spare.lock().unwrap_or_else(PoisonError::into_inner);
        let mut workspace = spare().pop().unwrap_or_default();
        let parameters = motion.network.parameter_len();
        let mut network = match workspace.network.take() {
            Some((len, kept)) if len == parameters => kept,
            _ => motion.network.workspace(),
        };
        let masses_g = [problem.masses.flexor_g, problem.masses.extensor_g];
        let mut force = motion.network.sealed(masses_g, &mut network);
        let mut states = self.states[index].lock().unwrap_or_else(PoisonError::into_inner);
        let loss = |states: &[f64], cotangents: &mut [f64]| loss(index, states, cotangents);
        let mut solved = arch().dispatch(Run {
            scheme: &self.scheme,
            mechanics: motion.mechanics,
            problem,
            force: &mut force as &mut dyn NodeForce,
            states: &mut states,
            workspace: &mut workspace,
            loss: Some((&loss, backward)),
        });
        if backward && solved.stop.is_none() && solved.refused.is_none() {
            let nodes = &workspace.surface;
            solved.network = vec![0.0; parameters];
            let (by_parameters, by_masses) = (&mut solved.network, &mut solved.masses);
            force.pull_back(&nodes.points, &nodes.values, by_parameters, by_masses);
        }
        workspace.network = Some((parameters, network));
        spare().push(workspace);
        solved
    }

    /// Why a trajectory stopped early, and the time it had reached.
    fn failure(
        &self,
        solved: &Solved,
        problem: &SurrogateProblem<'_>,
    ) -> Option<(FailureKind, f64)> {
        let (settings, start_s) = (&self.scheme.settings, problem.t0);
        if let Some(why) = &solved.refused {
            return Some((FailureKind::Request(why.clone()), start_s));
        }
        Some(match solved.stop? {
            Stop::Rough { time_s } => (
                FailureKind::Request(format!(
                    "the force bends too sharply for a surrogate within {} mN; integrate through the network",
                    settings.force_error_mn
                )),
                time_s,
            ),
            Stop::NonFinite { time_s, step_s } => (FailureKind::NonFinite { step_s }, time_s),
            Stop::StepTooSmall { time_s, step_s } => (FailureKind::StepTooSmall { step_s }, time_s),
            Stop::TooManySteps { time_s } => {
                (FailureKind::TooManySteps { limit: problem.most_steps(settings) }, time_s)
            }
        })
    }
}
