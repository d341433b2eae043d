//! Along the curve `g = 0`, piece by piece.
//!
//! A [`Walker`] goes from a point of the curve to the next kink of the [`Landscape`], or by a chord where there
//! are no kinks, and settles back onto the curve.

use super::landscape::Landscape;
use super::newton::{solves, step};
use super::problem::{MassBounds, SynthesisSettings, Target};
use super::stencil::Local;

/// Pieces after which a branch is given up.
const MOST_PIECES: usize = 20_000;
/// How far past a kink the next piece begins, as a share of the bounds' width.
const PAST: f64 = 1e-11;
/// Length of a chord of a smooth curve, as a share of the bounds' width.
const CHORD: f64 = 1.0 / 32.0;

/// A point of the curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Vertex {
    pub(super) u: [f64; 2],
    pub(super) local: Local,
}

/// How far a branch is followed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    pub(super) pieces: usize,
    pub(super) way_g: f64,
    /// Longest piece.
    pub(super) chord_g: f64,
}

/// To its end.
const WHOLE: Limits = Limits { pieces: MOST_PIECES, way_g: f64::INFINITY, chord_g: f64::INFINITY };

/// State of the walk along the curve of a target.
pub(super) struct Walker<'a, L> {
    pub(super) landscape: &'a mut L,
    pub(super) target: &'a Target,
    pub(super) settings: &'a SynthesisSettings,
}

fn along(u: [f64; 2], direction: [f64; 2], distance: f64) -> [f64; 2] {
    [u[0] + distance * direction[0], u[1] + distance * direction[1]]
}

impl<L: Landscape> Walker<'_, L> {
    fn vertex(&mut self, u: [f64; 2]) -> Vertex {
        Vertex { u, local: self.landscape.at(u) }
    }

    /// A root of `g` between two points at which its signs differ, by the Illinois method.
    pub(super) fn root_between(&mut self, from: [f64; 2], to: [f64; 2]) -> Option<Vertex> {
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
    pub(super) fn follow(&mut self, start: Vertex) -> Vec<Vertex> {
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
    pub(super) fn walk(&mut self, start: Vertex, side: f64, limits: Limits) -> (Vec<Vertex>, bool) {
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
    pub(super) fn settle(&mut self, u: [f64; 2], wall: Option<usize>) -> Vertex {
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

    /// Newton's method on both equations from a good guess.
    pub(super) fn polish(&mut self, guess: [f64; 2]) -> Option<Vertex> {
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
