//! Newton's method along trajectories, several of them side by side.
//!
//! At a reachable target both `g(u) = 0` and `K̂(u) = K_d` hold: two equations for the two masses. A
//! solution has the objective zero and is therefore a global minimum. Where the method fails, the curve is
//! followed instead (see [`trace`](super::trace)).
//!
//! A smooth force goes through [`march`]: the solutions of three samples, carried on along a parabola, start
//! the next one, and all lanes are evaluated together. A ReLU network goes through [`track`]: it is
//! piecewise affine, so from sample to sample its pieces say the next solution exactly until a kink is passed,
//! and Newton's method ends after one step once it has found the right pieces.

use super::batch::ForceBatch;
use super::problem::{MassBounds, SynthesisSettings, Target};
use super::relu_stencil::ReluStencil;
use super::stencil::{Evaluator, Local};
use super::walk::Landscape;

/// Newton steps for one sample before the curve is followed.
const MOST_STEPS: usize = 14;
/// Longest step in one mass, as a share of the width of the bounds.
const LONGEST: f64 = 0.3;
/// Steps out of the bounds before Newton's method gives up.
const MOST_OUTSIDE: usize = 3;

/// Solution of two equations with two unknowns; none if they are dependent.
pub(super) fn solve2(rows: [[f64; 2]; 2], right: [f64; 2]) -> Option<[f64; 2]> {
    let [[a, b], [c, d]] = rows;
    let determinant = a * d - b * c;
    let size = (a.abs() + b.abs()) * (c.abs() + d.abs());
    if determinant.abs() <= 1e-12 * size || !determinant.is_finite() {
        return None;
    }
    Some([(right[0] * d - b * right[1]) / determinant, (a * right[1] - c * right[0]) / determinant])
}

/// True if a point solves both equations within the bounds.
pub(super) fn solves(
    local: &Local,
    target: &Target,
    u: [f64; 2],
    settings: &SynthesisSettings,
) -> bool {
    let MassBounds { least_g, most_g } = settings.bounds;
    local.g.abs() <= 0.1 * settings.tolerance_mn
        && (local.k - target.stiffness_n_mm).abs() <= settings.stiffness_tolerance_n_mm
        && u.iter().all(|m| (least_g..=most_g).contains(m))
}

/// Newton's step for both equations, limited; none if it has no direction.
pub(super) fn step(local: &Local, target: &Target, longest_g: f64) -> Option<[f64; 2]> {
    let short = target.stiffness_n_mm - local.k;
    let step = solve2([local.dg, local.dk], [-local.g, short])?;
    let size = step[0].abs().max(step[1].abs());
    if !size.is_finite() {
        return None;
    }
    let scale = if size > longest_g { longest_g / size } else { 1.0 };
    Some(step.map(|s| scale * s))
}

/// One lane: a stretch of a trajectory, solved sample by sample.
#[derive(Debug, Clone)]
pub(super) struct Lane {
    next: usize,
    end: usize,
    u: [f64; 2],
    /// The last two solutions, the latest first.
    last: [Option<[f64; 2]>; 2],
    steps: usize,
    outside: usize,
}

impl Lane {
    /// A lane over the samples `start..end` that begins from a guess.
    pub(super) fn new(start: usize, end: usize, guess: [f64; 2]) -> Self {
        Self { next: start, end, u: guess, last: [None; 2], steps: 0, outside: 0 }
    }

    /// Goes on to the next sample from a solution of this one.
    fn advance(&mut self, solution: [f64; 2], bounds: &MassBounds) {
        let ahead = match self.last {
            [Some(a), Some(b)] => [0, 1].map(|i| 3.0 * (solution[i] - a[i]) + b[i]),
            [Some(a), None] => [0, 1].map(|i| 2.0 * solution[i] - a[i]),
            _ => solution,
        };
        self.arrive(solution);
        self.u = bounds.clamp(ahead);
    }

    /// Goes on to the next sample and stays at the solution of this one.
    fn arrive(&mut self, solution: [f64; 2]) {
        self.last = [Some(solution), self.last[0]];
        self.u = solution;
        self.next += 1;
        (self.steps, self.outside) = (0, 0);
    }

    /// One step of Newton's method; false when it has failed.
    fn improve(&mut self, local: &Local, target: &Target, bounds: &MassBounds) -> bool {
        self.steps += 1;
        if self.steps > MOST_STEPS {
            return false;
        }
        let Some(step) = step(local, target, LONGEST * bounds.width_g()) else { return false };
        let wanted = [self.u[0] + step[0], self.u[1] + step[1]];
        let inside = bounds.clamp(wanted);
        if inside != wanted {
            self.outside += 1;
        }
        let stuck = inside == self.u;
        self.u = inside;
        self.outside <= MOST_OUTSIDE && !stuck
    }
}

/// Solves all samples of the lanes. `solved` gets each sample's masses and what is known there; where
/// Newton's method fails, `otherwise` is asked with the lane's last solution and must give a solution.
pub(super) fn march<B: ForceBatch>(
    evaluator: &mut Evaluator<'_, B>,
    targets: &[Target],
    settings: &SynthesisSettings,
    mut lanes: Vec<Lane>,
    mut solved: impl FnMut(usize, [f64; 2], Local),
    mut otherwise: impl FnMut(usize, [f64; 2]) -> [f64; 2],
) {
    let mut locals = Vec::with_capacity(lanes.len());
    lanes.retain(|lane| lane.next < lane.end);
    while !lanes.is_empty() {
        evaluator.evaluate(lanes.iter().map(|lane| (&targets[lane.next], lane.u)), &mut locals);
        for (lane, local) in lanes.iter_mut().zip(&locals) {
            let target = &targets[lane.next];
            if solves(local, target, lane.u, settings) {
                solved(lane.next, lane.u, *local);
                lane.advance(lane.u, &settings.bounds);
            } else if !lane.improve(local, target, &settings.bounds) {
                let hint = lane.last[0].unwrap_or(lane.u);
                let u = otherwise(lane.next, hint);
                lane.advance(u, &settings.bounds);
            }
        }
        lanes.retain(|lane| lane.next < lane.end);
    }
}

/// As [`march`], for a ReLU network: one lane after the other.
pub(super) fn track(
    stencil: &mut ReluStencil<'_>,
    targets: &[Target],
    settings: &SynthesisSettings,
    lanes: Vec<Lane>,
    mut solved: impl FnMut(usize, [f64; 2], Local),
    mut otherwise: impl FnMut(usize, [f64; 2]) -> [f64; 2],
) {
    let bounds = &settings.bounds;
    for mut lane in lanes {
        stencil.refresh();
        let mut in_pieces = false;
        while lane.next < lane.end {
            let target = &targets[lane.next];
            stencil.aim(target);
            let ahead = stencil.extended(lane.u);
            if let (true, Some([f, e])) =
                (in_pieces, step(&ahead, target, LONGEST * bounds.width_g()))
            {
                lane.u = bounds.clamp([lane.u[0] + f, lane.u[1] + e]);
            }
            in_pieces = loop {
                let local = stencil.at(lane.u);
                if solves(&local, target, lane.u, settings) {
                    solved(lane.next, lane.u, local);
                    lane.arrive(lane.u);
                    break true;
                }
                if !lane.improve(&local, target, bounds) {
                    let hint = lane.last[0].unwrap_or(lane.u);
                    let u = otherwise(lane.next, hint);
                    lane.arrive(u);
                    break false;
                }
            };
        }
    }
}
