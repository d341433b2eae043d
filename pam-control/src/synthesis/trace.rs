//! The curve `g(m_f, m_e) = 0` within the bounds, followed from end to end.
//!
//! What the sample-by-sample solver cannot settle is settled here, for the whole box of masses:
//!
//! 1. the signs of `g` on a grid find every branch of the curve that is larger than a cell;
//! 2. each branch is followed both ways. For a network of rectifiers this is exact: the curve is a chain
//!    of straight pieces between kinks, and K̂ is affine along each. For other forces it is a chain of short
//!    chords, each corrected back onto the curve;
//! 3. every crossing of K_d on a piece is a solution; without one, the vertex nearest to K_d is the nearest
//!    reachable stiffness, and the extremes of K̂ are the reachable range.

use super::newton::{solves, step};
use super::problem::{MassBounds, SynthesisSettings, Target};
use super::stencil::Local;

/// Cells of the grid of signs along each mass.
const CELLS: usize = 16;
/// Pieces after which a branch is given up.
const MOST_PIECES: usize = 20_000;
/// How far past a kink the next piece begins, as a share of the bounds' width.
const PAST: f64 = 1e-11;
/// Length of a chord of a smooth curve, as a share of the bounds' width.
const CHORD: f64 = 1.0 / 32.0;

/// `g` and K̂ of one target over the masses.
pub(super) trait Landscape {
    /// What is known at a pair of masses.
    fn at(&mut self, u: [f64; 2]) -> Local;

    /// How far from the last pair asked for both stay affine along a direction of length one, g.
    fn reach(&mut self, direction: [f64; 2]) -> f64;

    /// Whether both are piecewise affine, so that the reach is exact.
    fn is_piecewise_affine(&self) -> bool;
}

/// A point of the curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Vertex {
    pub(super) u: [f64; 2],
    pub(super) local: Local,
}

/// What following the whole curve gave.
#[derive(Debug, Clone, PartialEq)]
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
    let mut traced =
        Traced { solutions: Vec::new(), nearest: None, range_n_mm: None, branches: Vec::new() };
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
        let Some(start) = walker.root_between(nodes[a], nodes[b]) else { continue };
        let branch = walker.follow(start);
        for pair in branch.windows(2) {
            crossings(&settings.bounds, pair[0].u, pair[1].u, &mut crossed);
        }
        crossed.push([a, b]);
        walker.collect(&branch, &mut traced);
        traced.branches.push(branch);
    }
    traced
}

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

/// How far a branch is followed.
#[derive(Debug, Clone, Copy)]
struct Limits {
    pieces: usize,
    way_g: f64,
    /// Longest piece.
    chord_g: f64,
}

/// To its end.
const WHOLE: Limits = Limits { pieces: MOST_PIECES, way_g: f64::INFINITY, chord_g: f64::INFINITY };

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

struct Walker<'a, L> {
    landscape: &'a mut L,
    target: &'a Target,
    settings: &'a SynthesisSettings,
}

fn along(u: [f64; 2], direction: [f64; 2], distance: f64) -> [f64; 2] {
    [u[0] + distance * direction[0], u[1] + distance * direction[1]]
}

impl<L: Landscape> Walker<'_, L> {
    fn vertex(&mut self, u: [f64; 2]) -> Vertex {
        Vertex { u, local: self.landscape.at(u) }
    }

    /// A root of `g` between two points at which its signs differ, by the Illinois method.
    fn root_between(&mut self, from: [f64; 2], to: [f64; 2]) -> Option<Vertex> {
        let at = |s: f64| [0, 1].map(|i| from[i] + s * (to[i] - from[i]));
        let (mut low, mut high) = (0.0, 1.0);
        let (mut g_low, mut g_high) = (self.landscape.at(from).g, self.landscape.at(to).g);
        for _ in 0..80 {
            let middle = if (g_high - g_low).abs() > 0.0 {
                (low * g_high - high * g_low) / (g_high - g_low)
            } else {
                0.5 * (low + high)
            };
            let found = self.vertex(at(middle));
            if found.local.g.abs() <= 0.01 * self.settings.tolerance_mn {
                return Some(found);
            }
            if (found.local.g > 0.0) == (g_high > 0.0) {
                (high, g_high) = (middle, found.local.g);
                g_low *= 0.5;
            } else {
                (low, g_low) = (middle, found.local.g);
                g_high *= 0.5;
            }
        }
        None
    }

    /// The branch through a point, from one end to the other.
    fn follow(&mut self, start: Vertex) -> Vec<Vertex> {
        let (mut back, closed) = self.walk(start, -1.0, WHOLE);
        if closed {
            return back;
        }
        let (forth, _) = self.walk(start, 1.0, WHOLE);
        back.reverse();
        back.extend_from_slice(&forth[1..]);
        back
    }

    /// Goes along the curve from a point until it leaves the bounds or comes back (true), or meets a limit.
    fn walk(&mut self, start: Vertex, side: f64, limits: Limits) -> (Vec<Vertex>, bool) {
        let bounds = self.settings.bounds;
        let mut here = self.vertex(start.u);
        let mut path = vec![here];
        let mut way_g = 0.0;
        while path.len() <= limits.pieces && way_g < limits.way_g {
            let [a, b] = here.local.dg;
            let norm = a.hypot(b);
            if !(norm.is_finite() && norm > 0.0) {
                break;
            }
            let direction = [-side * b / norm, side * a / norm];
            let past = PAST * bounds.width_g();
            let reach = (self.landscape.reach(direction) + past).min(limits.chord_g);
            let (room, wall) = room(&bounds, here.u, direction);
            if room <= 0.0 {
                break;
            }
            let last = room <= reach;
            let there =
                self.settle(along(here.u, direction, reach.min(room)), last.then_some(wall));
            let from_start = distance_to_piece(start.u, here.u, there.u);
            let closed = path.len() > 3 && from_start <= 10.0 * past;
            way_g += reach;
            path.push(there);
            if last || closed {
                return (path, closed);
            }
            here = there;
        }
        (path, false)
    }

    /// The point of the curve near `u`; on a wall of the bounds if one is given (the index of the mass
    /// that stays as it is).
    fn settle(&mut self, u: [f64; 2], wall: Option<usize>) -> Vertex {
        let bounds = self.settings.bounds;
        let mut here = self.vertex(bounds.clamp(u));
        for _ in 0..8 {
            if here.local.g.abs() <= 0.02 * self.settings.tolerance_mn {
                break;
            }
            let mut slope = here.local.dg;
            if let Some(fixed) = wall {
                slope[fixed] = 0.0;
            }
            let squared = slope[0] * slope[0] + slope[1] * slope[1];
            if squared == 0.0 {
                break;
            }
            let moved = along(here.u, slope, -here.local.g / squared);
            here = self.vertex(bounds.clamp(moved));
        }
        here
    }

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

    /// Newton's method on both equations from a good guess.
    fn polish(&mut self, guess: [f64; 2]) -> Option<Vertex> {
        let bounds = self.settings.bounds;
        let mut here = self.vertex(bounds.clamp(guess));
        for _ in 0..12 {
            if solves(&here.local, self.target, here.u, self.settings) {
                return Some(here);
            }
            let step = step(&here.local, self.target, CHORD * bounds.width_g())?;
            here = self.vertex(bounds.clamp(along(here.u, step, 1.0)));
        }
        solves(&here.local, self.target, here.u, self.settings).then_some(here)
    }

    /// Between the chords of a smooth curve K̂ may come nearer than at their ends: a golden-section search
    /// between the neighbours of the nearest vertex.
    fn refine_nearest(&mut self, branch: &[Vertex], traced: &mut Traced) {
        let Some(nearest) = traced.nearest else { return };
        let Some(place) = branch.iter().position(|v| v.u == nearest.u) else { return };
        if place == 0 || place + 1 == branch.len() {
            return;
        }
        let (a, b) = (branch[place - 1].u, branch[place + 1].u);
        let wanted = self.target.stiffness_n_mm;
        let golden = 0.5 * (5_f64.sqrt() - 1.0);
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..40 {
            let [s, t] = [high - golden * (high - low), low + golden * (high - low)];
            let [v, w] =
                [s, t].map(|s| self.settle([0, 1].map(|i| a[i] + s * (b[i] - a[i])), None));
            let [miss_v, miss_w] = [v, w].map(|v| (v.local.k - wanted).abs());
            let (better, miss) = if miss_v < miss_w { (v, miss_v) } else { (w, miss_w) };
            if miss_v < miss_w {
                high = t;
            } else {
                low = s;
            }
            if traced.nearest.is_none_or(|n| miss < (n.local.k - wanted).abs()) {
                traced.nearest = Some(better);
                if let Some([low, high]) = &mut traced.range_n_mm {
                    *low = low.min(better.local.k);
                    *high = high.max(better.local.k);
                }
            }
        }
    }
}

/// How far it is to the bounds along a direction, and which mass meets its bound.
fn room(bounds: &MassBounds, u: [f64; 2], direction: [f64; 2]) -> (f64, usize) {
    let to = |i: usize| {
        let wall = if direction[i] > 0.0 { bounds.most_g } else { bounds.least_g };
        if direction[i] == 0.0 { f64::INFINITY } else { (wall - u[i]) / direction[i] }
    };
    let [f, e] = [to(0), to(1)];
    if f < e { (f, 0) } else { (e, 1) }
}

/// Distance of a point to the piece between two others.
fn distance_to_piece(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let way = [b[0] - a[0], b[1] - a[1]];
    let squared = way[0] * way[0] + way[1] * way[1];
    let share = if squared > 0.0 {
        (((p[0] - a[0]) * way[0] + (p[1] - a[1]) * way[1]) / squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (p[0] - a[0] - share * way[0]).hypot(p[1] - a[1] - share * way[1])
}

/// Any force, in chords.
pub(super) struct Chords<F> {
    pub(super) local: F,
    pub(super) length_g: f64,
}

impl<F> Chords<F> {
    pub(super) fn new(bounds: &MassBounds, local: F) -> Self {
        Self { local, length_g: CHORD * bounds.width_g() }
    }
}

impl<F: FnMut([f64; 2]) -> Local> Landscape for Chords<F> {
    fn at(&mut self, u: [f64; 2]) -> Local {
        (self.local)(u)
    }

    fn reach(&mut self, _direction: [f64; 2]) -> f64 {
        self.length_g
    }

    fn is_piecewise_affine(&self) -> bool {
        false
    }
}
