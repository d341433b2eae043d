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

/// A landscape with a budget of evaluations. Once it is used up, every value is unknown, and whatever follows a curve ends.
pub(super) struct Counted<'a, L> {
    pub(super) landscape: &'a mut L,
    pub(super) left: &'a mut usize,
    /// Cost of one evaluation.
    pub(super) price: usize,
}

impl<L: Landscape> Landscape for Counted<'_, L> {
    fn at(&mut self, u: [f64; 2]) -> Local {
        if *self.left == 0 {
            return Local::UNKNOWN;
        }
        *self.left = self.left.saturating_sub(self.price);
        self.landscape.at(u)
    }

    fn reach(&mut self, direction: [f64; 2]) -> f64 {
        self.landscape.reach(direction)
    }

    fn is_piecewise_affine(&self) -> bool {
        self.landscape.is_piecewise_affine()
    }
}
