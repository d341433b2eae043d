//! The sides of a pattern's cell: those units whose borders bound it.
//!
//! Where a point of the cell is known, they are the corners of a hull ([`crate::hull`]); where several
//! borders meet at that point, or none is known, they are found by clipping ([`crate::clip`]).

use crate::affine::{Table, word};
use crate::atlas::NONE;
use crate::cell::{HalfPlane, Window};
use crate::clip::Clipper;
use crate::hull::HullFinder;
use crate::network::LANES;

/// Up to [`LANES`] sides of a cell. Unused places have an infinite margin.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Sides {
    pub(crate) alpha: [f64; LANES],
    pub(crate) beta: [f64; LANES],
    pub(crate) gamma: [f64; LANES],
    /// The unit that changes sign across the side.
    pub(crate) unit: [u32; LANES],
    /// The pattern behind the side, if it is known.
    pub(crate) neighbour: [u32; LANES],
}

impl Sides {
    pub(crate) const EMPTY: Self = Self {
        alpha: [f64::INFINITY; LANES],
        beta: [0.0; LANES],
        gamma: [0.0; LANES],
        unit: [NONE; LANES],
        neighbour: [NONE; LANES],
    };

    #[inline(always)]
    pub(crate) fn half_plane(&self, lane: usize) -> HalfPlane {
        HalfPlane { alpha: self.alpha[lane], beta: self.beta[lane], gamma: self.gamma[lane] }
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, unit: u32, plane: &HalfPlane) {
        self.alpha[lane] = plane.alpha;
        self.beta[lane] = plane.beta;
        self.gamma[lane] = plane.gamma;
        self.unit[lane] = unit;
    }
}

/// A point of a cell, and the unit whose border it lies on, if it lies on one.
pub(crate) type Entry = ([f64; 2], u32);

/// Finds the sides of cells, again and again in the same memory.
#[derive(Debug, Default)]
pub(crate) struct SideFinder {
    hull: HullFinder,
    clipper: Clipper,
}

impl SideFinder {
    /// Adds the sides of the cell with these pre-activations and signs to `out`.
    pub(crate) fn find(
        &mut self,
        window: &Window,
        table: Table<'_>,
        bits: &[u64],
        entry: Option<Entry>,
        out: &mut Vec<Sides>,
    ) {
        let inside = |e: &Entry| window.contains(e.0);
        let corners =
            entry.filter(inside).and_then(|entry| self.hull.find(window, table, bits, entry));
        let Some(corners) = corners else {
            self.clipper.find(window, table, bits, out);
            return;
        };
        let units = table.units();
        out.push(Sides::EMPTY);
        let mut lane = 0;
        for &unit in corners.iter().filter(|&&u| (u as usize) < units) {
            if lane == LANES {
                out.push(Sides::EMPTY);
                lane = 0;
            }
            let plane = half_plane(table, bits, unit as usize);
            out.last_mut().expect("one was pushed").set(lane, unit, &plane);
            lane += 1;
        }
    }
}

/// The half-plane on which a unit keeps its sign.
pub(crate) fn half_plane(table: Table<'_>, bits: &[u64], unit: usize) -> HalfPlane {
    let (w, bit) = word(unit);
    let sign = if bits[w] & bit != 0 { 1.0 } else { -1.0 };
    let [alpha, beta, gamma] = table.unit(unit);
    HalfPlane { alpha: sign * alpha, beta: sign * beta, gamma: sign * gamma }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers in ±1.
    fn spread() -> impl FnMut() -> f64 {
        let mut state = 7_u64;
        move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / f64::from(1_u32 << 30) - 1.0
        }
    }

    fn units(sides: &[Sides]) -> Vec<u32> {
        let mut units: Vec<u32> =
            sides.iter().flat_map(|s| s.unit).filter(|&u| u != NONE).collect();
        units.sort_unstable();
        units
    }

    /// A table that has no first layer.
    fn seen(table: &[f64]) -> Table<'_> {
        const NO_LAYER: &[Vec<f64>; 3] = &[const { Vec::new() }; 3];
        Table { first: NO_LAYER, deeper: table }
    }

    /// The hull of dual points and clipping find the same sides, seen from inside and from a side.
    #[test]
    fn hull_and_clipping_agree() {
        let mut next = spread();
        let window = Window { first: [-1e5, 1e5], second: [-1e7, 1e7] };
        for case in 0..300 {
            let count = [8, 64, 192][case % 3];
            let scale = [1.0, 20.0][case % 2];
            let mut table: Vec<f64> = (0..3 * count).map(|_| next()).collect();
            table[count..2 * count].iter_mut().for_each(|b| *b *= scale);
            // Padding.
            for k in 0..3 {
                table[k * count + 5] = 0.0;
            }
            let at = |table: &[f64], u: usize, [p, r]: [f64; 2]| {
                table[u] + table[count + u] * p + table[2 * count + u] * r
            };
            let point = [0.3 * next(), 0.3 * next()];
            let mut bits = vec![0; count.div_ceil(64)];
            for u in (0..count).filter(|&u| at(&table, u, point) > 0.0) {
                bits[u / 64] |= 1 << (u % 64);
            }
            let mut finder = SideFinder::default();
            let mut clipped = Vec::new();
            finder.clipper.find(&window, seen(&table), &bits, &mut clipped);
            let mut hull = Vec::new();
            finder.find(&window, seen(&table), &bits, Some((point, NONE)), &mut hull);
            assert_eq!(units(&hull), units(&clipped), "from inside, case {case}");
            // From a point on a border.
            if case % 7 == 0 {
                let u = units(&hull)[0] as usize;
                table[u] -= at(&table, u, point);
                let (mut one, mut other) = (Vec::new(), Vec::new());
                finder.find(&window, seen(&table), &bits, Some((point, NONE)), &mut one);
                finder.clipper.find(&window, seen(&table), &bits, &mut other);
                assert_eq!(units(&one), units(&other), "from a border, case {case}");
                continue;
            }
            // Through each side into the cell behind it, at the side's middle.
            for &side in units(&hull).iter().take(2) {
                let mut cell = crate::cell::Cell::default();
                cell.restart(&window);
                for s in &hull {
                    for lane in (0..LANES).filter(|&l| s.unit[l] != NONE) {
                        cell.clip(&s.half_plane(lane));
                    }
                }
                let plane = half_plane(seen(&table), &bits, side as usize);
                let on: Vec<_> = (cell.vertices.iter())
                    .filter(|&&v| plane.margin(v).abs() < 1e-9 * (1.0 + v[0].abs() + v[1].abs()))
                    .collect();
                if on.len() != 2 {
                    continue;
                }
                let entry = [0.5 * (on[0][0] + on[1][0]), 0.5 * (on[0][1] + on[1][1])];
                let mut behind = bits.clone();
                behind[side as usize / 64] ^= 1 << (side % 64);
                let (mut one, mut other) = (Vec::new(), Vec::new());
                finder.find(&window, seen(&table), &behind, Some((entry, side)), &mut one);
                finder.clipper.find(&window, seen(&table), &behind, &mut other);
                assert_eq!(units(&one), units(&other), "through {side}, case {case}");
            }
        }
    }
}
