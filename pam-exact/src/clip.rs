//! The sides of a cell by clipping: slower than the hull of dual points, but it needs no point inside.

use crate::affine::Table;
use crate::cell::{Cell, Clip, HalfPlane, Window};
use crate::network::LANES;
use crate::sides::Sides;
use pam_core::simd::arch;
use pulp::{Simd, WithSimd};

/// Half-planes that miss the cell by less than this part of its size count as its sides.
pub(crate) const SIDE_TOLERANCE: f64 = 1e-9;

/// Rounds of clipping after which the half-planes that can cut no more are dropped.
const COMPACT_EVERY: usize = 4;

/// Clips cells, again and again in the same memory.
#[derive(Debug, Default)]
pub(crate) struct Clipper {
    signed: Vec<f64>,
    /// Units of the places in `signed`.
    candidates: Vec<u32>,
    /// Units whose borders were tried, and whether they left nothing.
    processed: Vec<(u32, HalfPlane, bool)>,
    cell: Cell,
}

impl Clipper {
    /// Adds the sides of the cell with these pre-activations and signs: clips a window with the
    /// half-plane that comes closest to the middle of what is left, until none can cut the rectangle
    /// around it.
    pub(crate) fn find(
        &mut self,
        window: &Window,
        table: Table<'_>,
        bits: &[u64],
        out: &mut Vec<Sides>,
    ) {
        let Self { signed, candidates, processed, cell } = self;
        let units = table.units();
        arch().dispatch(Orient { units, table, bits, signed });
        candidates.clear();
        candidates.extend(0..units as u32);
        processed.clear();
        cell.restart(window);
        let mut len = units;
        let mut round = 0;
        loop {
            let (middle, half) = cell.bounds();
            round += 1;
            if round % COMPACT_EVERY == 0 {
                len = compact(signed, candidates, units, len, middle, half);
            }
            let found = arch().dispatch(Closest { signed, units, len, middle, half });
            let Some(place) = found else { break };
            let plane = HalfPlane {
                alpha: signed[place],
                beta: signed[units + place],
                gamma: signed[2 * units + place],
            };
            let nothing = cell.clip(&plane) == Clip::Nothing;
            processed.push((candidates[place], plane, nothing));
            signed[place] = f64::INFINITY;
        }
        let (_, half) = cell.bounds();
        let mut sides = Sides::EMPTY;
        let mut lane = 0;
        for &(unit, plane, forced) in &*processed {
            let least =
                cell.vertices.iter().map(|&v| plane.margin(v)).fold(f64::INFINITY, f64::min);
            let reach = plane.beta.abs() * half[0] + plane.gamma.abs() * half[1];
            if least > SIDE_TOLERANCE * reach && !forced {
                continue;
            }
            if lane == LANES {
                out.push(sides);
                (sides, lane) = (Sides::EMPTY, 0);
            }
            sides.set(lane, unit, &plane);
            lane += 1;
        }
        out.push(sides);
    }
}

/// Turns the pre-activations so that all are positive inside the cell.
struct Orient<'a> {
    units: usize,
    table: Table<'a>,
    bits: &'a [u64],
    signed: &'a mut Vec<f64>,
}

impl WithSimd for Orient<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { units, table, bits, signed } = self;
        signed.clear();
        let [first, deeper] = table.parts();
        for (first, deeper) in first.iter().zip(deeper) {
            signed.extend_from_slice(first);
            signed.extend_from_slice(deeper);
        }
        for part in signed.chunks_exact_mut(units) {
            for (block, bits) in part.chunks_mut(64).zip(bits) {
                for (i, value) in block.iter_mut().enumerate() {
                    let negative = !(bits >> i) & 1;
                    *value = f64::from_bits(value.to_bits() ^ (negative << 63));
                }
            }
        }
    }
}

/// Moves the half-planes that still enter a rectangle to the front, and returns how many these are, up
/// to a whole vector.
fn compact(
    signed: &mut [f64],
    candidates: &mut [u32],
    units: usize,
    len: usize,
    middle: [f64; 2],
    half: [f64; 2],
) -> usize {
    let mut kept = 0;
    for i in 0..len {
        let (alpha, beta, gamma) = (signed[i], signed[units + i], signed[2 * units + i]);
        let margin = alpha + beta * middle[0] + gamma * middle[1];
        let reach = beta.abs() * half[0] + gamma.abs() * half[1];
        if margin < (1.0 + SIDE_TOLERANCE) * reach {
            signed[kept] = alpha;
            signed[units + kept] = beta;
            signed[2 * units + kept] = gamma;
            candidates[kept] = candidates[i];
            kept += 1;
        }
    }
    let whole = kept.next_multiple_of(LANES).min(units);
    signed[kept..whole].fill(f64::INFINITY);
    whole
}

/// The half-plane whose border comes closest to the middle of a rectangle, in parts of its reach over
/// the rectangle, of those that enter it. (Half-planes that reach nowhere never do.)
struct Closest<'a> {
    signed: &'a [f64],
    units: usize,
    len: usize,
    middle: [f64; 2],
    half: [f64; 2],
}

impl WithSimd for Closest<'_> {
    type Output = Option<usize>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Option<usize> {
        let Self { signed, units, len, middle, half } = self;
        let (alpha, rest) = signed.split_at(units);
        let (beta, gamma) = rest.split_at(units);
        let (alpha, _) = alpha[..len].as_chunks::<LANES>();
        let (beta, _) = beta[..len].as_chunks::<LANES>();
        let (gamma, _) = gamma[..len].as_chunks::<LANES>();
        // The least ratio margin : reach of each lane, as a fraction, so that nothing is divided.
        let mut best = [1.0 + SIDE_TOLERANCE; LANES];
        let mut best_reach = [1.0; LANES];
        let mut at = [-1.0; LANES];
        for (chunk, ((a, b), c)) in alpha.iter().zip(beta).zip(gamma).enumerate() {
            let chunk = chunk as f64;
            for i in 0..LANES {
                let margin = a[i] + b[i] * middle[0] + c[i] * middle[1];
                let reach = b[i].abs() * half[0] + c[i].abs() * half[1];
                let closer = margin * best_reach[i] < best[i] * reach;
                best[i] = if closer { margin } else { best[i] };
                best_reach[i] = if closer { reach } else { best_reach[i] };
                at[i] = if closer { chunk } else { at[i] };
            }
        }
        let mut found = None;
        let mut least = f64::INFINITY;
        for i in 0..LANES {
            let ratio = best[i] / best_reach[i];
            if at[i] >= 0.0 && ratio < least {
                least = ratio;
                found = Some(at[i] as usize * LANES + i);
            }
        }
        found
    }
}
