//! Targets to masses.

use super::batch::{AnyBatch, ForceBatch};
use super::landscape::Counted;
use super::newton::{Segment, continuation, track};
use super::problem::{Outcome, Solution, SynthesisSettings, Target};
use super::relu_stencil::{ReluLayout, ReluStencil};
use super::stencil::{Evaluator, Inertia, Local};
use super::trace::{Traced, grid_nodes, nearest_around, trace};
use super::walk::{Chords, Vertex};
use crate::error::ControlError;
use pam_core::parallel;
use pam_core::{AnyForce, JointModel, SealedMasses};
use std::sync::atomic::{AtomicBool, Ordering};

/// Samples of a segment that are solved one after the other; the first one of each starts from the segment
/// before.
const SEGMENT_SAMPLES: usize = 128;

/// Samples over which the nearest stiffness is carried on before the whole curve is followed again.
const MOST_CARRIED: usize = 15;

/// Follows curves: a ReLU network goes through its stencil, anything else through the evaluator,
/// which gives the signs on the grid for both.
struct Follower<'a, B: ForceBatch> {
    evaluator: Evaluator<'a, B>,
    stencil: Option<ReluStencil<'a>>,
    /// Evaluations that remain of [`MOST_FOLLOWED`].
    left: usize,
}

/// Evaluations of force balance and stiffness that following all curves of a stretch of samples may take: so many, and so
/// many for each sample. A curve of the published network takes 250.
const MOST_FOLLOWED: [usize; 2] = [100_000, 500];
/// Cost of the five forces of a smooth network, in evaluations that update those of a ReLU network.
const SMOOTH_EVALUATION: usize = 3;
/// Cost of the grid of signs, in evaluations.
const GRID_EVALUATIONS: usize = 60;

impl<B: ForceBatch> Follower<'_, B> {
    fn is_exhausted(&self) -> bool {
        self.left == 0
    }

    /// Fails if curves were not followed any more.
    fn check(&self) -> Result<(), ControlError> {
        if self.is_exhausted() { Err(endless()) } else { Ok(()) }
    }
}

/// The error of a model whose curves cannot be followed.
fn endless() -> ControlError {
    ControlError::Insufficient(
        "the masses that give the motion cannot be found in reasonable time: the model's force changes too often with the \
         masses; the model is not of this joint"
            .into(),
    )
}

/// Finds the air for motions and stiffnesses.
///
/// At each target
///
/// ```text
/// min (K̂(x_d, ẋ_d, m_f, m_e) − K_d)²   subject to   |m ẍ_d + f(x_d, ẋ_d, m_f, m_e) + B ẋ_d − F_e| ≤ ε
/// ```
///
/// within the mass bounds (Wang and Realmuto 2026, section II-E). The constraint is a curve in the plane
/// of the masses; K̂ = K_d cuts it in points. [Newton's method](super) on both equations, started from the
/// sample before, finds them (for smooth forces many samples side by side, for ReLU networks from
/// affine piece to piece); where it does not, the whole curve is followed. Results do not depend on the
/// number of threads.
#[derive(Debug, Clone)]
pub struct Synthesiser<B = AnyBatch> {
    batch: B,
    relu: Option<ReluLayout>,
    inertia: Inertia,
    settings: SynthesisSettings,
}

impl Synthesiser<AnyBatch> {
    /// For a model whose force has a name.
    ///
    /// # Errors
    /// [`ControlError::Value`] if the settings are impossible.
    pub fn new(
        model: &JointModel<f64, AnyForce<f64>>,
        settings: SynthesisSettings,
    ) -> Result<Self, ControlError> {
        let mut made = Self::with_batch(model, AnyBatch::new(&model.force), settings)?;
        if let AnyForce::Network(network) = &model.force {
            made.relu = ReluLayout::new(network);
        }
        Ok(made)
    }
}

impl<B: ForceBatch> Synthesiser<B> {
    /// For any force that can be evaluated in batches; the model gives mass and damping.
    ///
    /// # Errors
    /// [`ControlError::Value`] if the settings are impossible.
    pub fn with_batch<F>(
        model: &JointModel<f64, F>,
        batch: B,
        settings: SynthesisSettings,
    ) -> Result<Self, ControlError> {
        settings.validate()?;
        let inertia = Inertia {
            mass_kg: model.physical().mass_kg,
            damping_kg_s: model.auxiliary_damping_kg_s,
        };
        Ok(Self { batch, relu: None, inertia, settings })
    }

    /// The settings.
    #[must_use]
    pub fn settings(&self) -> &SynthesisSettings {
        &self.settings
    }

    /// The air for each target of a trajectory.
    ///
    /// # Errors
    /// [`ControlError::Value`] naming the first number that is not finite or positive;
    /// [`ControlError::Insufficient`] if the curves of the model have too many vertices to be followed at every sample.
    pub fn solve(&self, targets: &[Target]) -> Result<Vec<Solution>, ControlError> {
        targets.iter().try_for_each(Target::validate)?;
        let starts = self.starts(targets)?;
        let group = self.settings.segments;
        let samples = group * SEGMENT_SAMPLES;
        // One stretch that cannot be solved is the end of all; its error is the same for any of them.
        let given_up = AtomicBool::new(false);
        let groups: Vec<Result<Vec<Solution>, ControlError>> =
            parallel::map(starts.len().div_ceil(group), |k| {
                if given_up.load(Ordering::Relaxed) {
                    return Err(endless());
                }
                let starts = &starts[k * group..starts.len().min((k + 1) * group)];
                let from = k * samples;
                let stretch = &targets[from..(from + samples).min(targets.len())];
                let solved = self.solve_group(stretch, starts);
                given_up.fetch_or(solved.is_err(), Ordering::Relaxed);
                solved
            });
        Ok(groups.into_iter().collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
    }

    /// The reachable stiffness of a motion's point: least and largest K̂ with which the dynamics hold,
    /// N/mm; none if no masses give the acceleration. `K_d` of the target does not matter.
    #[must_use]
    pub fn reachable_n_mm(&self, target: &Target) -> Option<[f64; 2]> {
        self.trace(target, &mut self.follower(1)).range_n_mm
    }

    /// The curve of masses that give a motion's point its acceleration, branch by branch: pairs of masses
    /// with K̂ (N/mm).
    #[must_use]
    pub fn curve(&self, target: &Target) -> Vec<Vec<(SealedMasses, f64)>> {
        let point = |v: &Vertex| (masses(v.u), v.local.k);
        let traced = self.trace(target, &mut self.follower(1));
        traced.branches.iter().map(|b| b.iter().map(point).collect()).collect()
    }

    fn evaluator(&self, segments: usize) -> Evaluator<'_, B> {
        Evaluator::new(&self.batch, self.inertia, &self.settings, segments.max(8))
    }

    fn stencil(&self) -> Option<ReluStencil<'_>> {
        let network = self.relu.as_ref()?;
        Some(ReluStencil::new(network, self.inertia, &self.settings))
    }

    /// For so many samples.
    fn follower(&self, samples: usize) -> Follower<'_, B> {
        let [some, for_each] = MOST_FOLLOWED;
        let left = some + for_each * samples;
        Follower { evaluator: self.evaluator(1), stencil: self.stencil(), left }
    }

    /// Solves all samples of the segments, see [`continuation`].
    fn sweep(
        &self,
        targets: &[Target],
        segments: Vec<Segment>,
        solved: impl FnMut(usize, [f64; 2], Local),
        otherwise: impl FnMut(usize, [f64; 2]) -> [f64; 2],
    ) {
        match &mut self.stencil() {
            Some(stencil) => track(stencil, targets, &self.settings, segments, solved, otherwise),
            None => {
                let mut evaluator = self.evaluator(segments.len());
                continuation(&mut evaluator, targets, &self.settings, segments, solved, otherwise);
            }
        }
    }

    /// Masses from which each segment starts: the solutions of their first samples, each carried on to the
    /// next segment, so that all segments lie on the same branch.
    fn starts(&self, targets: &[Target]) -> Result<Vec<[f64; 2]>, ControlError> {
        let firsts: Vec<Target> = targets.iter().copied().step_by(SEGMENT_SAMPLES).collect();
        let bounds = self.settings.bounds;
        let middle = [0.5 * (bounds.least_g + bounds.most_g); 2];
        let mut starts = vec![middle; firsts.len()];
        let mut follower = self.follower(firsts.len());
        let segment = vec![Segment::new(0, firsts.len(), middle)];
        let mut fallback = Vec::new();
        self.sweep(
            &firsts,
            segment,
            |k, u, _| starts[k] = u,
            |k, hint| {
                let (u, _) = self.settle(&firsts[k], hint, &mut follower);
                fallback.push((k, u));
                u
            },
        );
        for (k, u) in fallback {
            starts[k] = u;
        }
        follower.check()?;
        Ok(starts)
    }

    fn solve_group(
        &self,
        targets: &[Target],
        starts: &[[f64; 2]],
    ) -> Result<Vec<Solution>, ControlError> {
        let segments = starts.iter().enumerate().map(|(k, &start)| {
            let from = k * SEGMENT_SAMPLES;
            Segment::new(from, (from + SEGMENT_SAMPLES).min(targets.len()), start)
        });
        let segments: Vec<Segment> = segments.collect();
        let mut follower = self.follower(targets.len());
        let solutions = std::cell::RefCell::new(vec![None; targets.len()]);
        let mut since_traced = vec![0; targets.len()];
        self.sweep(
            targets,
            segments,
            |k, u, local| solutions.borrow_mut()[k] = Some(reached(u, local)),
            |k, hint| {
                let before = k.checked_sub(1).filter(|_| k % SEGMENT_SAMPLES != 0);
                let before = before.and_then(|b| solutions.borrow()[b].map(|s| (targets[b], s)));
                let carried = before.filter(|_| since_traced[k - 1] < MOST_CARRIED).and_then(
                    |(target, solution)| {
                        // A target that is held is followed along its curve once.
                        if (Target { time_s: targets[k].time_s, ..target }) == targets[k] {
                            return Some(solution);
                        }
                        self.carry(&targets[k], &solution, &mut follower)
                    },
                );
                let solution = match carried {
                    Some(solution) => {
                        let held = before.is_some_and(|(_, s)| s == solution);
                        since_traced[k] = since_traced[k - 1] + usize::from(!held);
                        solution
                    }
                    None => self.settle(&targets[k], hint, &mut follower).1,
                };
                solutions.borrow_mut()[k] = Some(solution);
                [solution.masses.flexor_g, solution.masses.extensor_g]
            },
        );
        let mut solutions = solutions.into_inner();
        self.verify_carried(targets, &since_traced, &mut solutions, &mut follower);
        follower.check()?;
        Ok(solutions.into_iter().flatten().collect())
    }

    /// Follows the whole curve at the end of every stretch of carried samples; where it leads elsewhere,
    /// the whole stretch is solved anew.
    fn verify_carried(
        &self,
        targets: &[Target],
        since_traced: &[usize],
        solutions: &mut [Option<Solution>],
        follower: &mut Follower<'_, B>,
    ) {
        let hint =
            |s: &Option<Solution>| s.map_or([0.0; 2], |s| [s.masses.flexor_g, s.masses.extensor_g]);
        for end in 0..targets.len() {
            let goes_on = since_traced.get(end + 1).is_some_and(|n| *n > 0);
            if since_traced[end] == 0 || goes_on {
                continue;
            }
            let (_, found) = self.settle(&targets[end], hint(&solutions[end]), follower);
            let same = solutions[end]
                .is_some_and(|s| (s.stiffness_n_mm - found.stiffness_n_mm).abs() <= 1e-6);
            solutions[end] = Some(found);
            if same {
                continue;
            }
            for k in (0..end).rev().take_while(|&k| since_traced[k] > 0) {
                solutions[k] = Some(self.settle(&targets[k], hint(&solutions[k]), follower).1);
            }
        }
    }

    /// The whole curve of a target.
    fn trace(&self, target: &Target, follower: &mut Follower<'_, B>) -> Traced {
        if follower.is_exhausted() {
            return Traced::default();
        }
        let Follower { evaluator, stencil, left } = follower;
        *left = left.saturating_sub(GRID_EVALUATIONS);
        let mut signs = Vec::new();
        evaluator.balances(target, &grid_nodes(&self.settings.bounds), &mut signs);
        match stencil {
            Some(landscape) => {
                let price = 1;
                landscape.aim(target);
                trace(&mut Counted { landscape, left, price }, target, &signs, &self.settings)
            }
            None => {
                let local = |u| evaluator.at(target, u);
                let price = SMOOTH_EVALUATION;
                let landscape = &mut Chords::new(&self.settings.bounds, local);
                trace(&mut Counted { landscape, left, price }, target, &signs, &self.settings)
            }
        }
    }

    /// Solves one target by following its curve; of several solutions the one nearest to `hint`.
    fn settle(
        &self,
        target: &Target,
        hint: [f64; 2],
        follower: &mut Follower<'_, B>,
    ) -> ([f64; 2], Solution) {
        if follower.is_exhausted() {
            // The whole stretch fails.
            return (hint, reached(hint, Local::UNKNOWN));
        }
        let traced = self.trace(target, follower);
        let away = |v: &&Vertex| (v.u[0] - hint[0]).hypot(v.u[1] - hint[1]);
        let nearest_solution =
            traced.solutions.iter().min_by(|a, b| away(a).total_cmp(&away(b))).copied();
        if let Some(v) = nearest_solution {
            return (v.u, reached(v.u, v.local));
        }
        let (vertex, outcome) = match traced.nearest {
            Some(v) => {
                let miss = (v.local.k - target.stiffness_n_mm).abs();
                let close = miss <= self.settings.stiffness_tolerance_n_mm;
                (v, if close { Outcome::Reached } else { Outcome::NearestStiffness })
            }
            None => {
                (self.least_missing(target, &mut follower.evaluator), Outcome::MotionUnreachable)
            }
        };
        let solution = Solution {
            masses: masses(vertex.u),
            stiffness_n_mm: vertex.local.k,
            residual_mn: vertex.local.g,
            outcome,
            reachable_n_mm: traced.range_n_mm,
        };
        (vertex.u, solution)
    }

    /// Carries the nearest stiffness of the sample before to a target: the curve is followed a little way
    /// on both sides. None if K̂ still comes nearer at an end of that way, or K_d is crossed.
    fn carry(
        &self,
        target: &Target,
        before: &Solution,
        follower: &mut Follower<'_, B>,
    ) -> Option<Solution> {
        if before.outcome != Outcome::NearestStiffness {
            return None;
        }
        let from = [before.masses.flexor_g, before.masses.extensor_g];
        let Follower { evaluator, stencil, left } = follower;
        let found = match stencil {
            Some(landscape) => {
                let price = 1;
                landscape.aim(target);
                nearest_around(
                    &mut Counted { landscape, left, price },
                    target,
                    from,
                    &self.settings,
                )
            }
            None => {
                let local = |u| evaluator.at(target, u);
                let price = SMOOTH_EVALUATION;
                let landscape = &mut Chords::new(&self.settings.bounds, local);
                nearest_around(
                    &mut Counted { landscape, left, price },
                    target,
                    from,
                    &self.settings,
                )
            }
        }?;
        let [low, high] = before.reachable_n_mm?;
        let k = found.local.k;
        let range = if k < target.stiffness_n_mm { [low, k] } else { [k, high] };
        Some(Solution {
            masses: masses(found.u),
            stiffness_n_mm: k,
            residual_mn: found.local.g,
            outcome: Outcome::NearestStiffness,
            reachable_n_mm: Some(range),
        })
    }

    /// The masses of the grid that miss a motion's acceleration by least.
    fn least_missing(&self, target: &Target, evaluator: &mut Evaluator<'_, B>) -> Vertex {
        let nodes = grid_nodes(&self.settings.bounds);
        let mut balances = Vec::new();
        evaluator.balances(target, &nodes, &mut balances);
        let best =
            (0..nodes.len()).min_by(|&a, &b| balances[a].abs().total_cmp(&balances[b].abs()));
        let u = nodes[best.unwrap_or(0)];
        Vertex { u, local: evaluator.at(target, u) }
    }
}

fn masses([flexor_g, extensor_g]: [f64; 2]) -> SealedMasses {
    SealedMasses { flexor_g, extensor_g }
}

fn reached(u: [f64; 2], local: Local) -> Solution {
    Solution {
        masses: masses(u),
        stiffness_n_mm: local.k,
        residual_mn: local.g,
        outcome: Outcome::Reached,
        reachable_n_mm: None,
    }
}
