//! The sides of a pattern's cell: those units whose borders bound it.
//!
//! Seen from a point inside the cell, the half-plane `g + n·d ≥ 0` (`d` from the point on, `g > 0` its
//! margin there) is the dual point `q = −n/g`, and the sides are the corners of the convex hull of all
//! dual points. The hull is grown from its extremes along the axes (quickhull), so a cell costs a few
//! sweeps over the units. The point is taken half way across the cell from where it is entered. Where
//! there is none, because several borders meet at the entry, the sides are found by clipping.

use crate::affine::word;
use crate::atlas::NONE;
use crate::cell::{HalfPlane, Window};
use crate::clip::{Clipper, SIDE_TOLERANCE};
use crate::network::LANES;
use pam_core::simd::arch;
use pulp::{Simd, WithSimd};

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
    dual: Dual,
    /// Corners of the hull.
    corners: Vec<u32>,
    /// Edges of the hull that are not done.
    edges: Vec<(u32, u32)>,
    /// Dual points outside of the first hull.
    outside: Vec<u32>,
    clipper: Clipper,
}

/// Dual points: those of the units, then of the four sides of the window. Points that are no candidates
/// any more are NaN.
#[derive(Debug, Default)]
struct Dual {
    p: Vec<f64>,
    r: Vec<f64>,
    margin: Vec<f64>,
    rate: Vec<f64>,
}

impl SideFinder {
    /// Adds the sides of the cell with these pre-activations and signs to `out`.
    pub(crate) fn find(
        &mut self,
        window: &Window,
        table: &[f64],
        bits: &[u64],
        entry: Option<Entry>,
        out: &mut Vec<Sides>,
    ) {
        let inside = |e: &Entry| window.contains(e.0);
        let found = entry.filter(inside).is_some_and(|entry| {
            arch().dispatch(Hull { finder: self, window, table, bits, entry })
        });
        if !found {
            self.clipper.find(window, table, bits, out);
            return;
        }
        let units = table.len() / 3;
        let mut sides = Sides::EMPTY;
        let mut lane = 0;
        for &unit in self.corners.iter().filter(|&&u| (u as usize) < units) {
            if lane == LANES {
                out.push(sides);
                (sides, lane) = (Sides::EMPTY, 0);
            }
            sides.set(lane, unit, &half_plane(table, bits, unit as usize));
            lane += 1;
        }
        out.push(sides);
    }
}

/// The half-plane on which a unit keeps its sign.
fn half_plane(table: &[f64], bits: &[u64], unit: usize) -> HalfPlane {
    let units = table.len() / 3;
    let (w, bit) = word(unit);
    let sign = if bits[w] & bit != 0 { 1.0 } else { -1.0 };
    HalfPlane {
        alpha: sign * table[unit],
        beta: sign * table[units + unit],
        gamma: sign * table[2 * units + unit],
    }
}

/// Whether the hull was found, whose corners are then in the finder's memory.
struct Hull<'a> {
    finder: &'a mut SideFinder,
    window: &'a Window,
    table: &'a [f64],
    bits: &'a [u64],
    entry: Entry,
}

impl WithSimd for Hull<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> bool {
        let Self { finder, window, table, bits, entry: (point, through) } = self;
        let SideFinder { dual, corners, edges, outside, .. } = finder;
        let Some(middle) = dual.inner_point(window, table, bits, point, through) else {
            return false;
        };
        if !dual.place(window, table, bits, middle) {
            return false;
        }
        corners.clear();
        edges.clear();
        // Extremes along the axes, counter-clockwise; one may be the extreme of several directions.
        for direction in [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]] {
            let Some(extreme) = dual.farthest(direction) else { return false };
            if corners.last() != Some(&extreme) && corners.first() != Some(&extreme) {
                corners.push(extreme);
            }
        }
        let count = corners.len();
        if count < 2 {
            return false;
        }
        edges.extend((0..count).map(|k| (corners[k], corners[(k + 1) % count])));
        dual.collect_outside(edges, corners, outside);
        while let Some((a, b)) = edges.pop() {
            let (normal, least) = dual.edge(a, b);
            let mut best = least;
            let mut found = None;
            for (place, &i) in outside.iter().enumerate() {
                let value = dual.p[i as usize] * normal[0] + dual.r[i as usize] * normal[1];
                if value > best {
                    (best, found) = (value, Some(place));
                }
            }
            if let Some(place) = found {
                let new = outside.swap_remove(place);
                corners.push(new);
                edges.push((a, new));
                edges.push((new, b));
            }
        }
        true
    }
}

impl Dual {
    /// A point well inside of the cell: half way from `point`, on the border of the unit `through`, to
    /// the next border. `None` if other borders meet at `point`.
    #[inline(always)]
    fn inner_point(
        &mut self,
        window: &Window,
        table: &[f64],
        bits: &[u64],
        point: [f64; 2],
        through: u32,
    ) -> Option<[f64; 2]> {
        let units = table.len() / 3;
        let direction = if through == NONE {
            [0.0, 0.0]
        } else {
            let plane = half_plane(table, bits, through as usize);
            [plane.beta, plane.gamma]
        };
        self.margin.resize(units, 0.0);
        self.rate.resize(units, 0.0);
        let part = |k: usize| table[k * units..(k + 1) * units].as_chunks::<LANES>().0;
        let (alpha, beta, gamma) = (part(0), part(1), part(2));
        let margins = self.margin.as_chunks_mut::<LANES>().0;
        let rates = self.rate.as_chunks_mut::<LANES>().0;
        for chunk in 0..alpha.len() {
            let first = chunk * LANES;
            let signs = !(bits[first / 64] >> (first % 64));
            for i in 0..LANES {
                let flip = ((signs >> i) & 1) << 63;
                let turn = |x: f64| f64::from_bits(x.to_bits() ^ flip);
                let (b, c) = (beta[chunk][i], gamma[chunk][i]);
                margins[chunk][i] = turn(alpha[chunk][i] + b * point[0] + c * point[1]);
                rates[chunk][i] = turn(b * direction[0] + c * direction[1]);
            }
        }
        if through != NONE {
            self.margin[through as usize] = f64::INFINITY;
        }
        // The least time margin : −rate as a fraction, so that nothing is divided, lane by lane.
        let mut best = [1.0; LANES];
        let mut best_speed = [0.0; LANES];
        let mut least = [f64::INFINITY; LANES];
        let margins = self.margin.as_chunks::<LANES>().0;
        for (margin, rate) in margins.iter().zip(self.rate.as_chunks::<LANES>().0) {
            for i in 0..LANES {
                let speed = -rate[i];
                let sooner = speed > 0.0 && margin[i] * best_speed[i] < best[i] * speed;
                best[i] = if sooner { margin[i] } else { best[i] };
                best_speed[i] = if sooner { speed } else { best_speed[i] };
                // Dead units are no borders.
                let of = if is_border(margin[i]) { margin[i] } else { least[i] };
                least[i] = if of < least[i] { of } else { least[i] };
            }
        }
        let mut time = f64::INFINITY;
        for i in 0..LANES {
            time = if best_speed[i] > 0.0 { time.min(best[i] / best_speed[i]) } else { time };
        }
        let least = least.iter().fold(f64::INFINITY, |a, b| a.min(*b));
        if !(least >= 0.0) {
            return None;
        }
        let mut reach = |value: f64, speed: f64, [low, high]: [f64; 2]| {
            if speed > 0.0 {
                time = time.min((high - value) / speed);
            } else if speed < 0.0 {
                time = time.min((low - value) / speed);
            }
        };
        reach(point[0], direction[0], window.first);
        reach(point[1], direction[1], window.second);
        if through == NONE {
            return (least > 0.0).then_some(point);
        }
        let step = 0.5 * time;
        let middle = [point[0] + step * direction[0], point[1] + step * direction[1]];
        // What the way gains over rounding of the point itself.
        let gain = step * (direction[0] * direction[0] + direction[1] * direction[1]);
        let plane = half_plane(table, bits, through as usize);
        let size =
            plane.alpha.abs() + (plane.beta * point[0]).abs() + (plane.gamma * point[1]).abs();
        (time.is_finite() && gain > WELL_INSIDE * size).then_some(middle)
    }

    /// The dual points seen from `middle`; false if that is no point of the cell, by rounding.
    #[inline(always)]
    fn place(&mut self, window: &Window, table: &[f64], bits: &[u64], middle: [f64; 2]) -> bool {
        let units = table.len() / 3;
        self.p.resize(units + LANES, f64::NAN);
        self.r.resize(units + LANES, f64::NAN);
        let part = |k: usize| table[k * units..(k + 1) * units].as_chunks::<LANES>().0;
        let (alpha, beta, gamma) = (part(0), part(1), part(2));
        let p = self.p.as_chunks_mut::<LANES>().0;
        let r = self.r.as_chunks_mut::<LANES>().0;
        let mut misfits = 0;
        for chunk in 0..alpha.len() {
            let first = chunk * LANES;
            let signs = bits[first / 64] >> (first % 64);
            for i in 0..LANES {
                let (b, c) = (beta[chunk][i], gamma[chunk][i]);
                let margin = alpha[chunk][i] + b * middle[0] + c * middle[1];
                // Both signs turn margin and normal alike.
                misfits |= u64::from(margin > 0.0) ^ ((signs >> i) & 1);
                let scale = -1.0 / margin;
                p[chunk][i] = b * scale;
                r[chunk][i] = c * scale;
            }
        }
        let ([p0, p1], [r0, r1]) = (window.first, window.second);
        p[alpha.len()] = [f64::NAN; LANES];
        r[alpha.len()] = [f64::NAN; LANES];
        for (i, q) in [
            [1.0 / (p1 - middle[0]), 0.0],
            [0.0, 1.0 / (r1 - middle[1])],
            [1.0 / (p0 - middle[0]), 0.0],
            [0.0, 1.0 / (r0 - middle[1])],
        ]
        .into_iter()
        .enumerate()
        {
            p[alpha.len()][i] = q[0];
            r[alpha.len()][i] = q[1];
        }
        misfits == 0
    }

    /// The dual point farthest along a direction.
    #[inline(always)]
    fn farthest(&self, [u, w]: [f64; 2]) -> Option<u32> {
        let mut best = [f64::NEG_INFINITY; LANES];
        let mut at = [0.0; LANES];
        let points = self.p.as_chunks::<LANES>().0.iter().zip(self.r.as_chunks::<LANES>().0);
        for (chunk, (p, r)) in points.enumerate() {
            let chunk = chunk as f64;
            for i in 0..LANES {
                let value = u * p[i] + w * r[i];
                let farther = value > best[i];
                best[i] = if farther { value } else { best[i] };
                at[i] = if farther { chunk } else { at[i] };
            }
        }
        let mut found = 0;
        for i in 1..LANES {
            found = if best[i] > best[found] { i } else { found };
        }
        (best[found].is_finite()).then(|| at[found] as u32 * LANES as u32 + found as u32)
    }

    /// The outward normal of the edge from `a` to `b`, and how far along it a point must lie to be
    /// outside. Points within [`SIDE_TOLERANCE`] of the edge count: their borders come that near a
    /// corner of the cell.
    #[inline(always)]
    fn edge(&self, a: u32, b: u32) -> ([f64; 2], f64) {
        let (a, b) = (a as usize, b as usize);
        let normal = [self.r[b] - self.r[a], self.p[a] - self.p[b]];
        let at = self.p[a] * normal[0] + self.r[a] * normal[1];
        (normal, at - SIDE_TOLERANCE * at.abs())
    }

    /// The dual points outside of a first hull, its corners excepted.
    #[inline(always)]
    fn collect_outside(&self, edges: &[(u32, u32)], corners: &[u32], outside: &mut Vec<u32>) {
        let mut normals = [[0.0; 2]; 4];
        let mut least = [f64::INFINITY; 4];
        for (k, &(a, b)) in edges.iter().enumerate() {
            (normals[k], least[k]) = self.edge(a, b);
        }
        outside.clear();
        let points = self.p.as_chunks::<LANES>().0.iter().zip(self.r.as_chunks::<LANES>().0);
        for (chunk, (p, r)) in points.enumerate() {
            let mut beyond = [0.0_f64; LANES];
            for (normal, least) in normals.iter().zip(&least) {
                for i in 0..LANES {
                    let value = p[i] * normal[0] + r[i] * normal[1];
                    beyond[i] = if value > *least { 1.0 } else { beyond[i] };
                }
            }
            if beyond.iter().sum::<f64>() == 0.0 {
                continue;
            }
            for (i, beyond) in beyond.iter().enumerate() {
                let unit = (chunk * LANES + i) as u32;
                if *beyond > 0.0 && !corners.contains(&unit) {
                    outside.push(unit);
                }
            }
        }
    }
}

#[inline(always)]
fn is_border(margin: f64) -> bool {
    margin.to_bits() << 1 != 0
}

/// The least margin of an inner point, in parts of the size of its terms.
const WELL_INSIDE: f64 = 1e-10;
