//! Newton's method along trajectories, several of them side by side.
//!
//! At a reachable target both `g(u) = 0` and `K̂(u) = K_d` hold: two equations for the two masses. A
//! solution has the objective zero and is therefore a global minimum. Where the method fails, the curve is
//! followed instead (see [`trace`](super::trace)).
//!
//! A smooth force goes through [`continuation`]: the solutions of three samples, carried on along a parabola, start
//! the next one, and all segments are evaluated together. A ReLU network goes through [`track`]: it is
//! piecewise affine, so from sample to sample its pieces say the next solution exactly until a kink is passed,
//! and Newton's method ends after one step once it has found the right pieces.

use super::batch::ForceBatch;
use super::landscape::Landscape;
use super::problem::{MassBounds, SynthesisSettings, Target};
use super::relu_stencil::ReluStencil;
use super::stencil::{Evaluator, Local};

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

/// A segment of a trajectory, solved sample by sample.
#[derive(Debug, Clone)]
pub(super) struct Segment {
    next: usize,
    end: usize,
    u: [f64; 2],
    /// The last two solutions, the latest first.
    last: [Option<[f64; 2]>; 2],
    steps: usize,
    outside: usize,
}

impl Segment {
    /// A segment over the samples `start..end` that begins from a guess.
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

/// Solves all samples of the segments. `solved` gets each sample's masses and what is known there; where
/// Newton's method fails, `otherwise` is asked with the segment's last solution and must give a solution.
pub(super) fn continuation<B: ForceBatch>(
    evaluator: &mut Evaluator<'_, B>,
    targets: &[Target],
    settings: &SynthesisSettings,
    mut segments: Vec<Segment>,
    mut solved: impl FnMut(usize, [f64; 2], Local),
    mut otherwise: impl FnMut(usize, [f64; 2]) -> [f64; 2],
) {
    let mut locals = Vec::with_capacity(segments.len());
    segments.retain(|segment| segment.next < segment.end);
    while !segments.is_empty() {
        evaluator.evaluate(
            segments.iter().map(|segment| (&targets[segment.next], segment.u)),
            &mut locals,
        );
        for (segment, local) in segments.iter_mut().zip(&locals) {
            let target = &targets[segment.next];
            if solves(local, target, segment.u, settings) {
                solved(segment.next, segment.u, *local);
                segment.advance(segment.u, &settings.bounds);
            } else if !segment.improve(local, target, &settings.bounds) {
                let hint = segment.last[0].unwrap_or(segment.u);
                let u = otherwise(segment.next, hint);
                segment.advance(u, &settings.bounds);
            }
        }
        segments.retain(|segment| segment.next < segment.end);
    }
}

/// As [`continuation`], for a ReLU network: one segment after the other.
pub(super) fn track(
    stencil: &mut ReluStencil<'_>,
    targets: &[Target],
    settings: &SynthesisSettings,
    segments: Vec<Segment>,
    mut solved: impl FnMut(usize, [f64; 2], Local),
    mut otherwise: impl FnMut(usize, [f64; 2]) -> [f64; 2],
) {
    let bounds = &settings.bounds;
    for mut segment in segments {
        stencil.refresh();
        let mut in_pieces = false;
        while segment.next < segment.end {
            let target = &targets[segment.next];
            stencil.aim(target);
            let ahead = stencil.extended(segment.u);
            if let (true, Some([f, e])) =
                (in_pieces, step(&ahead, target, LONGEST * bounds.width_g()))
            {
                segment.u = bounds.clamp([segment.u[0] + f, segment.u[1] + e]);
            }
            in_pieces = loop {
                let local = stencil.at(segment.u);
                if solves(&local, target, segment.u, settings) {
                    solved(segment.next, segment.u, local);
                    segment.arrive(segment.u);
                    break true;
                }
                if !segment.improve(&local, target, bounds) {
                    let hint = segment.last[0].unwrap_or(segment.u);
                    let u = otherwise(segment.next, hint);
                    segment.arrive(u);
                    break false;
                }
            };
        }
    }
}
