//! Many trajectories, their losses and the gradient of the sum.

use crate::forcing::{ForceSignal, Line, StepForcing};
use crate::method::Method;
use crate::nodes::{NodeNetwork, NodeWorkspace};
use crate::polynomial::Interpolation;
use crate::surface::{Fidelity, Surface, SurfaceWorkspace};
use crate::trajectory::{Control, Course, Mechanics, Motion, MotionSums, Step, Stop};
use pam_core::simd::arch;
use pam_core::{JointModel, NetworkForce, SealedMasses, parallel};
use pam_solvers::{FailureKind, TrajectoryFailure};
use pulp::{Simd, WithSimd};
use std::sync::{Mutex, PoisonError};

/// Accuracy of surrogates and steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurrogateSettings {
    /// Largest error of the force between the nodes of a patch, mN.
    pub force_error_mn: f64,
    /// Largest error of a step by the embedded method, mm.
    pub step_error_mm: f64,
    /// Longest step, s.
    pub longest_step_s: f64,
    /// Most patches of one trajectory; a force that needs more is too rough for a surrogate.
    pub most_patches: usize,
    /// Most steps of one trajectory.
    pub most_steps: usize,
}

impl Default for SurrogateSettings {
    fn default() -> Self {
        Self {
            force_error_mn: 0.3,
            step_error_mm: 1e-6,
            longest_step_s: 0.02,
            most_patches: 4000,
            most_steps: 50_000_000,
        }
    }
}

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
        let physical = model.physical();
        Self {
            network: NodeNetwork::new(force),
            mechanics: Mechanics {
                per_mass: physical.mass_kg.recip(),
                damping_kg_s: model.auxiliary_damping_kg_s,
                limit_mm: model.geometry.displacement_limit_mm(physical.deformation),
            },
        }
    }
}

/// One trajectory to be solved and observed.
#[derive(Debug, Clone, Copy)]
pub struct SurrogateProblem<'a> {
    /// The air sealed in the muscles.
    pub masses: SealedMasses,
    /// The force on the joint.
    pub signal: ForceSignal<'a>,
    /// Start, s.
    pub t0: f64,
    /// End, s.
    pub t1: f64,
    /// Displacement (mm) and velocity (mm/s) at the start.
    pub y0: [f64; 2],
    /// Observation times (s, increasing, within start and end).
    pub observe_s: &'a [f64],
    /// Displacements (mm) and velocities (mm/s) near which the motion is expected: the measured ones. The surrogate is made
    /// there beforehand, and elsewhere on the way; both may be empty.
    pub expected: [&'a [f64]; 2],
}

/// The loss of a trajectory: gets its index and the observed `[x, ẋ]` one after the other, and writes their cotangents.
pub type MotionLoss<'a> = dyn Fn(usize, &[f64], &mut [f64]) -> f64 + Sync + 'a;

/// Work that was done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SurrogateStatistics {
    /// Accepted steps.
    pub steps: usize,
    /// Rejected steps.
    pub rejected: usize,
    /// Patches of the surrogates.
    pub patches: usize,
    /// Evaluations of the network.
    pub evaluations: usize,
}

/// Losses of trajectories, with the gradient of their sum if it was asked for (zeros otherwise).
///
/// Trajectories that stopped early add nothing to the sum and its gradient. Derivatives are per unit of the quantity: kg,
/// kg/s, g, mm and mm/s.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SurrogateGradient {
    /// The loss of each trajectory; NaN where it stopped early.
    pub values: Vec<f64>,
    /// With respect to the network's parameters, in the order of [`ParametricForce`](pam_core::ParametricForce).
    pub network: Vec<f64>,
    /// With respect to m.
    pub mass: f64,
    /// With respect to B.
    pub damping: f64,
    /// With respect to `[m_f, m_e]` of each trajectory.
    pub masses: Vec<[f64; 2]>,
    /// With respect to `[x, ẋ]` at the start of each trajectory.
    pub initial_states: Vec<[f64; 2]>,
    /// Trajectories that stopped early.
    pub failures: Vec<TrajectoryFailure>,
    /// Trajectories whose force is too rough for a surrogate of the asked accuracy; they are among the failures.
    pub rough: Vec<usize>,
    /// Sums over the trajectories.
    pub statistics: SurrogateStatistics,
    /// Bytes of the stored steps.
    pub stored_bytes: usize,
}

/// Solves trajectories on surrogates, again and again; memory is kept from call to call. Results are the same bits at any
/// number of threads and do not depend on earlier calls.
#[derive(Debug)]
pub struct SurrogateSolver {
    settings: SurrogateSettings,
    method: Method,
    interpolation: Interpolation,
    own: Vec<Mutex<Own>>,
    spare: Mutex<Vec<Workspace>>,
}

/// What belongs to one trajectory.
#[derive(Debug, Default)]
struct Own {
    states: Vec<f64>,
}

/// Memory of a thread.
#[derive(Debug, Default)]
struct Workspace {
    lines: Vec<Line>,
    forcing: StepForcing,
    surface: SurfaceWorkspace,
    steps: Vec<Step>,
    cotangents: Vec<f64>,
    network: Option<(usize, NodeWorkspace)>,
}

/// Result of one trajectory.
struct Solved {
    value: f64,
    network: Vec<f64>,
    masses: [f64; 2],
    sums: MotionSums,
    statistics: SurrogateStatistics,
    stored_bytes: usize,
    stop: Option<Stop>,
    refused: Option<String>,
}

/// Root cells along x and along ẋ over the expected motion. Networks bend more often along ẋ.
const ROOT_CELLS: [f64; 2] = [1.0, 2.0];
/// Root cells are at least this large, mm and mm/s.
const SMALLEST_ROOT: [f64; 2] = [0.05, 0.5];
/// Most points of the expected motion that are looked at.
const EXPECTED_POINTS: usize = 20_000;

impl Default for SurrogateSolver {
    fn default() -> Self {
        Self::new(SurrogateSettings::default())
    }
}

impl SurrogateSolver {
    /// A solver of this accuracy.
    #[must_use]
    pub fn new(settings: SurrogateSettings) -> Self {
        Self {
            settings,
            method: Method::new(),
            interpolation: Interpolation::new(),
            own: Vec::new(),
            spare: Mutex::default(),
        }
    }

    /// The losses of trajectories; with `backward` the gradient of their sum.
    pub fn evaluate(
        &mut self,
        motion: &SurrogateMotion,
        problems: &[SurrogateProblem<'_>],
        loss: &MotionLoss<'_>,
        backward: bool,
    ) -> SurrogateGradient {
        if self.own.len() < problems.len() {
            self.own.resize_with(problems.len(), Mutex::default);
        }
        let this = &*self;
        let all = parallel::map(problems.len(), |i| {
            this.solve(motion, i, &problems[i], loss, backward)
        });
        let mut sum = SurrogateGradient {
            network: vec![0.0; if backward { motion.network.parameter_len() } else { 0 }],
            ..SurrogateGradient::default()
        };
        for (problem, one) in all.into_iter().enumerate() {
            let stopped = one.stop.is_some() || one.refused.is_some();
            sum.values.push(if stopped { f64::NAN } else { one.value });
            sum.masses.push(one.masses);
            sum.initial_states.push(one.sums.start);
            let total = &mut sum.statistics;
            total.steps += one.statistics.steps;
            total.rejected += one.statistics.rejected;
            total.patches += one.statistics.patches;
            total.evaluations += one.statistics.evaluations;
            sum.stored_bytes += one.stored_bytes;
            sum.network.iter_mut().zip(&one.network).for_each(|(s, g)| *s += g);
            let per_mass = motion.mechanics.per_mass;
            sum.mass -= per_mass * per_mass * one.sums.per_mass;
            sum.damping += one.sums.damping;
            if let Some(why) = one.refused {
                let kind = FailureKind::Request(why);
                sum.failures.push(TrajectoryFailure { problem, kind, time_s: problems[problem].t0 });
            }
            if let Some(stop) = one.stop {
                if matches!(stop, Stop::Rough { .. }) {
                    sum.rough.push(problem);
                }
                let (kind, time_s) = self.described(stop);
                sum.failures.push(TrajectoryFailure { problem, kind, time_s });
            }
        }
        sum
    }

    /// The observed `[x, ẋ]` of a trajectory of the last call, one after the other; zeros after it stopped.
    ///
    /// # Panics
    /// If there was none of this index.
    pub fn observed(&mut self, index: usize) -> &[f64] {
        &self.own[index].get_mut().unwrap_or_else(PoisonError::into_inner).states
    }

    fn described(&self, stop: Stop) -> (FailureKind, f64) {
        match stop {
            Stop::Rough { time_s } => (
                FailureKind::Request(format!(
                    "the force bends too sharply for a surrogate within {} mN",
                    self.settings.force_error_mn
                )),
                time_s,
            ),
            Stop::NonFinite { time_s, step_s } => (FailureKind::NonFinite { step_s }, time_s),
            Stop::StepTooSmall { time_s, step_s } => (FailureKind::StepTooSmall { step_s }, time_s),
            Stop::TooManySteps { time_s } => {
                (FailureKind::TooManySteps { limit: self.settings.most_steps }, time_s)
            }
        }
    }

    fn solve(
        &self,
        motion: &SurrogateMotion,
        index: usize,
        problem: &SurrogateProblem<'_>,
        loss: &MotionLoss<'_>,
        backward: bool,
    ) -> Solved {
        let lock = |m: &Mutex<Vec<Workspace>>| m.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut workspace = lock(&self.spare).unwrap_or_default();
        let parameters = motion.network.parameter_len();
        let network = match workspace.network.take() {
            Some((len, kept)) if len == parameters => kept,
            _ => motion.network.workspace(),
        };
        workspace.network = Some((parameters, network));
        let mut own = self.own[index].lock().unwrap_or_else(PoisonError::into_inner);
        let one = One {
            solver: self,
            motion,
            problem,
            loss: &|states, cotangents| loss(index, states, cotangents),
            backward,
            states: &mut own.states,
            workspace: &mut workspace,
        };
        let solved = arch().dispatch(one);
        self.spare.lock().unwrap_or_else(PoisonError::into_inner).push(workspace);
        solved
    }
}

/// One trajectory, run for the instruction set of the machine.
struct One<'a, 'p> {
    solver: &'a SurrogateSolver,
    motion: &'a SurrogateMotion,
    problem: &'a SurrogateProblem<'p>,
    loss: &'a dyn Fn(&[f64], &mut [f64]) -> f64,
    backward: bool,
    states: &'a mut Vec<f64>,
    workspace: &'a mut Workspace,
}

impl WithSimd for One<'_, '_> {
    type Output = Solved;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Solved {
        let Self { solver, motion, problem, loss, backward, states, workspace } = self;
        let mut solved = Solved {
            value: f64::NAN,
            network: Vec::new(),
            masses: [0.0; 2],
            sums: MotionSums::default(),
            statistics: SurrogateStatistics::default(),
            stored_bytes: 0,
            stop: None,
            refused: None,
        };
        let observations = problem.observe_s.len();
        states.clear();
        states.resize(2 * observations, 0.0);
        if let Err(why) = problem.check() {
            solved.refused = Some(why);
            return solved;
        }
        let Workspace { lines, forcing, surface: memory, steps, cotangents, network } = workspace;
        let Some((_, network)) = network else { return solved };
        problem.signal.lines_into(lines);
        let settings = &solver.settings;
        let masses = [problem.masses.flexor_g, problem.masses.extensor_g];
        let nodes = motion.network.sealed(masses);
        let fidelity =
            Fidelity { error_mn: settings.force_error_mn, most_patches: settings.most_patches };
        let (origin, width) = problem.roots();
        let mut surface = Surface::new(&nodes, &solver.interpolation, fidelity, origin, width);
        let at_start = problem.observed_at_start();
        for state in states[..2 * at_start].as_chunks_mut::<2>().0 {
            *state = problem.y0;
        }
        let course = Course {
            start_s: problem.t0,
            end_s: problem.t1,
            state: problem.y0,
            observe_s: &problem.observe_s[at_start..],
        };
        let control = Control {
            error_mm: settings.step_error_mm,
            longest_s: settings.longest_step_s,
            most_steps: settings.most_steps,
        };
        if surface.make_along(problem.expected_points(), memory, network).is_err() {
            solved.stop = Some(Stop::Rough { time_s: problem.t0 });
            return solved;
        }
        let mut run = Motion {
            method: &solver.method,
            mechanics: motion.mechanics,
            lines,
            surface: &mut surface,
            memory,
            network,
            forcing,
            patch: 0,
        };
        let later = states[2 * at_start..].as_chunks_mut::<2>().0;
        let rejected = &mut solved.statistics.rejected;
        let outcome = run.forward(simd, &course, &control, later, steps, rejected);
        solved.statistics.steps = steps.len().saturating_sub(1);
        solved.stored_bytes = size_of_val(&steps[..]);
        if let Err(stop) = outcome {
            solved.stop = Some(stop);
        } else {
            cotangents.clear();
            cotangents.resize(2 * observations, 0.0);
            solved.value = loss(states, cotangents);
            if backward {
                let (first, later) = cotangents.split_at(2 * at_start);
                match run.backward(simd, &course, steps, later.as_chunks::<2>().0) {
                    Err(_) => solved.stop = Some(Stop::Rough { time_s: problem.t0 }),
                    Ok(sums) => {
                        solved.sums = sums;
                        for c in first.as_chunks::<2>().0 {
                            solved.sums.start[0] += c[0];
                            solved.sums.start[1] += c[1];
                        }
                        solved.network = vec![0.0; motion.network.parameter_len()];
                        surface.pull_back(&mut solved.network, &mut solved.masses, memory, network);
                    }
                }
            }
        }
        solved.statistics.patches = surface.patches.len();
        solved.statistics.evaluations = surface.evaluations;
        solved
    }
}

impl SurrogateProblem<'_> {
    fn observed_at_start(&self) -> usize {
        self.observe_s.partition_point(|&t| t <= self.t0)
    }

    /// Middle and size of the root cells.
    fn roots(&self) -> ([f64; 2], [f64; 2]) {
        let mut origin = self.y0;
        let mut width = SMALLEST_ROOT;
        for d in 0..2 {
            let range = self.expected[d].iter().fold(
                [self.y0[d]; 2],
                |[low, high], &v| if v.is_finite() { [low.min(v), high.max(v)] } else { [low, high] },
            );
            origin[d] = 0.5 * (range[0] + range[1]);
            // The outermost points lie inside.
            width[d] = (1.01 * (range[1] - range[0]) / ROOT_CELLS[d]).max(SMALLEST_ROOT[d]);
        }
        (origin, width)
    }

    fn expected_points(&self) -> impl Iterator<Item = [f64; 2]> + Clone {
        let [x, v] = self.expected;
        let every = (x.len() / EXPECTED_POINTS).max(1);
        let pairs = x.iter().zip(v).step_by(every).map(|(&x, &v)| [x, v]);
        pairs.filter(|p| p.iter().all(|c| c.is_finite()))
    }

    /// Checks the request; the error is the reason why it is inconsistent.
    fn check(&self) -> Result<(), String> {
        let ForceSignal { times_s, force_mn, interpolation } = self.signal;
        if times_s.is_empty() || times_s.len() != force_mn.len() {
            return Err(format!(
                "{} sample times and {} forces do not make a signal",
                times_s.len(),
                force_mn.len()
            ));
        }
        if interpolation == pam_solvers::Interpolation::Cubic {
            return Err("a cubic reading of the force is no straight line between samples; surrogates take it held, \
                        linear or as a ramp"
                .into());
        }
        if !(self.t0 <= self.t1 && self.t1.is_finite()) {
            return Err(format!("the interval from {} to {} s does not run forward", self.t0, self.t1));
        }
        let finite = |values: &[f64]| values.iter().all(|v| v.is_finite());
        if !finite(&self.y0) || !finite(force_mn) {
            return Err("the initial state or the force is infinite or NaN".into());
        }
        let increasing = |times: &[f64]| times.windows(2).all(|pair| pair[0] < pair[1]);
        if !increasing(times_s) || !increasing(self.observe_s) {
            return Err("sample and observation times must increase".into());
        }
        let within = |t: Option<&f64>| t.is_none_or(|&t| t >= self.t0 && t <= self.t1);
        if !within(self.observe_s.first()) || !within(self.observe_s.last()) {
            return Err("an observation lies outside of start and end".into());
        }
        Ok(())
    }
}
