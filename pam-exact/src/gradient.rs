//! Many trajectories, their losses and the gradient of the sum.

use crate::adjoint::{Adjoint, PatternMoments};
use crate::forcing::{ForceSignal, Piece, Pieces};
use crate::motion::{ExactMotion, LawMemory, Laws};
use crate::pullback::{NetworkSums, PullBack};
use crate::solve::{ExactStatistics, Segment, Solve, Stopped};
use pam_core::SealedMasses;
use pam_solvers::{BatchGradient, FailureKind, Interpolation, TrajectoryFailure};
use rayon::prelude::*;
use std::sync::Mutex;

/// One trajectory to be solved and observed.
#[derive(Debug, Clone, Copy)]
pub struct ExactProblem<'a> {
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
    /// Times (s, increasing, within start and end) at which it is observed.
    pub observe_s: &'a [f64],
}

/// The exact solver: its limits and the memory that is kept between calls.
#[derive(Debug, Default)]
pub struct ExactSolver {
    /// Steps are no longer than this, s; unlimited unless set. The solution does not depend on it.
    longest_step_s: Option<f64>,
    workers: Mutex<Vec<Worker>>,
    results: Vec<Mutex<OneResult>>,
}

/// Most sign changes of one trajectory.
const MOST_CROSSINGS: usize = 50_000_000;

/// The loss of one trajectory: as that of [`ExactSolver::value_and_gradient`], without the index.
type OneLoss<'a> = dyn Fn(&[f64], &mut [f64]) -> f64 + 'a;

/// Memory of one thread.
#[derive(Debug, Default)]
struct Worker {
    laws: LawMemory,
    cut: Vec<Piece>,
    segments: Vec<Segment>,
    cotangents: Vec<f64>,
    moments: Vec<PatternMoments>,
    network: NetworkSums,
}

/// What one trajectory gives.
#[derive(Debug, Default)]
struct OneResult {
    value: f64,
    states: Vec<f64>,
    shared: Vec<f64>,
    own: [f64; 2],
    start: [f64; 2],
    statistics: ExactStatistics,
    bytes: usize,
    failure: Option<TrajectoryFailure>,
}

impl ExactProblem<'_> {
    fn check(&self) -> Result<(), String> {
        let ForceSignal { times_s, force_mn, interpolation } = self.signal;
        if times_s.is_empty() || times_s.len() != force_mn.len() {
            return Err(format!(
                "{} sample times and {} forces do not make a signal",
                times_s.len(),
                force_mn.len()
            ));
        }
        if interpolation == Interpolation::Cubic {
            return Err("a cubic reading of the force is no straight line between samples; \
                        the exact method reads it held, linear or as a ramp"
                .into());
        }
        if !(self.t0 <= self.t1 && self.t1.is_finite()) {
            return Err(format!(
                "the interval from {} to {} s does not run forward",
                self.t0, self.t1
            ));
        }
        // Sums in place of early exits: these loops are wide.
        let finite = |values: &[f64]| values.iter().fold(true, |all, v| all & v.is_finite());
        if !finite(&self.y0) || !finite(force_mn) {
            return Err("the initial state or the force is infinite or NaN".into());
        }
        let increasing = |times: &[f64]| {
            let next = times.get(1..).unwrap_or_default();
            times.iter().zip(next).fold(true, |all, (t, next)| all & (t < next))
        };
        let same = std::ptr::eq(times_s, self.observe_s);
        if !increasing(times_s) || (!same && !increasing(self.observe_s)) {
            return Err("sample and observation times must increase".into());
        }
        let within = |t: Option<&f64>| t.is_none_or(|&t| t >= self.t0 && t <= self.t1);
        if !within(self.observe_s.first()) || !within(self.observe_s.last()) {
            return Err("an observation lies outside of start and end".into());
        }
        Ok(())
    }
}

impl ExactSolver {
    /// A solver with no memory yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Limits the length of a step, s. There is no need to: steps are exact at any length, and no
    /// crossing is missed. Tests use it to show that.
    #[must_use]
    pub fn with_longest_step(mut self, step_s: f64) -> Self {
        self.longest_step_s = Some(step_s);
        self
    }

    /// The sum of the losses of all problems with its gradient.
    ///
    /// `loss(index, states, cotangents)` gets the observed states `[times, (x, ẋ)]` of problem `index`,
    /// writes the loss's derivative with respect to them to `cotangents` (zeros on entry) and returns
    /// the loss. It is called from several threads; results are the same bits at any number of them.
    ///
    /// The shared parameters are the network's in the order of
    /// [`ParametricForce`](pam_core::ParametricForce), then m and B; each problem's own are its two
    /// masses. In the counts, steps are closed-form steps and evaluations are sign changes.
    pub fn value_and_gradient(
        &mut self,
        motion: &ExactMotion,
        problems: &[ExactProblem<'_>],
        loss: &(impl Fn(usize, &[f64], &mut [f64]) -> f64 + Sync),
    ) -> BatchGradient {
        self.run(motion, problems, Some(loss), true)
    }

    /// The sum of the losses alone; the gradients of the result are zero.
    pub fn value(
        &mut self,
        motion: &ExactMotion,
        problems: &[ExactProblem<'_>],
        loss: &(impl Fn(usize, &[f64], &mut [f64]) -> f64 + Sync),
    ) -> BatchGradient {
        self.run(motion, problems, Some(loss), false)
    }

    /// Solves all problems; the observed states are read with [`observed`](Self::observed).
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
    ) -> BatchGradient {
        if self.results.len() < problems.len() {
            self.results.resize_with(problems.len(), Mutex::default);
        }
        let longest_s = self.longest_step_s.unwrap_or(f64::INFINITY);
        let (workers, results) = (&self.workers, &self.results);
        (0..problems.len()).into_par_iter().with_max_len(1).for_each(|index| {
            let mut worker = workers.lock().expect("no worker panics").pop().unwrap_or_default();
            let mut result = results[index].lock().expect("no worker panics");
            let one = loss.map(|loss| {
                move |states: &[f64], cotangents: &mut [f64]| loss(index, states, cotangents)
            });
            let one = one.as_ref().map(|one| one as &OneLoss<'_>);
            let outcome =
                worker.one(motion, &problems[index], longest_s, one, backward, &mut result);
            result.failure = outcome.err().map(|stopped| TrajectoryFailure {
                problem: index,
                kind: stopped.kind,
                time_s: stopped.time_s,
            });
            workers.lock().expect("no worker panics").push(worker);
        });
        let mut sum = BatchGradient {
            shared: vec![0.0; motion.network.parameter_len() + 2],
            ..BatchGradient::default()
        };
        for result in self.results.iter_mut().take(problems.len()) {
            let result = result.get_mut().expect("no worker panics");
            sum.accepted += result.statistics.segments;
            sum.evaluations += result.statistics.crossings;
            sum.stored_bytes += result.bytes;
            sum.values.push(result.value);
            sum.own.push(result.own.to_vec());
            sum.initial_state.push(result.start.to_vec());
            if let Some(failure) = &result.failure {
                sum.failures.push(failure.clone());
                continue;
            }
            sum.value += result.value;
            if backward {
                sum.linearised += result.statistics.patterns;
                for (sum, g) in sum.shared.iter_mut().zip(&result.shared) {
                    *sum += g;
                }
            }
        }
        sum
    }
}

impl Worker {
    fn one(
        &mut self,
        motion: &ExactMotion,
        problem: &ExactProblem<'_>,
        longest_s: f64,
        loss: Option<&OneLoss<'_>>,
        backward: bool,
        result: &mut OneResult,
    ) -> Result<(), Stopped> {
        let zero = |buffer: &mut Vec<f64>, len: usize| {
            buffer.clear();
            buffer.resize(len, 0.0);
        };
        let observations = problem.observe_s.len();
        result.value = f64::NAN;
        result.own = [0.0; 2];
        result.start = [0.0; 2];
        result.statistics = ExactStatistics::default();
        result.bytes = 0;
        result.states.resize(2 * observations, 0.0);
        if let Err(why) = problem.check() {
            result.states.fill(0.0);
            return Err(Stopped {
                kind: FailureKind::Request(why),
                time_s: problem.t0,
                reached: 0,
            });
        }
        let span = (problem.t0, problem.t1);
        let pieces = problem.signal.pieces(span, problem.observe_s, longest_s, &mut self.cut);
        let masses_g = [problem.masses.flexor_g, problem.masses.extensor_g];
        let usual_s = usual_length(&pieces);
        let memory = std::mem::take(&mut self.laws);
        let mut laws = Laws::new(motion, masses_g, usual_s, backward, memory);
        self.segments.clear();
        let at_start = problem.observe_s.partition_point(|&t| t <= problem.t0);
        for state in result.states[..2 * at_start].as_chunks_mut::<2>().0 {
            *state = problem.y0;
        }
        let outcome = Solve {
            laws: &mut laws,
            pieces,
            start: problem.y0,
            segments: backward.then_some(&mut self.segments),
            observed: &mut result.states[2 * at_start..],
            most_crossings: MOST_CROSSINGS,
            statistics: &mut result.statistics,
        }
        .run();
        result.statistics.patterns = laws.laws.len();
        result.bytes = size_of_val(&self.segments[..]);
        if let Err(stopped) = &outcome {
            result.states[2 * (at_start + stopped.reached)..].fill(0.0);
        } else if let Some(loss) = loss {
            zero(&mut self.cotangents, 2 * observations);
            result.value = loss(&result.states, &mut self.cotangents);
            if backward {
                zero(&mut result.shared, motion.network.parameter_len() + 2);
                self.moments.clear();
                self.moments.resize(laws.laws.len(), PatternMoments::default());
                let sums = Adjoint {
                    laws: &laws,
                    pieces,
                    segments: &self.segments,
                    cotangents: &self.cotangents[2 * at_start..],
                    moments: &mut self.moments,
                }
                .run();
                result.start = sums.start;
                for c in self.cotangents[..2 * at_start].as_chunks::<2>().0 {
                    result.start[0] += c[0];
                    result.start[1] += c[1];
                }
                let len = motion.network.parameter_len();
                result.own = PullBack {
                    laws: &laws,
                    masses_g,
                    moments: &self.moments,
                    sums: &mut self.network,
                }
                .run(&mut result.shared[..len]);
                result.shared[len] = sums.mass;
                result.shared[len + 1] = sums.damping;
            }
        }
        self.laws = laws.into_memory();
        outcome
    }
}

/// A trajectory with all its segments.
#[derive(Debug)]
pub(crate) struct Follow<'n> {
    pub(crate) laws: Laws<'n>,
    pub(crate) pieces: Vec<Piece>,
    pub(crate) segments: Vec<Segment>,
}

impl<'n> Follow<'n> {
    /// Solves a problem and keeps everything.
    pub(crate) fn new(
        motion: &'n ExactMotion,
        problem: &ExactProblem<'_>,
    ) -> Result<Self, TrajectoryFailure> {
        let failed = |kind, time_s| TrajectoryFailure { problem: 0, kind, time_s };
        problem.check().map_err(|why| failed(FailureKind::Request(why), problem.t0))?;
        let mut cut = Vec::new();
        let span = (problem.t0, problem.t1);
        let pieces = problem.signal.pieces(span, problem.observe_s, f64::INFINITY, &mut cut);
        let pieces: Vec<Piece> = pieces.iter().collect();
        let masses_g = [problem.masses.flexor_g, problem.masses.extensor_g];
        let usual_s = usual_length(&Pieces::of(&pieces));
        let mut laws = Laws::new(motion, masses_g, usual_s, true, LawMemory::default());
        let mut segments = Vec::new();
        Solve {
            laws: &mut laws,
            pieces: Pieces::of(&pieces),
            start: problem.y0,
            segments: Some(&mut segments),
            observed: &mut vec![0.0; 2 * problem.observe_s.len()],
            most_crossings: MOST_CROSSINGS,
            statistics: &mut ExactStatistics::default(),
        }
        .run()
        .map_err(|stopped| failed(stopped.kind, stopped.time_s))?;
        Ok(Self { laws, pieces, segments })
    }
}

/// The length that most pieces have: the median.
fn usual_length(pieces: &Pieces<'_>) -> f64 {
    // A few are enough: lengths differ by rounding, or the recording is irregular and none is usual.
    let step = (pieces.len() / 63).max(1);
    let some = (0..pieces.len()).step_by(step).filter_map(|k| pieces.get(k));
    let mut lengths: Vec<f64> = some.map(|piece| piece.length_s).collect();
    lengths.sort_by(f64::total_cmp);
    lengths.get(lengths.len() / 2).copied().unwrap_or(1e-3)
}
