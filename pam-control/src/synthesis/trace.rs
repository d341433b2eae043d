//! The curve `g(m_f, m_e) = 0` within the bounds, followed from end to end.
//!
//! Samples that the sample-by-sample solver cannot settle are settled here, over the whole box of masses:
//!
//! 1. the signs of `g` on a grid find every branch of the curve that is larger than a cell;
//! 2. each branch is followed both ways. For a ReLU network this is exact: the curve is a chain
//!    of straight pieces between kinks, and K̂ is affine along each. For other forces it is a chain of short
//!    chords, each corrected back onto the curve;
//! 3. every crossing of K_d on a piece is a solution; without one, the vertex nearest to K_d is the nearest
//!    reachable stiffness, and the extremes of K̂ are the reachable range.

use super::landscape::Landscape;
use super::problem::{MassBounds, SynthesisSettings, Target};
use super::walk::{Limits, Vertex, Walker};

/// Cells of the grid of signs along each mass.
const CELLS: usize = 16;

/// Result of following the whole curve.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Traced {
    /// Solutions: points of the curve where K̂ = K_d.
    pub(super) solutions: Vec<Vertex>,
    /// The point of the curve whose K̂ is nearest to K_d; none if there is no curve.
    pub(super) nearest: Option<Vertex>,
    /// Least and largest K̂ on the curve, N/mm.
    pub(super) range_n_mm: Option<[f64; 2]>,
    /// Its points, branch by branch.
    pub(super) branches: Vec<Vec<Vertex>>,
}

/// The nodes of the grid of signs, row by row (m_e runs fastest).
pub(super) fn grid_nodes(bounds: &MassBounds) -> Vec<[f64; 2]> {
    let place = |k: usize| bounds.least_g + bounds.width_g() * k as f64 / CELLS as f64;
    (0..=CELLS).flat_map(|i| (0..=CELLS).map(move |j| [place(i), place(j)])).collect()
}

/// Follows the whole curve; `signs` is `g` at the [`grid_nodes`].
pub(super) fn trace(
    landscape: &mut impl Landscape,
    target: &Target,
    signs: &[f64],
    settings: &SynthesisSettings,
) -> Traced {
    let nodes = grid_nodes(&settings.bounds);
    let mut walker = Walker { landscape, target, settings };
    let mut traced = Traced::default();
    let mut vertices = 0;
    let mut crossed: Vec<[usize; 2]> = Vec::new();
    let side = CELLS + 1;
    let edges = (0..side * side).flat_map(|a| {
        let right = (a % side + 1 < side).then_some([a, a + 1]);
        let up = (a + side < side * side).then_some([a, a + side]);
        right.into_iter().chain(up)
    });
    for [a, b] in edges {
        if (signs[a] > 0.0) == (signs[b] > 0.0) || crossed.contains(&[a, b]) {
            continue;
        }
        if vertices > MOST_VERTICES {
            break;
        }
        let Some(start) = walker.root_between(nodes[a], nodes[b]) else { continue };
        let branch = walker.follow(start);
        vertices += branch.len();
        for pair in branch.windows(2) {
            crossings(&settings.bounds, pair[0].u, pair[1].u, &mut crossed);
        }
        crossed.push([a, b]);
        walker.collect(&branch, &mut traced);
        traced.branches.push(branch);
    }
    traced
}

/// Vertices of all branches after which no further branch is followed.
const MOST_VERTICES: usize = 50_000;

/// Pieces that are followed on each side around a point, and how far, as a share of the bounds' width.
const AROUND: (usize, f64) = (24, 0.04);

/// The point of the curve around `from` whose K̂ is nearest to K_d; none if that is an end of the way
/// looked at, within the bounds, or if K_d is reached.
pub(super) fn nearest_around(
    landscape: &mut impl Landscape,
    target: &Target,
    from: [f64; 2],
    settings: &SynthesisSettings,
) -> Option<Vertex> {
    let mut walker = Walker { landscape, target, settings };
    let start = walker.settle(from, None);
    let (pieces, share) = AROUND;
    let limits = Limits {
        pieces,
        way_g: share * settings.bounds.width_g(),
        chord_g: share / 8.0 * settings.bounds.width_g(),
    };
    let (mut path, _) = walker.walk(start, -1.0, limits);
    path.reverse();
    let (forth, _) = walker.walk(start, 1.0, limits);
    path.extend_from_slice(forth.get(1..)?);
    let mut traced =
        Traced { solutions: Vec::new(), nearest: None, range_n_mm: None, branches: Vec::new() };
    walker.collect(&path, &mut traced);
    let nearest = traced.nearest?;
    let on_wall = |v: &Vertex| {
        let MassBounds { least_g, most_g } = settings.bounds;
        v.u.iter()
            .any(|m| [least_g, most_g].iter().any(|w| (m - w).abs() < 1e-9 * (most_g - least_g)))
    };
    let [first, .., last] = &path[..] else { return None };
    let at_an_end = [first, last].iter().any(|end| end.u == nearest.u);
    (traced.solutions.is_empty() && (!at_an_end || on_wall(&nearest))).then_some(nearest)
}

/// Edges of the grid that a straight piece crosses.
fn crossings(bounds: &MassBounds, from: [f64; 2], to: [f64; 2], crossed: &mut Vec<[usize; 2]>) {
    let side = CELLS + 1;
    let cell = |m: f64| (m - bounds.least_g) / bounds.width_g() * CELLS as f64;
    for axis in 0..2 {
        let (a, b) = (cell(from[axis]), cell(to[axis]));
        let (low, high) = if a < b { (a, b) } else { (b, a) };
        for line in
            (low - 1e-6).ceil().max(0.0) as usize..=((high + 1e-6).floor() as usize).min(CELLS)
        {
            let share = if b == a { 0.0 } else { ((line as f64 - a) / (b - a)).clamp(0.0, 1.0) };
            let other = cell(from[1 - axis] + share * (to[1 - axis] - from[1 - axis]));
            for place in [other - 1e-6, other + 1e-6] {
                let low = (place.floor().max(0.0) as usize).min(CELLS - 1);
                let edge = if axis == 0 {
                    [line * side + low, line * side + low + 1]
                } else {
                    [low * side + line, (low + 1) * side + line]
                };
                if !crossed.contains(&edge) {
                    crossed.push(edge);
                }
            }
        }
    }
}

impl<L: Landscape> Walker<'_, L> {
    /// Adds a branch's solutions, its nearest point and its range.
    fn collect(&mut self, branch: &[Vertex], traced: &mut Traced) {
        let wanted = self.target.stiffness_n_mm;
        let miss = |v: &Vertex| (v.local.k - wanted).abs();
        let tolerance = self.settings.tolerance_mn;
        let on_curve = |v: &&Vertex| v.local.g.abs() <= tolerance;
        for pair in branch.windows(2) {
            let (a, b) = (pair[0].local.k - wanted, pair[1].local.k - wanted);
            if a * b <= 0.0 && a != b {
                let share = a / (a - b);
                let guess = [0, 1].map(|i| pair[0].u[i] + share * (pair[1].u[i] - pair[0].u[i]));
                if let Some(solution) = self.polish(guess) {
                    traced.solutions.push(solution);
                }
            }
        }
        for v in branch.iter().filter(on_curve) {
            let [low, high] = traced.range_n_mm.unwrap_or([f64::INFINITY, f64::NEG_INFINITY]);
            traced.range_n_mm = Some([low.min(v.local.k), high.max(v.local.k)]);
            if traced.nearest.is_none_or(|n| miss(v) < miss(&n)) {
                traced.nearest = Some(*v);
            }
        }
        if !self.landscape.is_piecewise_affine() {
            self.refine_nearest(branch, traced);
        }
    }

    /// Between the vertices of a smooth curve K̂ may come nearer than at them: from the nearest vertex towards the
    /// side on which K̂ nears K_d, the extreme before the next vertex is found by the Illinois method on the slope
    /// of K̂ along the curve.
    fn refine_nearest(&mut self, branch: &[Vertex], traced: &mut Traced) {
        let Some(nearest) = traced.nearest else { return };
        let Some(place) = branch.iter().position(|v| v.u == nearest.u) else { return };
        let side = (self.target.stiffness_n_mm - nearest.local.k).signum();
        let neighbours = [place.checked_sub(1), Some(place + 1)];
        for next in neighbours.into_iter().flatten().filter_map(|k| branch.get(k)) {
            let way = [next.u[0] - nearest.u[0], next.u[1] - nearest.u[1]];
            let length_g = way[0].hypot(way[1]);
            // How fast K̂ nears K_d along the curve in the direction of the way.
            let approach = |v: &Vertex| {
                let [f, e] = v.local.dg;
                let slope = (v.local.dk[1] * f - v.local.dk[0] * e) / f.hypot(e);
                side * slope * (way[1] * f - way[0] * e).signum()
            };
            // A vertex on a wall may have missed the curve.
            let end = self.settle(next.u, None);
            self.offer(end, traced);
            let (mut low, mut high) = (0.0, 1.0);
            let (mut at_low, mut at_high) = (approach(&nearest), approach(&end));
            for _ in 0..40 {
                // The remaining gain is at most about the slope times the distance.
                if at_low * (high - low) * length_g < 1e-9 || !at_low.is_finite() {
                    break;
                }
                let share = if at_high < 0.0 {
                    (low * at_high - high * at_low) / (at_high - at_low)
                } else {
                    0.5 * (low + high)
                };
                let v = self.settle([0, 1].map(|i| nearest.u[i] + share * way[i]), None);
                self.offer(v, traced);
                let here = approach(&v);
                if here > 0.0 && at_high < 0.0 {
                    (low, at_low) = (share, here);
                    at_high *= 0.5;
                } else {
                    (high, at_high) = (share, here);
                    if at_high < 0.0 && here.abs() * (high - low) * length_g < 1e-9 {
                        break;
                    }
                    at_low *= if at_high < 0.0 { 0.5 } else { 1.0 };
                }
            }
        }
    }

    /// Takes a point of the curve that is nearer to K_d than all before.
    fn offer(&self, v: Vertex, traced: &mut Traced) {
        let miss = |v: &Vertex| (v.local.k - self.target.stiffness_n_mm).abs();
        let on_curve = v.local.g.abs() <= self.settings.tolerance_mn;
        if on_curve && traced.nearest.is_none_or(|n| miss(&v) < miss(&n)) {
            traced.nearest = Some(v);
            if let Some([low, high]) = &mut traced.range_n_mm {
                *low = low.min(v.local.k);
                *high = high.max(v.local.k);
            }
        }
    }
}
