//! Many trajectories, their losses and the gradient of the sum.

use crate::gradient::ExactGradient;
use crate::gradient::costate::{CostatePass, RegionMoments};
use crate::gradient::weights::{WeightGradient, WeightWorkspace};
use crate::simd::zero;
use crate::trajectory::forcing::{ForcingSegment, ForcingSegments};
use crate::trajectory::forward::{ForwardSolve, Segment, Stopped};
use crate::trajectory::motion::{MotionRegions, MotionWorkspace};
use crate::trajectory::{ExactMotion, ExactProblem, ExactStatistics};
use pam_core::parallel;
use pam_solvers::{FailureKind, TrajectoryFailure};
use std::sync::Mutex;

/// Solves trajectories in closed form, in parallel, and keeps its memory between calls.
#[derive(Debug, Default)]
pub struct ExactSolver {
    workers: Mutex<Vec<Worker>>,
    results: Vec<Mutex<TrajectoryResult>>,
}

/// The loss of one trajectory: as that of [`ExactSolver::value_and_gradient`], without the index.
type OneLoss<'a> = dyn Fn(&[f64], &mut [f64]) -> f64 + 'a;

/// Memory of one thread.
#[derive(Debug, Default)]
struct Worker {
    motion: MotionWorkspace,
    cut: Vec<ForcingSegment>,
    backward: BackwardWorkspace,
}

/// Memory of the backward pass.
#[derive(Debug, Default)]
struct BackwardWorkspace {
    segments: Vec<Segment>,
    cotangents: Vec<f64>,
    moments: Vec<RegionMoments>,
    weights: WeightWorkspace,
}

/// Solution and gradient of one trajectory.
#[derive(Debug, Default)]
struct TrajectoryResult {
    value: f64,
    states: Vec<f64>,
    network: Vec<f64>,
    mass: f64,
    damping: f64,
    masses: [f64; 2],
    start: [f64; 2],
    statistics: ExactStatistics,
    stored_bytes: usize,
    failure: Option<TrajectoryFailure>,
}

impl ExactSolver {
    /// A solver with no memory yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// The sum of the losses of all problems with its gradient.
    ///
    /// `loss(index, states, cotangents)` gets the observed states `[times, (x, ẋ)]` of problem `index`,
    /// writes the loss's derivative with respect to them to `cotangents` (zeros on entry) and returns
    /// the loss. It is called from several threads; results are the same bits at any number of them.
    pub fn value_and_gradient(
        &mut self,
        motion: &ExactMotion,
        problems: &[ExactProblem<'_>],
        loss: &(impl Fn(usize, &[f64], &mut [f64]) -> f64 + Sync),
    ) -> ExactGradient {
        self.run(motion, problems, Some(loss), true)
    }

    /// As [`value_and_gradient`](Self::value_and_gradient), without `backward` the losses alone: the gradients of
    /// the result are then zero.
    pub fn evaluate(
        &mut self,
        motion: &ExactMotion,
        problems: &[ExactProblem<'_>],
        loss: &(impl Fn(usize, &[f64], &mut [f64]) -> f64 + Sync),
        backward: bool,
    ) -> ExactGradient {
        self.run(motion, problems, Some(loss), backward)
    }

    /// Solves all problems and returns the failures; [`observed`](Self::observed) has the states.
    pub fn solve(
        &mut self,
        motion: &ExactMotion,
        problems: &[ExactProblem<'_>],
    ) -> Vec<TrajectoryFailure> {
        self.run(motion, problems, None::<&fn(usize, &[f64], &mut [f64]) -> f64>, false).failures
    }

    /// The observed states `[times, (x, ẋ)]` of a problem of the last call.
    ///
    /// # Panics
    /// If there was no such problem.
    pub fn observed(&mut self, problem: usize) -> &[f64] {
        &self.results[problem].get_mut().expect("no worker panics").states
    }

    /// Counts of a problem of the last call.
    ///
    /// # Panics
    /// If there was no such problem.
    pub fn statistics(&mut self, problem: usize) -> ExactStatistics {
        self.results[problem].get_mut().expect("no worker panics").statistics
    }

    fn run(
        &mut self,
        motion: &ExactMotion,
        problems: &[ExactProblem<'_>],
        loss: Option<&(impl Fn(usize, &[f64], &mut [f64]) -> f64 + Sync)>,
        backward: bool,
    ) -> ExactGradient {
        if self.results.len() < problems.len() {
            self.results.resize_with(problems.len(), Mutex::default);
        }
        let (workers, results) = (&self.workers, &self.results);
        parallel::for_each(problems.len(), &|index| {
            let mut worker = workers.lock().expect("no worker panics").pop().unwrap_or_default();
            let mut result = results[index].lock().expect("no worker panics");
            let one = loss.map(|loss| {
                move |states: &[f64], cotangents: &mut [f64]| loss(index, states, cotangents)
            });
            let loss = one.as_ref().map(|one| one as &OneLoss<'_>);
            let outcome = worker.run(motion, &problems[index], loss, backward, &mut result);
            result.failure = outcome.err().map(|stopped| TrajectoryFailure {
                problem: index,
                kind: stopped.kind,
                time_s: stopped.time_s,
            });
            workers.lock().expect("no worker panics").push(worker);
        });
        let mut sum = ExactGradient {
            network: vec![0.0; motion.network.parameter_count()],
            ..ExactGradient::default()
        };
        for result in self.results.iter_mut().take(problems.len()) {
            result.get_mut().expect("no worker panics").add_to(&mut sum, backward);
        }
        sum
    }
}

impl TrajectoryResult {
    /// Forgets the last call; states and network gradient are written later.
    fn restart(&mut self, observations: usize) {
        self.value = f64::NAN;
        (self.masses, self.start) = ([0.0; 2], [0.0; 2]);
        self.statistics = ExactStatistics::default();
        self.stored_bytes = 0;
        self.states.resize(2 * observations, 0.0);
    }

    fn add_to(&self, sum: &mut ExactGradient, backward: bool) {
        sum.statistics.segments += self.statistics.segments;
        sum.statistics.crossings += self.statistics.crossings;
        sum.statistics.regions += self.statistics.regions;
        sum.stored_bytes += self.stored_bytes;
        sum.values.push(self.value);
        sum.masses.push(self.masses);
        sum.initial_states.push(self.start);
        if let Some(failure) = &self.failure {
            sum.failures.push(failure.clone());
            return;
        }
        sum.value += self.value;
        if backward {
            for (sum, g) in sum.network.iter_mut().zip(&self.network) {
                *sum += g;
            }
            sum.mass += self.mass;
            sum.damping += self.damping;
        }
    }
}

impl Worker {
    fn run(
        &mut self,
        motion: &ExactMotion,
        problem: &ExactProblem<'_>,
        loss: Option<&OneLoss<'_>>,
        with_gradient: bool,
        result: &mut TrajectoryResult,
    ) -> Result<(), Stopped> {
        let Self { motion: workspace, cut, backward } = self;
        let observations = problem.observe_s.len();
        result.restart(observations);
        if let Err(why) = problem.check() {
            result.states.fill(0.0);
            let kind = FailureKind::Request(why);
            return Err(Stopped { kind, time_s: problem.t0, reached: 0 });
        }
        let forcing = problem.forcing_segments(cut);
        let nominal_s = forcing.nominal_length_s();
        let memory = std::mem::take(workspace);
        let mut regions =
            MotionRegions::new(motion, problem.masses_g(), nominal_s, with_gradient, memory);
        backward.segments.clear();
        let at_start = problem.observed_at_start();
        for state in result.states[..2 * at_start].as_chunks_mut::<2>().0 {
            *state = problem.y0;
        }
        let outcome = ForwardSolve {
            regions: &mut regions,
            forcing,
            start: problem.y0,
            segments: with_gradient.then_some(&mut backward.segments),
            observed: &mut result.states[2 * at_start..],
            statistics: &mut result.statistics,
        }
        .run();
        result.statistics.regions = regions.coefficients.len();
        result.stored_bytes = size_of_val(&backward.segments[..]);
        if let Err(stopped) = &outcome {
            result.states[2 * (at_start + stopped.reached)..].fill(0.0);
        } else if let Some(loss) = loss {
            zero(&mut backward.cotangents, 2 * observations);
            result.value = loss(&result.states, &mut backward.cotangents);
            if with_gradient {
                backward.run(problem, &regions, forcing, result);
            }
        }
        *workspace = regions.into_workspace();
        outcome
    }
}

impl BackwardWorkspace {
    /// The gradient of a trajectory that was solved, whose segments and cotangents are in the workspace.
    fn run(
        &mut self,
        problem: &ExactProblem<'_>,
        regions: &MotionRegions<'_>,
        forcing: ForcingSegments<'_>,
        result: &mut TrajectoryResult,
    ) {
        let Self { segments, cotangents, moments, weights } = self;
        let (at_start, later) = cotangents.split_at(2 * problem.observed_at_start());
        zero(&mut result.network, regions.motion.network.parameter_count());
        moments.clear();
        moments.resize(regions.coefficients.len(), RegionMoments::default());
        let sums = CostatePass { regions, forcing, segments, cotangents: later, moments }.run();
        result.start = sums.start;
        for c in at_start.as_chunks::<2>().0 {
            result.start[0] += c[0];
            result.start[1] += c[1];
        }
        result.masses = WeightGradient::new(regions, problem.masses_g(), moments, weights)
            .add_to(&mut result.network);
        result.mass = sums.mass;
        result.damping = sums.damping;
    }
}
