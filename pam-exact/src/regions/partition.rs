//! All linear regions of a network within a window.

use super::cache::{RegionCache, RegionWorkspace};
use super::facets::FacetIndex;
use super::half_plane::{HalfPlane, Window};
use super::polygon::area;
use crate::network::{Plane, ReluNetwork};

/// One linear region of a plane: a convex polygon on which the force is `a + b p + c r`.
#[derive(Debug, Clone, PartialEq)]
pub struct RegionPolygon {
    /// Vertices, counter-clockwise, in the units of the plane's axes.
    pub vertices: Vec<[f64; 2]>,
    /// The force, `[a, b, c]`: on the plane of motion b is the stiffness in mN/mm and c the damping in
    /// kg/s.
    pub force: [f64; 3],
    /// Area, in the units of the axes.
    pub area: f64,
}

/// All linear regions of a network within a window.
#[derive(Debug, Clone, PartialEq)]
pub struct Partition {
    /// The window.
    pub window: Window,
    /// The regions that reach into it.
    pub regions: Vec<RegionPolygon>,
    /// The share of the window's area that the regions leave uncovered, of either sign: zero to rounding
    /// proves that every region was found.
    pub uncovered_share: f64,
}

/// Regions with a smaller share of the window's area are ignored: rounding leaves nothing of them.
const SMALLEST_SHARE: f64 = 1e-15;
/// Largest uncovered share of a complete partition.
const COMPLETE_SHARE: f64 = 1e-9;
/// Distance beyond a border at which regions are looked up, relative to the window.
const BEYOND: f64 = 1e-6;

impl Partition {
    /// Finds all linear regions of `network` on `plane` within `window`, from neighbour to neighbour across
    /// the facets. Stops at `max_regions`; see then [`uncovered_share`](Self::uncovered_share).
    #[must_use]
    pub fn new(network: &ReluNetwork, plane: Plane, window: Window, max_regions: usize) -> Self {
        Self::in_workspace(network, plane, window, max_regions, &mut RegionWorkspace::default())
    }

    /// As [`new`](Self::new), in the memory of an earlier call.
    pub(crate) fn in_workspace(
        network: &ReluNetwork,
        plane: Plane,
        window: Window,
        max_regions: usize,
        workspace: &mut RegionWorkspace,
    ) -> Self {
        let mut cache = RegionCache::new(network, plane, window, std::mem::take(workspace));
        cache.locate(window.centre());
        let mut partition = Self { window, regions: Vec::new(), uncovered_share: 1.0 };
        let mut covered = 0.0;
        let mut id = 0;
        // Regions are numbered as they are found, so this visits each once.
        loop {
            while (id as usize) < cache.len() && partition.regions.len() < max_regions {
                covered += partition.visit(&mut cache, id);
                id += 1;
            }
            partition.uncovered_share = 1.0 - covered / window.area();
            let complete = partition.uncovered_share.abs() < COMPLETE_SHARE;
            if complete || partition.regions.len() >= max_regions {
                break;
            }
            // Behind a border on which several units switch at once lies an empty pattern: the regions there
            // are looked up at points just beyond the border.
            let known = cache.len();
            for point in partition.points_beyond() {
                if window.contains(point) {
                    cache.locate(point);
                }
            }
            if cache.len() == known {
                break;
            }
        }
        *workspace = cache.into_workspace();
        partition
    }

    /// The region at a point.
    #[must_use]
    pub fn at(&self, point: [f64; 2]) -> Option<&RegionPolygon> {
        self.regions.iter().find(|p| p.contains(point))
    }

    /// Adds a region of the cache, and its neighbours to the cache. Returns its area, zero if the region is
    /// ignored.
    fn visit(&mut self, cache: &mut RegionCache<'_>, id: u32) -> f64 {
        let vertices = cache.polygon(id);
        let area = area(&vertices);
        let counts = area > SMALLEST_SHARE * self.window.area();
        if !counts {
            return 0.0;
        }
        let region = RegionPolygon { vertices, force: cache.region(id).force, area };
        let range = cache.region(id).facets;
        for block in 0..range.blocks as usize {
            let facets = cache.facets(range)[block];
            for lane in facets.lanes() {
                let point = region.middle_of_side(&facets.half_plane(lane));
                cache.neighbour(id, FacetIndex { block, lane }, point);
            }
        }
        self.regions.push(region);
        area
    }

    /// Points just beyond the middle of every side of the regions, and around the centre of the window.
    fn points_beyond(&self) -> Vec<[f64; 2]> {
        let (centre, size) = (self.window.centre(), self.window.widths());
        let step = size.map(|s| BEYOND * s);
        let mut points: Vec<[f64; 2]> = [[1.0, 0.3], [-0.3, 1.0], [-1.0, -0.3], [0.3, -1.0]]
            .map(|d| std::array::from_fn(|i| centre[i] + d[i] * step[i]))
            .to_vec();
        for RegionPolygon { vertices, .. } in &self.regions {
            for (k, a) in vertices.iter().enumerate() {
                let b = vertices[(k + 1) % vertices.len()];
                // In units of the window. Both sides are tried.
                let along: [f64; 2] = std::array::from_fn(|i| (b[i] - a[i]) / size[i]);
                let length = along[0].hypot(along[1]);
                if length > 0.0 {
                    let across = [along[1] / length, -along[0] / length];
                    for sign in [1.0, -1.0] {
                        points.push(std::array::from_fn(|i| {
                            0.5 * (a[i] + b[i]) + sign * across[i] * step[i]
                        }));
                    }
                }
            }
        }
        points
    }
}

impl RegionPolygon {
    /// True if a point lies in the polygon or on its border.
    #[must_use]
    pub fn contains(&self, [p, r]: [f64; 2]) -> bool {
        let count = self.vertices.len();
        (0..count).all(|k| {
            let (a, b) = (self.vertices[k], self.vertices[(k + 1) % count]);
            (b[0] - a[0]) * (r - a[1]) - (b[1] - a[1]) * (p - a[0]) >= 0.0
        })
    }

    /// The affine force of this region at a point, mN.
    #[must_use]
    pub fn force_mn(&self, [p, r]: [f64; 2]) -> f64 {
        self.force[0] + self.force[1] * p + self.force[2] * r
    }

    /// The middle of the side that lies on a half-plane's border.
    fn middle_of_side(&self, side: &HalfPlane) -> Option<[f64; 2]> {
        let margin = |k: usize| side.margin(self.vertices[k]).abs();
        let count = self.vertices.len();
        let next = |k: usize| (k + 1) % count;
        let ends = |k: &usize| margin(*k) + margin(next(*k));
        let k = (0..count).min_by(|a, b| ends(a).total_cmp(&ends(b)))?;
        let (a, b) = (self.vertices[k], self.vertices[next(k)]);
        Some([0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])])
    }
}
