//! The facets of a region by clipping: slower than by the hull of dual points, but without an inner point.

use super::facets::{Borders, FACET_TOLERANCE, FacetBlock, push_facets};
use super::half_plane::HalfPlane;
use super::polygon::{BoundingBox, Clip, ConvexPolygon};
use crate::simd::LANES;
use pam_core::simd::arch;
use pulp::{Simd, WithSimd};

/// Rounds of clipping after which the half-planes that can cut no more are dropped.
const COMPACT_EVERY: usize = 4;

/// Buffers of the clipping.
#[derive(Debug, Default)]
pub(crate) struct Clipper {
    /// `α | β | γ` of the candidates, positive inside the region.
    oriented: Vec<f64>,
    /// Units of the candidates.
    candidates: Vec<u32>,
    tried: Vec<Tried>,
    polygon: ConvexPolygon,
}

/// A unit whose half-plane was tried.
#[derive(Debug, Clone, Copy)]
struct Tried {
    unit: u32,
    plane: HalfPlane,
    /// True if it would have left nothing.
    left_nothing: bool,
}

impl Clipper {
    /// Appends the facets of a region: clips the window by the half-plane that comes closest to the centre
    /// of the rest, until none can cut the bounding box of the rest.
    pub(crate) fn find(&mut self, borders: Borders<'_>, out: &mut Vec<FacetBlock>) {
        let Self { oriented, candidates, tried, polygon } = self;
        let units = borders.table.units();
        arch().dispatch(Orient { borders, oriented });
        candidates.clear();
        candidates.extend(0..units as u32);
        tried.clear();
        polygon.restart(borders.window);
        let mut len = units;
        let mut round = 0;
        loop {
            let around = polygon.bounding_box();
            round += 1;
            if round % COMPACT_EVERY == 0 {
                len = compact(oriented, candidates, len, around);
            }
            let found = arch().dispatch(Closest { oriented, units, len, around });
            let Some(place) = found else { break };
            let plane = HalfPlane {
                alpha: oriented[place],
                beta: oriented[units + place],
                gamma: oriented[2 * units + place],
            };
            let left_nothing = polygon.clip(&plane) == Clip::Nothing;
            tried.push(Tried { unit: candidates[place], plane, left_nothing });
            oriented[place] = f64::INFINITY;
        }
        let [half_p, half_r] = polygon.bounding_box().half_widths;
        let bounds = |t: &&Tried| {
            let margins = polygon.vertices.iter().map(|&v| t.plane.margin(v));
            let least = margins.fold(f64::INFINITY, f64::min);
            let reach = t.plane.beta.abs() * half_p + t.plane.gamma.abs() * half_r;
            let misses = least > FACET_TOLERANCE * reach;
            t.left_nothing || !misses
        };
        push_facets(out, tried.iter().filter(bounds).map(|t| (t.unit, t.plane)));
    }
}

/// Turns the pre-activations so that all are positive inside the region.
struct Orient<'a> {
    borders: Borders<'a>,
    oriented: &'a mut Vec<f64>,
}

impl WithSimd for Orient<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { borders: Borders { table, pattern, .. }, oriented } = self;
        oriented.clear();
        let [first, deeper] = table.parts();
        for (first, deeper) in first.iter().zip(deeper) {
            oriented.extend_from_slice(first);
            oriented.extend_from_slice(deeper);
        }
        for part in oriented.chunks_exact_mut(table.units()) {
            for (block, bits) in part.chunks_mut(64).zip(pattern) {
                for (i, value) in block.iter_mut().enumerate() {
                    let negative = !(bits >> i) & 1;
                    *value = f64::from_bits(value.to_bits() ^ (negative << 63));
                }
            }
        }
    }
}

/// Moves the half-planes that still enter a rectangle to the front, and returns their number, up to a whole
/// vector.
fn compact(
    oriented: &mut [f64],
    candidates: &mut [u32],
    len: usize,
    BoundingBox { centre, half_widths }: BoundingBox,
) -> usize {
    let units = candidates.len();
    let mut kept = 0;
    for i in 0..len {
        let (alpha, beta, gamma) = (oriented[i], oriented[units + i], oriented[2 * units + i]);
        let margin = alpha + beta * centre[0] + gamma * centre[1];
        let reach = beta.abs() * half_widths[0] + gamma.abs() * half_widths[1];
        if margin < (1.0 + FACET_TOLERANCE) * reach {
            oriented[kept] = alpha;
            oriented[units + kept] = beta;
            oriented[2 * units + kept] = gamma;
            candidates[kept] = candidates[i];
            kept += 1;
        }
    }
    let whole = kept.next_multiple_of(LANES).min(units);
    oriented[kept..whole].fill(f64::INFINITY);
    whole
}

/// Of the half-planes that enter a rectangle, the one whose border comes closest to its centre, relative to
/// its reach over the rectangle. (Half-planes without a reach never enter.)
struct Closest<'a> {
    oriented: &'a [f64],
    units: usize,
    len: usize,
    around: BoundingBox,
}

impl WithSimd for Closest<'_> {
    type Output = Option<usize>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Option<usize> {
        let Self { oriented, units, len, around: BoundingBox { centre, half_widths } } = self;
        let (alpha, rest) = oriented.split_at(units);
        let (beta, gamma) = rest.split_at(units);
        let (alpha, _) = alpha[..len].as_chunks::<LANES>();
        let (beta, _) = beta[..len].as_chunks::<LANES>();
        let (gamma, _) = gamma[..len].as_chunks::<LANES>();
        // The least ratio margin : reach of each lane, as a fraction, which saves divisions.
        let mut best = [1.0 + FACET_TOLERANCE; LANES];
        let mut best_reach = [1.0; LANES];
        let mut at = [-1.0; LANES];
        for (chunk, ((a, b), c)) in alpha.iter().zip(beta).zip(gamma).enumerate() {
            let chunk = chunk as f64;
            for i in 0..LANES {
                let margin = a[i] + b[i] * centre[0] + c[i] * centre[1];
                let reach = b[i].abs() * half_widths[0] + c[i].abs() * half_widths[1];
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
