//! The sides of a cell as the corners of a hull.
//!
//! Seen from a point inside the cell, the half-plane `g + n·d ≥ 0` (`d` from the point on, `g > 0` its
//! margin there) is the dual point `q = −n/g`, and the sides are the corners of the convex hull of all
//! dual points. The hull is grown from its extremes along the axes: beyond each edge the farthest point is
//! looked for, and becomes a corner, until there is none. Several edges share a sweep over the units. The
//! point is taken half way across the cell from where it is entered.

use crate::affine::{Table, slopes_into};
use crate::atlas::NONE;
use crate::cell::Window;
use crate::clip::SIDE_TOLERANCE;
use crate::lanes::{LANE_NUMBERS, tagged};
use crate::network::LANES;
use crate::sides::Entry;
use pam_core::simd::arch;
use pulp::{Simd, WithSimd};
use std::cmp::Ordering;

/// Finds hulls, again and again in the same memory.
#[derive(Debug, Default)]
pub(crate) struct HullFinder {
    dual: Dual,
    /// Corners of the hull: units.
    corners: Vec<u32>,
    /// Edges beyond which no point was looked for yet.
    edges: Vec<Edge>,
}

impl HullFinder {
    /// The units whose borders bound the cell with these pre-activations and signs; those past the last
    /// unit are the window's sides. `None` where several borders meet at the entry, and for more units
    /// than can be told apart.
    pub(crate) fn find(
        &mut self,
        window: &Window,
        table: Table<'_>,
        bits: &[u64],
        entry: Entry,
    ) -> Option<&[u32]> {
        if table.units() + LANES > PLACE_BITS as usize {
            return None;
        }
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

/// An edge of a hull that grows, counter-clockwise.
#[derive(Debug, Clone, Copy)]
struct Edge {
    from: Point,
    to: Point,
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
    table: Table<'a>,
    bits: &'a [u64],
    entry: Entry,
}

impl WithSimd for Hull<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let Self { finder, window, table, bits, entry: (point, through) } = self;
        let HullFinder { dual, corners, edges } = finder;
        let units = table.units();
        dual.signs.resize(units, 0.0);
        slopes_into(bits, -1.0, &mut dual.signs);
        let Some(middle) = dual.inner_point(simd, window, table, point, through) else {
            return false;
        };
        if !dual.place(simd, window, table, middle) {
            return false;
        }
        corners.clear();
        edges.clear();
        let extremes = dual.farthest(simd, AXES);
        for (k, (from, _)) in extremes.iter().enumerate() {
            // One point may be the extreme of several directions next to each other.
            let (to, _) = extremes[(k + 1) % AXES.len()];
            if from.unit != to.unit {
                edges.push(Edge { from: *from, to });
            }
        }
        for edge in &*edges {
            dual.take(edge.to.unit, corners);
        }
        if edges.len() < 2 {
            return false;
        }
        while !edges.is_empty() {
            let some = edges.len().saturating_sub(AT_ONCE);
            let mut tried = [edges[some]; AT_ONCE];
            let count = edges.len() - some;
            tried[..count].copy_from_slice(&edges[some..]);
            edges.truncate(some);
            let mut borders = [([0.0; 2], 0.0); AT_ONCE];
            let mut normals = [[0.0; 2]; AT_ONCE];
            for k in 0..AT_ONCE {
                borders[k] = tried[k].border();
                normals[k] = borders[k].0;
            }
            let farthest = dual.farthest(simd, normals);
            for (k, edge) in tried[..count].iter().enumerate() {
                let (corner, along) = farthest[k];
                if along.partial_cmp(&borders[k].1.max(INSIDE)) != Some(Ordering::Greater) {
                    continue;
                }
                if corners.contains(&corner.unit) {
                    edges.push(*edge); // Another edge took it just now; there may be more.
                    continue;
                }
                dual.take(corner.unit, corners);
                edges.push(Edge { from: edge.from, to: corner });
                edges.push(Edge { from: corner, to: edge.to });
            }
        }
        true
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
        table: Table<'_>,
        point: [f64; 2],
        through: u32,
    ) -> Option<[f64; 2]> {
        let mut border = [0.0; 3];
        if through != NONE {
            border = table.unit(through as usize);
            for border in &mut border {
                *border *= self.signs[through as usize];
            }
        }
        let direction = [border[1], border[2]];
        let signs = S::as_simd_f64s(&self.signs).0;
        let zero = simd.splat_f64s(0.0);
        let (p, r) = (simd.splat_f64s(point[0]), simd.splat_f64s(point[1]));
        let (dp, dr) = (simd.splat_f64s(direction[0]), simd.splat_f64s(direction[1]));
        let far = simd.splat_f64s(f64::INFINITY);
        let through_unit = simd.splat_u64s(u64::from(through));
        let mut unit = S::as_simd_u64s(&LANE_NUMBERS).0[0];
        let lanes = simd.splat_u64s(S::F64_LANES as u64);
        // The least margin, and the largest speed per margin, of all borders but that of the entry.
        let mut least = far;
        let mut fastest = zero;
        let mut chunk = 0;
        for [alpha, beta, gamma] in table.parts() {
            let (alpha, beta) = (S::as_simd_f64s(alpha).0, S::as_simd_f64s(beta).0);
            for ((&alpha, &beta), &gamma) in alpha.iter().zip(beta).zip(S::as_simd_f64s(gamma).0) {
                let value = simd.mul_add_f64s(gamma, r, simd.mul_add_f64s(beta, p, alpha));
                let rate = simd.mul_add_f64s(gamma, dr, simd.mul_f64s(beta, dp));
                let margin = simd.mul_f64s(signs[chunk], value);
                let speed = simd.neg_f64s(simd.div_f64s(rate, value));
                // Padding has neither value nor slope: no border.
                let size = simd.add_f64s(simd.abs_f64s(beta), simd.abs_f64s(gamma));
                let size = simd.add_f64s(size, simd.abs_f64s(value));
                let other = simd.not_m64s(simd.equal_u64s(unit, through_unit));
                let real = simd.and_m64s(simd.greater_than_f64s(size, zero), other);
                least = simd.min_f64s(least, simd.select_f64s(real, margin, far));
                fastest = simd.max_f64s(fastest, simd.select_f64s(real, speed, zero));
                unit = simd.add_u64s(unit, lanes);
                chunk += 1;
            }
        }
        let least = simd.reduce_min_f64s(least);
        if least.is_nan() || least <= 0.0 {
            return None;
        }
        if through == NONE {
            let clear = (0..table.units()).all(|u| {
                let [a, b, c] = table.unit(u);
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

    /// The dual points seen from `middle`; false if that is no inner point of the cell, by rounding.
    #[inline(always)]
    fn place<S: Simd>(
        &mut self,
        simd: S,
        window: &Window,
        table: Table<'_>,
        middle: [f64; 2],
    ) -> bool {
        let units = table.units();
        self.p.resize(units + LANES, 0.0);
        self.r.resize(units + LANES, 0.0);
        let signs = S::as_simd_f64s(&self.signs).0;
        let (p, p_window) = self.p.split_at_mut(units);
        let (r, r_window) = self.r.split_at_mut(units);
        let (p, r) = (S::as_mut_simd_f64s(p).0, S::as_mut_simd_f64s(r).0);
        let (x, v) = (simd.splat_f64s(middle[0]), simd.splat_f64s(middle[1]));
        let minus = simd.splat_f64s(-1.0);
        let zero = simd.splat_f64s(0.0);
        let mut least = zero;
        let mut chunk = 0;
        for [alpha, beta, gamma] in table.parts() {
            let (alpha, beta) = (S::as_simd_f64s(alpha).0, S::as_simd_f64s(beta).0);
            for ((&alpha, &b), &c) in alpha.iter().zip(beta).zip(S::as_simd_f64s(gamma).0) {
                let value = simd.mul_add_f64s(c, v, simd.mul_add_f64s(b, x, alpha));
                least = simd.min_f64s(least, simd.mul_f64s(signs[chunk], value));
                let on_border = simd.equal_f64s(value, zero);
                let size = simd.add_f64s(simd.abs_f64s(b), simd.abs_f64s(c));
                least =
                    simd.select_f64s(on_border, simd.min_f64s(least, simd.neg_f64s(size)), least);
                // Signs turn margin and normal alike. Padding goes to the origin, inside of all edges.
                let scale = simd.div_f64s(minus, value);
                let scale = simd.select_f64s(on_border, zero, scale);
                p[chunk] = simd.mul_f64s(b, scale);
                r[chunk] = simd.mul_f64s(c, scale);
                chunk += 1;
            }
        }
        let ([p0, p1], [r0, r1]) = (window.first, window.second);
        p_window[4..].fill(0.0);
        r_window[4..].fill(0.0);
        p_window[..4].copy_from_slice(&[1.0 / (p1 - middle[0]), 0.0, 1.0 / (p0 - middle[0]), 0.0]);
        r_window[..4].copy_from_slice(&[0.0, 1.0 / (r1 - middle[1]), 0.0, 1.0 / (r0 - middle[1])]);
        simd.reduce_min_f64s(least) >= 0.0
    }

    fn point(&self, unit: usize) -> Point {
        Point { p: self.p[unit], r: self.r[unit], unit: unit as u32 }
    }

    /// Makes a unit a corner. Its point is taken to the origin, which is inside of all edges, so that it
    /// is not found again.
    #[inline(always)]
    fn take(&mut self, unit: u32, corners: &mut Vec<u32>) {
        corners.push(unit);
        self.p[unit as usize] = 0.0;
        self.r[unit as usize] = 0.0;
    }

    /// The points farthest along some directions, and how far to [`PLACE_BITS`].
    #[inline(always)]
    fn farthest<S: Simd>(
        &self,
        simd: S,
        directions: [[f64; 2]; AT_ONCE],
    ) -> [(Point, f64); AT_ONCE] {
        let (p, r) = (S::as_simd_f64s(&self.p).0, S::as_simd_f64s(&self.r).0);
        // Loops in place of closures over arrays: those are compiled without the wide instructions.
        let mut lines = [[simd.splat_f64s(0.0); 2]; AT_ONCE];
        for (line, [u, w]) in lines.iter_mut().zip(directions) {
            *line = [simd.splat_f64s(u), simd.splat_f64s(w)];
        }
        let lanes = S::as_simd_u64s(&LANE_NUMBERS).0[0];
        let rest = simd.splat_u64s(!PLACE_BITS);
        let mut best = [simd.splat_f64s(f64::NEG_INFINITY); AT_ONCE];
        for (chunk, (&p, &r)) in p.iter().zip(r).enumerate() {
            let unit = simd.or_u64s(lanes, simd.splat_u64s((chunk * S::F64_LANES) as u64));
            for (best, &[u, w]) in best.iter_mut().zip(&lines) {
                let value = simd.mul_add_f64s(u, p, simd.mul_f64s(w, r));
                *best = simd.max_f64s(*best, tagged(simd, value, rest, unit));
            }
        }
        let mut points = [(Point { p: 0.0, r: 0.0, unit: NONE }, 0.0); AT_ONCE];
        for (point, best) in points.iter_mut().zip(best) {
            let most = simd.reduce_max_f64s(best);
            *point = (self.point((most.to_bits() & PLACE_BITS) as usize), most);
        }
        points
    }
}

/// The bits of a value along a direction that say which unit it belongs to: it is rounded to 10⁻¹¹ of
/// itself, far less than [`SIDE_TOLERANCE`].
const PLACE_BITS: u64 = 0xffff;
/// Values along a direction up to this are those of points at the origin.
const INSIDE: f64 = f64::MIN_POSITIVE;
/// Directions of which the extremes are looked for at once.
const AT_ONCE: usize = 4;
/// Directions whose extremes make the first hull.
const AXES: [[f64; 2]; AT_ONCE] = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];

/// The least margin of an inner point, in parts of the size of its terms.
const WELL_INSIDE: f64 = 1e-10;

#[cfg(test)]
mod tests {
    use super::*;

    /// From a point on a border the unit would have no dual point, and its side would be lost.
    #[test]
    fn a_middle_on_a_border_is_refused() {
        // Borders at x = 1, ẋ = 1 and ẋ = −1, as `α | β | γ`, and padding.
        let rows = [[1.0, 1.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 1.0]];
        let mut deeper = Vec::new();
        for row in rows {
            deeper.extend(row);
            deeper.resize(deeper.len().next_multiple_of(LANES), 0.0);
        }
        let first = <[Vec<f64>; 3]>::default();
        let table = Table { first: &first, deeper: &deeper };
        let window = Window { first: [-9.0, 9.0], second: [-9.0, 9.0] };
        let mut dual = Dual { signs: vec![1.0; LANES], ..Dual::default() };
        let mut inside = |middle| dual.place(pulp::Scalar::new(), &window, table, middle);
        assert!(inside([0.0, 0.5]));
        assert!(!inside([0.0, 1.0]) && !inside([1.0, 0.5]));
        assert!(!inside([0.0, 1.5]));
    }
}
