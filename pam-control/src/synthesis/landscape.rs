//! Force balance and stiffness over the masses.

use super::stencil::Local;

/// `g` and K̂ of one target over the masses.
pub(super) trait Landscape {
    /// Values and derivatives at a pair of masses.
    fn at(&mut self, u: [f64; 2]) -> Local;

    /// How far from the last pair asked for both stay affine along a direction of length one, g.
    fn reach(&mut self, direction: [f64; 2]) -> f64;

    /// True if both are piecewise affine, so that the reach is exact.
    fn is_piecewise_affine(&self) -> bool;
}
