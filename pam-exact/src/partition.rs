//! The polygons in which a network is affine.

use crate::atlas::{Atlas, AtlasMemory, NONE, Pattern};
use crate::cell::{HalfPlane, Window};
use crate::network::{LANES, PiecewiseNetwork, Plane};

/// One polygon of a plane on which the force is `a + b p + c r`.
#[derive(Debug, Clone, PartialEq)]
pub struct Polygon {
    /// Corners, counter-clockwise, in the units of the plane's axes.
    pub corners: Vec<[f64; 2]>,
    /// The force, `[a, b, c]`: on the plane of motion b is the stiffness in mN/mm and c the damping in
    /// kg/s.
    pub force: [f64; 3],
    /// Area, in the units of the axes.
    pub area: f64,
}

/// All polygons of a network within a window.
#[derive(Debug, Clone, PartialEq)]
pub struct Partition {
    /// The window.
    pub window: Window,
    /// The polygons that reach into it.
    pub polygons: Vec<Polygon>,
    /// Area of the window less that of all polygons, over that of the window: what is missing. Zero to
    /// rounding says that every polygon was found.
    pub missing: f64,
}

/// What [`Partition::new`] finds nothing smaller than, in parts of the window's area: corners where
/// rounding leaves nothing of a polygon.
const NOTHING: f64 = 1e-15;
/// Missing share of the window below which nothing is missing.
const COMPLETE: f64 = 1e-9;
/// Distance beyond a border at which patterns are looked up, in units of the window.
const BEYOND: f64 = 1e-6;

impl Partition {
    /// Finds all polygons of `network` on `plane` within `window`, from one to its neighbours across
    /// each side. Stops at `most` polygons; [`missing`](Self::missing) then says how much is left out.
    #[must_use]
    pub fn new(network: &PiecewiseNetwork, plane: Plane, window: Window, most: usize) -> Self {
        Partitioner::default().partition(network, plane, window, most)
    }

    /// The polygon at a point.
    #[must_use]
    pub fn at(&self, point: [f64; 2]) -> Option<&Polygon> {
        self.polygons.iter().find(|p| p.contains(point))
    }
}

impl Polygon {
    /// Whether a point lies in the polygon or on its border.
    #[must_use]
    pub fn contains(&self, [p, r]: [f64; 2]) -> bool {
        let count = self.corners.len();
        (0..count).all(|k| {
            let (a, b) = (self.corners[k], self.corners[(k + 1) % count]);
            (b[0] - a[0]) * (r - a[1]) - (b[1] - a[1]) * (p - a[0]) >= 0.0
        })
    }

    /// The force at a point by the polygon's affine piece, mN.
    #[must_use]
    pub fn force_mn(&self, [p, r]: [f64; 2]) -> f64 {
        self.force[0] + self.force[1] * p + self.force[2] * r
    }
}

/// Finds partitions again and again in the same memory.
#[derive(Debug, Default)]
pub struct Partitioner {
    memory: AtlasMemory,
}

impl Partitioner {
    /// See [`Partition::new`].
    #[must_use]
    pub fn partition(
        &mut self,
        network: &PiecewiseNetwork,
        plane: Plane,
        window: Window,
        most: usize,
    ) -> Partition {
        let mut atlas = Atlas::new(network, plane, window, std::mem::take(&mut self.memory));
        atlas.at(middle_of(window));
        let whole = (window.first[1] - window.first[0]) * (window.second[1] - window.second[0]);
        let mut polygons: Vec<Polygon> = Vec::new();
        let mut covered = 0.0;
        let mut id = 0;
        // Patterns are numbered as they are found, so this visits each once.
        loop {
            while (id as usize) < atlas.len() && polygons.len() < most {
                let corners = atlas.polygon(id);
                let area = area(&corners);
                if area > NOTHING * whole {
                    covered += area;
                    polygons.push(Polygon { corners, force: atlas.pattern(id).force, area });
                    let Pattern { sides: first, side_blocks: blocks, .. } = *atlas.pattern(id);
                    for block in 0..blocks as usize {
                        for lane in 0..LANES {
                            let sides = &atlas.sides(first, blocks)[block];
                            if sides.unit[lane] != NONE {
                                let side = sides.half_plane(lane);
                                let entry = middle_of_side(&polygons[polygons.len() - 1], &side);
                                atlas.behind(id, block, lane, entry);
                            }
                        }
                    }
                }
                id += 1;
            }
            // Behind a border on which several units switch at once lies an empty pattern: what is there is
            // looked up from points just beyond it.
            if (1.0 - covered / whole).abs() < COMPLETE || polygons.len() >= most {
                break;
            }
            let known = atlas.len();
            let size = [window.first[1] - window.first[0], window.second[1] - window.second[0]];
            for point in beyond(&polygons, middle_of(window), size) {
                if window.contains(point) {
                    atlas.at(point);
                }
            }
            if atlas.len() == known {
                break;
            }
        }
        self.memory = atlas.into_memory();
        Partition { window, polygons, missing: 1.0 - covered / whole }
    }
}

fn middle_of(window: Window) -> [f64; 2] {
    [window.first, window.second].map(|range| 0.5 * (range[0] + range[1]))
}

/// Points just beyond the middle of every side of the polygons, and around a given point.
fn beyond(polygons: &[Polygon], around: [f64; 2], size: [f64; 2]) -> Vec<[f64; 2]> {
    let step = size.map(|s| BEYOND * s);
    let mut points: Vec<[f64; 2]> = [[1.0, 0.3], [-0.3, 1.0], [-1.0, -0.3], [0.3, -1.0]]
        .map(|d| std::array::from_fn(|i| around[i] + d[i] * step[i]))
        .to_vec();
    for polygon in polygons {
        let corners = &polygon.corners;
        for (k, a) in corners.iter().enumerate() {
            let b = corners[(k + 1) % corners.len()];
            // In units of the window; corners go round counterclockwise or not, so both sides are tried.
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

/// The middle of the side of a polygon that lies on a half-plane's border.
fn middle_of_side(polygon: &Polygon, side: &HalfPlane) -> Option<[f64; 2]> {
    let corners = &polygon.corners;
    let margin = |k: usize| side.margin(corners[k]).abs();
    let count = corners.len();
    let next = |k: usize| (k + 1) % count;
    let ends = |k: &usize| margin(*k) + margin(next(*k));
    let k = (0..count).min_by(|a, b| ends(a).total_cmp(&ends(b)))?;
    let (a, b) = (corners[k], corners[next(k)]);
    Some([0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])])
}

/// The area of a polygon about its first corner.
pub(crate) fn area(corners: &[[f64; 2]]) -> f64 {
    let Some(&o) = corners.first() else { return 0.0 };
    let about = |v: [f64; 2]| [v[0] - o[0], v[1] - o[1]];
    corners
        .windows(2)
        .map(|w| {
            let (a, b) = (about(w[0]), about(w[1]));
            0.5 * (a[0] * b[1] - a[1] * b[0])
        })
        .sum()
}
