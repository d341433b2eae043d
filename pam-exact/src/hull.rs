//! The sides of a cell as the corners of a hull.
//!
//! Seen from a point inside the cell, the half-plane `g + n·d ≥ 0` (`d` from the point on, `g > 0` its
//! margin there) is the dual point `q = −n/g`, and the sides are the corners of the convex hull of all
//! dual points. The hull is grown from its extremes along the axes (quickhull), so a cell costs a few
//! sweeps over the units. The point is taken half way across the cell from where it is entered.

use crate::atlas::NONE;
use crate::cell::Window;
use crate::clip::SIDE_TOLERANCE;
use crate::network::LANES;
use crate::sides::Entry;
use pam_core::simd::arch;
use pulp::{Simd, WithSimd};

/// Finds hulls, again and again in the same memory.
#[derive(Debug, Default)]
pub(crate) struct HullFinder {
    dual: Dual,
    /// Corners of the hull: units.
    corners: Vec<u32>,
    /// Dual points outside of an edge, edge by edge.
    outside: Vec<Point>,
    edges: Vec<Edge>,
}

impl HullFinder {
    /// The units whose borders bound the cell with these pre-activations and signs; those past the last
    /// unit are the window's sides. `None` where several borders meet at the entry.
    pub(crate) fn find(
        &mut self,
        window: &Window,
        table: &[f64],
        bits: &[u64],
        entry: Entry,
    ) -> Option<&[u32]> {
        let found = arch().dispatch(Hull { finder: self, window, table, bits, entry });
        found.then_some(&self.corners[..])
    }
}

/// A dual point and its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Point {
    p: f64,
    r: f64,
    unit: u32,
}

/// An edge of the hull, and the range of the points that may be outside of it.
#[derive(Debug, Clone, Copy)]
struct Edge {
    from: Point,
    to: Point,
    first: usize,
    end: usize,
}

impl Edge {
    /// The outward normal, and how far along it a point must lie to be outside. Points within
    /// [`SIDE_TOLERANCE`] of the edge count: their borders come that near a corner of the cell.
    #[inline(always)]
    fn border(&self) -> ([f64; 2], f64) {
        let (a, b) = (self.from, self.to);
        let normal = [b.r - a.r, a.p - b.p];
        let at = a.p * normal[0] + a.r * normal[1];
        (normal, at - SIDE_TOLERANCE * at.abs())
    }
}

/// Dual points: those of the units, then of the four sides of the window.
#[derive(Debug, Default)]
struct Dual {
    p: Vec<f64>,
    r: Vec<f64>,
    /// `±1`, the signs of the units in the pattern.
    signs: Vec<f64>,
}

/// Whether the hull was found, whose corners are then in the finder's memory.
struct Hull<'a> {
    finder: &'a mut HullFinder,
    window: &'a Window,
    table: &'a [f64],
    bits: &'a [u64],
    entry: Entry,
}

impl WithSimd for Hull<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let Self { finder, window, table, bits, entry: (point, through) } = self;
        let HullFinder { dual, corners, edges, outside } = finder;
        let units = table.len() / 3;
        dual.signs.resize(units, 0.0);
        for (block, bits) in dual.signs.chunks_mut(64).zip(bits) {
            for (i, sign) in block.iter_mut().enumerate() {
                *sign = if (bits >> i) & 1 == 1 { 1.0 } else { -1.0 };
            }
        }
        let Some(middle) = dual.inner_point(simd, window, table, point, through) else {
            return false;
        };
        if !dual.place(simd, window, table, middle) {
            return false;
        }
        corners.clear();
        edges.clear();
        outside.clear();
        let extremes = dual.extremes(simd);
        for (k, &from) in extremes.iter().enumerate() {
            // One point may be the extreme of several directions next to each other.
            let to = extremes[(k + 1) % DIRECTIONS];
            if from.unit != to.unit {
                corners.push(to.unit);
                edges.push(Edge { from, to, first: 0, end: 0 });
            }
        }
        if edges.len() < 2 {
            return false;
        }
        dual.outside_of(simd, edges, corners, outside);
        grow(edges, outside, corners);
        true
    }
}

/// Grows a hull until no point is outside.
#[inline(always)]
fn grow(edges: &mut Vec<Edge>, points: &mut [Point], corners: &mut Vec<u32>) {
    while let Some(edge) = edges.pop() {
        let points = &mut points[edge.first..edge.end];
        let (normal, _) = edge.border();
        let along = |q: &Point| q.p * normal[0] + q.r * normal[1];
        let mut best = f64::NEG_INFINITY;
        let mut farthest = None;
        for (place, q) in points.iter().enumerate() {
            let value = along(q);
            if value > best {
                (best, farthest) = (value, Some(place));
            }
        }
        let Some(farthest) = farthest else { continue };
        let corner = points[farthest];
        if !corners.contains(&corner.unit) {
            corners.push(corner.unit);
        }
        points.swap(0, farthest);
        // What is outside of the one new edge to the front, what is outside of the other behind it.
        let mut end = 1;
        for new in [Edge { to: corner, ..edge }, Edge { from: corner, ..edge }] {
            let first = end;
            let (normal, least) = new.border();
            for k in first..points.len() {
                if points[k].p * normal[0] + points[k].r * normal[1] > least {
                    points.swap(k, end);
                    end += 1;
                }
            }
            edges.push(Edge { first: edge.first + first, end: edge.first + end, ..new });
        }
    }
}

impl Dual {
    /// A point well inside of the cell: half way from `point`, on the border of the unit `through`, to
    /// the next border. `None` if other borders meet at `point`.
    #[inline(always)]
    fn inner_point<S: Simd>(
        &self,
        simd: S,
        window: &Window,
        table: &[f64],
        point: [f64; 2],
        through: u32,
    ) -> Option<[f64; 2]> {
        let units = table.len() / 3;
        let own = |k: usize| self.signs[through as usize] * table[k * units + through as usize];
        let border = if through == NONE { [0.0; 3] } else { [own(0), own(1), own(2)] };
        let direction = [border[1], border[2]];
        let part = |k: usize| S::as_simd_f64s(&table[k * units..(k + 1) * units]).0;
        let (alpha, beta, gamma) = (part(0), part(1), part(2));
        let signs = S::as_simd_f64s(&self.signs).0;
        let zero = simd.splat_f64s(0.0);
        let (p, r) = (simd.splat_f64s(point[0]), simd.splat_f64s(point[1]));
        let (dp, dr) = (simd.splat_f64s(direction[0]), simd.splat_f64s(direction[1]));
        let far = simd.splat_f64s(f64::INFINITY);
        let through_place = through as usize / S::F64_LANES;
        // The least margin, and the largest speed per margin, of all borders but that of the entry.
        let mut least = far;
        let mut fastest = zero;
        for chunk in 0..alpha.len() {
            let value =
                simd.mul_add_f64s(gamma[chunk], r, simd.mul_add_f64s(beta[chunk], p, alpha[chunk]));
            let rate = simd.mul_add_f64s(gamma[chunk], dr, simd.mul_f64s(beta[chunk], dp));
            let margin = simd.mul_f64s(signs[chunk], value);
            let speed = simd.neg_f64s(simd.div_f64s(rate, value));
            let (mut margin, mut speed) = (margin, speed);
            if chunk == through_place {
                let lane = through as usize % S::F64_LANES;
                pulp::bytemuck::cast_slice_mut::<S::f64s, f64>(std::slice::from_mut(&mut margin))
                    [lane] = f64::INFINITY;
                pulp::bytemuck::cast_slice_mut::<S::f64s, f64>(std::slice::from_mut(&mut speed))
                    [lane] = 0.0;
            }
            // Padding has neither value nor slope: no border.
            let size = simd.add_f64s(simd.abs_f64s(beta[chunk]), simd.abs_f64s(gamma[chunk]));
            let size = simd.add_f64s(size, simd.abs_f64s(value));
            let real = simd.greater_than_f64s(size, zero);
            margin = simd.select_f64s(real, margin, far);
            speed = simd.select_f64s(real, speed, zero);
            least = simd.min_f64s(least, margin);
            fastest = simd.max_f64s(fastest, speed);
        }
        let least = simd.reduce_min_f64s(least);
        if least.is_nan() || least <= 0.0 {
            return None;
        }
        if through == NONE {
            let clear = (0..units).all(|u| {
                let [a, b, c] = [table[u], table[units + u], table[2 * units + u]];
                let terms = [a, b * point[0], c * point[1]];
                let size: f64 = terms.iter().map(|t| t.abs()).sum();
                size == 0.0 || terms.iter().sum::<f64>().abs() > WELL_INSIDE * size
            });
            return clear.then_some(point);
        }
        let mut time = 1.0 / simd.reduce_max_f64s(fastest);
        for (i, [low, high]) in [window.first, window.second].into_iter().enumerate() {
            let room = if direction[i] > 0.0 { high - point[i] } else { low - point[i] };
            if direction[i] != 0.0 {
                time = time.min(room / direction[i]);
            }
        }
        let step = 0.5 * time;
        let middle = [point[0] + step * direction[0], point[1] + step * direction[1]];
        // What the way gains over rounding of the point itself.
        let gain = step * (direction[0] * direction[0] + direction[1] * direction[1]);
        let size = border[0].abs() + (border[1] * point[0]).abs() + (border[2] * point[1]).abs();
        (time.is_finite() && gain > WELL_INSIDE * size).then_some(middle)
    }

    /// The dual points seen from `middle`; false if that is no point of the cell, by rounding.
    #[inline(always)]
    fn place<S: Simd>(
        &mut self,
        simd: S,
        window: &Window,
        table: &[f64],
        middle: [f64; 2],
    ) -> bool {
        let units = table.len() / 3;
        self.p.resize(units + LANES, f64::NAN);
        self.r.resize(units + LANES, f64::NAN);
        let part = |k: usize| S::as_simd_f64s(&table[k * units..(k + 1) * units]).0;
        let (alpha, beta, gamma) = (part(0), part(1), part(2));
        let signs = S::as_simd_f64s(&self.signs).0;
        let (p, p_window) = self.p.split_at_mut(units);
        let (r, r_window) = self.r.split_at_mut(units);
        let (p, r) = (S::as_mut_simd_f64s(p).0, S::as_mut_simd_f64s(r).0);
        let (x, v) = (simd.splat_f64s(middle[0]), simd.splat_f64s(middle[1]));
        let minus = simd.splat_f64s(-1.0);
        let mut least = simd.splat_f64s(0.0);
        for chunk in 0..alpha.len() {
            let (b, c) = (beta[chunk], gamma[chunk]);
            let value = simd.mul_add_f64s(c, v, simd.mul_add_f64s(b, x, alpha[chunk]));
            least = simd.min_f64s(least, simd.mul_f64s(signs[chunk], value));
            // Signs turn margin and normal alike. Padding becomes NaN, which is never an extreme.
            let scale = simd.div_f64s(minus, value);
            p[chunk] = simd.mul_f64s(b, scale);
            r[chunk] = simd.mul_f64s(c, scale);
        }
        let ([p0, p1], [r0, r1]) = (window.first, window.second);
        p_window.fill(f64::NAN);
        r_window.fill(f64::NAN);
        p_window[..4].copy_from_slice(&[1.0 / (p1 - middle[0]), 0.0, 1.0 / (p0 - middle[0]), 0.0]);
        r_window[..4].copy_from_slice(&[0.0, 1.0 / (r1 - middle[1]), 0.0, 1.0 / (r0 - middle[1])]);
        simd.reduce_min_f64s(least) >= 0.0
    }

    fn point(&self, unit: usize) -> Point {
        Point { p: self.p[unit], r: self.r[unit], unit: unit as u32 }
    }

    /// The points farthest to the right, up, to the left, down, and between these, counter-clockwise.
    #[inline(always)]
    fn extremes<S: Simd>(&self, simd: S) -> [Point; DIRECTIONS] {
        let axes = self.farthest(simd, [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]]);
        // Diagonals of the rectangle around all points, so that its proportions do not matter.
        let width = axes[0].p - axes[2].p;
        let height = axes[1].r - axes[3].r;
        let (u, w) = (height, width);
        let diagonals = self.farthest(simd, [[u, w], [-u, w], [-u, -w], [u, -w]]);
        let mut around = [axes[0]; DIRECTIONS];
        for k in 0..DIRECTIONS / 2 {
            around[2 * k] = axes[k];
            around[2 * k + 1] = diagonals[k];
        }
        around
    }

    /// The points farthest along four directions.
    #[inline(always)]
    fn farthest<S: Simd>(&self, simd: S, directions: [[f64; 2]; 4]) -> [Point; 4] {
        let (p, r) = (S::as_simd_f64s(&self.p).0, S::as_simd_f64s(&self.r).0);
        // Loops in place of closures over arrays: those are compiled without the wide instructions.
        let mut lines = [[simd.splat_f64s(0.0); 2]; 4];
        for (line, [u, w]) in lines.iter_mut().zip(directions) {
            *line = [simd.splat_f64s(u), simd.splat_f64s(w)];
        }
        let mut best = [simd.splat_f64s(f64::NEG_INFINITY); 4];
        let mut at = [simd.splat_f64s(0.0); 4];
        for (chunk, (&p, &r)) in p.iter().zip(r).enumerate() {
            let place = simd.splat_f64s(chunk as f64);
            for (k, &[u, w]) in lines.iter().enumerate() {
                let value = simd.mul_add_f64s(u, p, simd.mul_f64s(w, r));
                let farther = simd.greater_than_f64s(value, best[k]);
                best[k] = simd.select_f64s(farther, value, best[k]);
                at[k] = simd.select_f64s(farther, place, at[k]);
            }
        }
        let mut points = [Point { p: 0.0, r: 0.0, unit: NONE }; 4];
        for (k, point) in points.iter_mut().enumerate() {
            let best = pulp::bytemuck::cast_slice::<S::f64s, f64>(&best[k..=k]);
            let (mut lane, mut most) = (0, f64::NEG_INFINITY);
            for (i, &b) in best.iter().enumerate() {
                if b > most {
                    (lane, most) = (i, b);
                }
            }
            let place = pulp::bytemuck::cast_slice::<S::f64s, f64>(&at[k..=k])[lane];
            *point = self.point(place as usize * S::F64_LANES + lane);
        }
        points
    }

    /// Sorts the points outside of a first hull by its edges.
    #[inline(always)]
    fn outside_of<S: Simd>(
        &self,
        simd: S,
        edges: &mut [Edge],
        corners: &[u32],
        outside: &mut Vec<Point>,
    ) {
        let mut borders = [([0.0; 2], f64::INFINITY); DIRECTIONS];
        for (border, edge) in borders.iter_mut().zip(&*edges) {
            *border = edge.border();
        }
        let borders = &borders[..edges.len()];
        let mut lines = [[simd.splat_f64s(0.0); 3]; DIRECTIONS];
        for (line, ([n, m], least)) in lines.iter_mut().zip(borders) {
            *line = [simd.splat_f64s(*n), simd.splat_f64s(*m), simd.splat_f64s(-least)];
        }
        let lines = &lines[..edges.len()];
        let (p, r) = (S::as_simd_f64s(&self.p).0, S::as_simd_f64s(&self.r).0);
        for (chunk, (&p, &r)) in p.iter().zip(r).enumerate() {
            let mut beyond = simd.splat_f64s(-1.0);
            for &[n, m, least] in lines {
                let value = simd.mul_add_f64s(n, p, simd.mul_add_f64s(m, r, least));
                beyond = simd.max_f64s(value, beyond);
            }
            // A little more than is outside, since the sums above are rounded another way.
            if none(simd, simd.greater_than_or_equal_f64s(beyond, simd.splat_f64s(0.0))) {
                continue;
            }
            for unit in chunk * S::F64_LANES..(chunk + 1) * S::F64_LANES {
                let q = self.point(unit);
                if !corners.contains(&q.unit) {
                    outside.push(q);
                }
            }
        }
        // Each point to the first edge that it is outside of; what is inside is left behind.
        let mut end = 0;
        for (edge, ([n, m], least)) in edges.iter_mut().zip(borders) {
            edge.first = end;
            for k in edge.first..outside.len() {
                if outside[k].p * n + outside[k].r * m > *least {
                    outside.swap(k, end);
                    end += 1;
                }
            }
            edge.end = end;
        }
    }
}

/// Whether no lane of a mask is set. (Which lane is the first does not mean the same on all instruction
/// sets.)
#[inline(always)]
pub(crate) fn none<S: Simd>(simd: S, mask: S::m64s) -> bool {
    simd.first_true_m64s(mask) >= S::F64_LANES
}

/// Directions whose extremes make the first hull.
const DIRECTIONS: usize = 8;

/// The least margin of an inner point, in parts of the size of its terms.
const WELL_INSIDE: f64 = 1e-10;
