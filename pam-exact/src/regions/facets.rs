//! The facets of a linear region: the borders of those units that bound it.

use super::half_plane::{HalfPlane, Window};
use crate::network::pattern::sign;
use crate::network::preactivations::PreActivations;
use crate::simd::LANES;

/// Stands for no region and for no unit.
pub(crate) const NONE: u32 = u32::MAX;

/// Half-planes that miss a region by less than this part of its size count as its facets.
pub(crate) const FACET_TOLERANCE: f64 = 1e-9;

/// Up to [`LANES`] facets of a region. Unused lanes have an infinite margin.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct FacetBlock {
    pub(crate) alpha: [f64; LANES],
    pub(crate) beta: [f64; LANES],
    pub(crate) gamma: [f64; LANES],
    /// The unit that changes its sign across the facet.
    pub(crate) unit: [u32; LANES],
    /// The region on the other side, if it is known.
    pub(crate) neighbour: [u32; LANES],
}

/// The blocks of a region in the cache.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FacetRange {
    pub(crate) first: u32,
    pub(crate) blocks: u32,
}

/// One facet of a region.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FacetIndex {
    pub(crate) block: usize,
    pub(crate) lane: usize,
}

/// The half-planes that define a region: those of all units, and a window.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Borders<'a> {
    pub(crate) window: &'a Window,
    pub(crate) table: PreActivations<'a>,
    pub(crate) pattern: &'a [u64],
}

/// A point where a region is entered, and the unit on whose border it lies, if any.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Entry {
    pub(crate) point: [f64; 2],
    pub(crate) unit: u32,
}

impl FacetBlock {
    const EMPTY: Self = Self {
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

    /// The lanes in use.
    pub(crate) fn lanes(&self) -> impl Iterator<Item = usize> {
        (0..LANES).filter(|&lane| self.unit[lane] != NONE)
    }

    /// Margins of all facets at a state.
    #[inline(always)]
    pub(crate) fn margins(&self, [x, v]: [f64; 2]) -> [f64; LANES] {
        let mut margins = [0.0; LANES];
        for (i, margin) in margins.iter_mut().enumerate() {
            *margin = self.gamma[i].mul_add(v, self.beta[i].mul_add(x, self.alpha[i]));
        }
        margins
    }
}

/// Appends the facets of one region, block by block.
pub(crate) fn push_facets(
    out: &mut Vec<FacetBlock>,
    facets: impl Iterator<Item = (u32, HalfPlane)>,
) {
    let mut block = FacetBlock::EMPTY;
    let mut lane = 0;
    for (unit, plane) in facets {
        if lane == LANES {
            out.push(block);
            (block, lane) = (FacetBlock::EMPTY, 0);
        }
        block.alpha[lane] = plane.alpha;
        block.beta[lane] = plane.beta;
        block.gamma[lane] = plane.gamma;
        block.unit[lane] = unit;
        lane += 1;
    }
    out.push(block);
}

impl Borders<'_> {
    /// The half-plane in which a unit keeps its sign.
    pub(crate) fn half_plane(&self, unit: usize) -> HalfPlane {
        let sign = sign(self.pattern, unit);
        let [alpha, beta, gamma] = self.table.unit(unit);
        HalfPlane { alpha: sign * alpha, beta: sign * beta, gamma: sign * gamma }
    }
}
