//! The linear regions of a ReLU network on a plane: convex polygons in which the force is affine.
//!
//! The first layer's sign changes lie on straight lines, those of a deeper layer on lines within each
//! pattern; so an activation pattern holds in a convex polygon, its *linear region* (Montúfar, Pascanu, Cho,
//! Bengio: *On the number of linear regions of deep neural networks*, 2014). Its sides, here *facets*, belong
//! to a handful of the network's units. Only these need be checked along a motion.
//!
//! **Finding facets.** Unit `i` restricts the region to a half-plane `gᵢ + nᵢ·d ≥ 0` with `d` measured from an
//! inner point, `gᵢ > 0`. Under polar duality the half-plane is the point `−nᵢ/gᵢ`, and the facets are the
//! vertices of the convex hull of these points. The hull grows from its extreme points along the axes by
//! adding the supporting point beyond each edge, as in Quickhull (Barber, Dobkin, Huhdanpaa, 1996). Where no
//! inner point is available, because several lines meet at the entry, polygon clipping finds the facets
//! (Sutherland, Hodgman, 1974); a test compares both.
//!
//! **Cache.** Each facet stores the region on its other side, so a crossing is a look-up. A region that is new
//! gets its pre-activations from its neighbour by an update of rank one.
//!
//! | file | holds |
//! |---|---|
//! | `half_plane` | half-planes and the rectangular [`Window`] |
//! | `polygon` | convex polygons and their clipping |
//! | `facets` | the facets of a region, in blocks of one SIMD vector |
//! | `dual` | inner points, dual points and supporting points |
//! | `by_hull`, `by_clipping` | the two ways to the facets |
//! | `facet_finder` | which of them is used |
//! | `cache` | the regions visited so far |
//! | `partition` | all regions of a window |

mod by_clipping;
mod by_hull;
pub(crate) mod cache;
mod dual;
mod facet_finder;
pub(crate) mod facets;
mod half_plane;
pub(crate) mod partition;
mod polygon;

pub use half_plane::Window;
pub use partition::{Partition, RegionPolygon};
