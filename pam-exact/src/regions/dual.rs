//! Polar duality between the half-planes of a region and points.
//!
//! Seen from an inner point, the half-plane `g + n·d ≥ 0` (`d` measured from the point, `g > 0`) has the dual
//! point `−n/g`. The facets of the region are the vertices of the convex hull of all dual points.

use super::facets::{Borders, Entry, NONE};
use crate::network::pattern::slopes_into;
use crate::network::preactivations::PreActivations;
use crate::simd::{LANE_NUMBERS, LANES, tagged};
use pulp::Simd;

/// Dual points of all units, then of the four sides of the window.
#[derive(Debug, Default)]
pub(super) struct DualPoints {
    p: Vec<f64>,
    r: Vec<f64>,
    /// `±1`, the signs of the units in the pattern.
    signs: Vec<f64>,
}

/// A dual point and its unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DualPoint {
    pub(super) p: f64,
    pub(super) r: f64,
    pub(super) unit: u32,
}

/// The supporting point of the dual points in a direction: the farthest one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Support {
    pub(super) point: DualPoint,
    /// Its coordinate along the direction, up to the [`INDEX_BITS`].
    pub(super) along: f64,
}

/// The smallest margin and the largest rate per margin, over all borders but that of the entry.
struct Nearest {
    margin: f64,
    rate: f64,
}

/// The last bits of a coordinate along a direction hold the index of the point. The coordinate is rounded
/// to 10⁻¹¹ of itself, far less than [`FACET_TOLERANCE`](super::facets::FACET_TOLERANCE).
pub(super) const INDEX_BITS: u64 = 0xffff;
/// Directions whose supporting points are found in one sweep.
pub(super) const DIRECTIONS: usize = 4;
/// The smallest margin of an inner point, relative to the size of its terms.
const INNER_MARGIN: f64 = 1e-10;

impl DualPoints {
    /// Takes the signs of a pattern.
    #[inline(always)]
    pub(super) fn set_signs(&mut self, borders: Borders<'_>) {
        self.signs.resize(borders.table.units(), 0.0);
        slopes_into(borders.pattern, -1.0, &mut self.signs);
    }

    /// A point well inside of the region: half way from the entry, along the normal of the border that is
    /// crossed there, to the next border. `None` if other borders meet at the entry.
    #[inline(always)]
    pub(super) fn inner_point<S: Simd>(
        &self,
        simd: S,
        Borders { window, table, .. }: Borders<'_>,
        entry: Entry,
    ) -> Option<[f64; 2]> {
        let point = entry.point;
        let mut border = [0.0; 3];
        if entry.unit != NONE {
            border = table.unit(entry.unit as usize);
            for border in &mut border {
                *border *= self.signs[entry.unit as usize];
            }
        }
        let direction = [border[1], border[2]];
        let nearest = self.nearest(simd, table, entry, direction);
        if nearest.margin.is_nan() || nearest.margin <= 0.0 {
            return None;
        }
        if entry.unit == NONE {
            let clear = (0..table.units()).all(|u| {
                let [a, b, c] = table.unit(u);
                let terms = [a, b * point[0], c * point[1]];
                let size: f64 = terms.iter().map(|t| t.abs()).sum();
                size == 0.0 || terms.iter().sum::<f64>().abs() > INNER_MARGIN * size
            });
            return clear.then_some(point);
        }
        let mut time = 1.0 / nearest.rate;
        for (i, [low, high]) in [window.first, window.second].into_iter().enumerate() {
            let room = if direction[i] > 0.0 { high - point[i] } else { low - point[i] };
            if direction[i] != 0.0 {
                time = time.min(room / direction[i]);
            }
        }
        let step = 0.5 * time;
        let inner = [point[0] + step * direction[0], point[1] + step * direction[1]];
        // The margin gained, compared with the rounding of the point itself.
        let gain = step * (direction[0] * direction[0] + direction[1] * direction[1]);
        let size = border[0].abs() + (border[1] * point[0]).abs() + (border[2] * point[1]).abs();
        (time.is_finite() && gain > INNER_MARGIN * size).then_some(inner)
    }

    /// The border that is closest to the entry, and the one that a motion along `direction` reaches first.
    #[inline(always)]
    fn nearest<S: Simd>(
        &self,
        simd: S,
        table: PreActivations<'_>,
        Entry { point, unit: through }: Entry,
        direction: [f64; 2],
    ) -> Nearest {
        let signs = S::as_simd_f64s(&self.signs).0;
        let zero = simd.splat_f64s(0.0);
        let (p, r) = (simd.splat_f64s(point[0]), simd.splat_f64s(point[1]));
        let (dp, dr) = (simd.splat_f64s(direction[0]), simd.splat_f64s(direction[1]));
        let far = simd.splat_f64s(f64::INFINITY);
        let through = simd.splat_u64s(u64::from(through));
        let mut unit = S::as_simd_u64s(&LANE_NUMBERS).0[0];
        let lanes = simd.splat_u64s(S::F64_LANES as u64);
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
                let other = simd.not_m64s(simd.equal_u64s(unit, through));
                let real = simd.and_m64s(simd.greater_than_f64s(size, zero), other);
                least = simd.min_f64s(least, simd.select_f64s(real, margin, far));
                fastest = simd.max_f64s(fastest, simd.select_f64s(real, speed, zero));
                unit = simd.add_u64s(unit, lanes);
                chunk += 1;
            }
        }
        Nearest { margin: simd.reduce_min_f64s(least), rate: simd.reduce_max_f64s(fastest) }
    }

    /// Computes the dual points seen from `inner`; false if rounding puts that point outside of the region.
    #[inline(always)]
    pub(super) fn place<S: Simd>(
        &mut self,
        simd: S,
        Borders { window, table, .. }: Borders<'_>,
        inner: [f64; 2],
    ) -> bool {
        let units = table.units();
        self.p.resize(units + LANES, 0.0);
        self.r.resize(units + LANES, 0.0);
        let signs = S::as_simd_f64s(&self.signs).0;
        let (p, p_window) = self.p.split_at_mut(units);
        let (r, r_window) = self.r.split_at_mut(units);
        let (p, r) = (S::as_mut_simd_f64s(p).0, S::as_mut_simd_f64s(r).0);
        let (x, v) = (simd.splat_f64s(inner[0]), simd.splat_f64s(inner[1]));
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
        p_window[..4].copy_from_slice(&[1.0 / (p1 - inner[0]), 0.0, 1.0 / (p0 - inner[0]), 0.0]);
        r_window[..4].copy_from_slice(&[0.0, 1.0 / (r1 - inner[1]), 0.0, 1.0 / (r0 - inner[1])]);
        simd.reduce_min_f64s(least) >= 0.0
    }

    fn point(&self, unit: usize) -> DualPoint {
        DualPoint { p: self.p[unit], r: self.r[unit], unit: unit as u32 }
    }

    /// Moves the point of a unit to the origin, which is inside of all edges, so that it is not found again.
    #[inline(always)]
    pub(super) fn remove(&mut self, unit: u32) {
        self.p[unit as usize] = 0.0;
        self.r[unit as usize] = 0.0;
    }

    /// The supporting points in some directions.
    #[inline(always)]
    pub(super) fn supports<S: Simd>(
        &self,
        simd: S,
        directions: [[f64; 2]; DIRECTIONS],
    ) -> [Support; DIRECTIONS] {
        let (p, r) = (S::as_simd_f64s(&self.p).0, S::as_simd_f64s(&self.r).0);
        // Loops in place of closures over arrays: those are compiled without the wide instructions.
        let mut lines = [[simd.splat_f64s(0.0); 2]; DIRECTIONS];
        for (line, [u, w]) in lines.iter_mut().zip(directions) {
            *line = [simd.splat_f64s(u), simd.splat_f64s(w)];
        }
        let lanes = S::as_simd_u64s(&LANE_NUMBERS).0[0];
        let rest = simd.splat_u64s(!INDEX_BITS);
        let mut best = [simd.splat_f64s(f64::NEG_INFINITY); DIRECTIONS];
        for (chunk, (&p, &r)) in p.iter().zip(r).enumerate() {
            let unit = simd.or_u64s(lanes, simd.splat_u64s((chunk * S::F64_LANES) as u64));
            for (best, &[u, w]) in best.iter_mut().zip(&lines) {
                let value = simd.mul_add_f64s(u, p, simd.mul_f64s(w, r));
                *best = simd.max_f64s(*best, tagged(simd, value, rest, unit));
            }
        }
        let nowhere = DualPoint { p: 0.0, r: 0.0, unit: NONE };
        let mut supports = [Support { point: nowhere, along: 0.0 }; DIRECTIONS];
        for (support, best) in supports.iter_mut().zip(best) {
            let along = simd.reduce_max_f64s(best);
            let point = self.point((along.to_bits() & INDEX_BITS) as usize);
            *support = Support { point, along };
        }
        supports
    }
}

#[cfg(test)]
mod tests {
    use super::super::half_plane::Window;
    use super::*;

    /// From a point on a border the unit would have no dual point, and its facet would be lost.
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
        let table = PreActivations { first: &first, deeper: &deeper };
        let window = &Window { first: [-9.0, 9.0], second: [-9.0, 9.0] };
        let borders = Borders { window, table, pattern: &[] };
        let mut dual = DualPoints { signs: vec![1.0; LANES], ..DualPoints::default() };
        let mut inside = |inner| dual.place(pulp::Scalar::new(), borders, inner);
        assert!(inside([0.0, 0.5]));
        assert!(!inside([0.0, 1.0]) && !inside([1.0, 0.5]));
        assert!(!inside([0.0, 1.5]));
    }
}
