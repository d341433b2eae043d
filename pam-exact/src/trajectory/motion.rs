//! The motion of the joint inside each region.

use crate::network::{Plane, ReluNetwork};
use crate::regions::Window;
use crate::regions::cache::{RegionCache, RegionWorkspace};
use crate::regions::facets::FacetIndex;
use crate::step::coefficients::{Inertia, RegionCoefficients};
use pam_core::simd::arch;
use pam_core::{ForceModel, JointModel, ModelError};
use pulp::{Simd, WithSimd};

/// Limits of displacement (mm) and velocity (mm/s), far beyond any joint: a trajectory that leaves them has
/// diverged.
pub(crate) const LIMITS: Window = Window { first: [-1e5, 1e5], second: [-1e7, 1e7] };

/// A joint with sealed air whose restoring force is a (leaky) ReLU network: `m ẍ = u − f(x, ẋ) − B ẋ`.
#[derive(Debug, Clone)]
pub struct ExactMotion {
    /// The network.
    pub network: ReluNetwork,
    /// Reflected mass m, kg.
    pub mass_kg: f64,
    /// Auxiliary damping B, kg/s.
    pub auxiliary_damping_kg_s: f64,
}

impl ExactMotion {
    /// The motion of a joint.
    ///
    /// # Errors
    /// [`ModelError::Shape`] if its force is not a (leaky) ReLU network.
    pub fn new<F: ForceModel<f64>>(model: &JointModel<f64, F>) -> Result<Self, ModelError> {
        Ok(Self {
            network: ReluNetwork::new(&model.force)?,
            mass_kg: model.physical().mass_kg,
            auxiliary_damping_kg_s: model.auxiliary_damping_kg_s,
        })
    }
}

/// The regions that a trajectory has met, with the coefficients of motion in each.
#[derive(Debug)]
pub(crate) struct MotionRegions<'n> {
    pub(crate) motion: &'n ExactMotion,
    pub(crate) cache: RegionCache<'n>,
    pub(crate) coefficients: Vec<RegionCoefficients>,
    /// The length of most forcing segments, s.
    pub(crate) nominal_step_s: f64,
    with_derivatives: bool,
}

/// The memory of [`MotionRegions`].
#[derive(Debug, Default)]
pub(crate) struct MotionWorkspace {
    regions: RegionWorkspace,
    coefficients: Vec<RegionCoefficients>,
}

impl<'n> MotionRegions<'n> {
    pub(crate) fn new(
        motion: &'n ExactMotion,
        masses_g: [f64; 2],
        nominal_step_s: f64,
        with_derivatives: bool,
        workspace: MotionWorkspace,
    ) -> Self {
        let MotionWorkspace { regions, mut coefficients } = workspace;
        coefficients.clear();
        let plane = Plane::of_motion(masses_g);
        let cache = RegionCache::new(&motion.network, plane, LIMITS, regions);
        Self { motion, cache, coefficients, nominal_step_s, with_derivatives }
    }

    pub(crate) fn into_workspace(self) -> MotionWorkspace {
        MotionWorkspace { regions: self.cache.into_workspace(), coefficients: self.coefficients }
    }

    /// The region of a state.
    pub(crate) fn locate(&mut self, state: [f64; 2]) -> u32 {
        let id = self.cache.locate(state);
        self.catch_up();
        id
    }

    /// The region behind a facet that is crossed at a state.
    #[inline(always)]
    pub(crate) fn neighbour(&mut self, id: u32, facet: FacetIndex, state: [f64; 2]) -> u32 {
        let new = self.cache.neighbour(id, facet, Some(state));
        self.catch_up();
        new
    }

    /// Adds the coefficients of new regions.
    #[inline(always)]
    fn catch_up(&mut self) {
        if self.coefficients.len() < self.cache.len() {
            self.add_coefficients();
        }
    }

    #[cold]
    #[inline(never)]
    fn add_coefficients(&mut self) {
        arch().dispatch(AddCoefficients(self));
    }
}

struct AddCoefficients<'a, 'n>(&'a mut MotionRegions<'n>);

impl WithSimd for AddCoefficients<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self(MotionRegions { motion, cache, coefficients, nominal_step_s, with_derivatives }) =
            self;
        let damping_kg_s = motion.auxiliary_damping_kg_s;
        let inertia = Inertia { mass_kg: motion.mass_kg, damping_kg_s };
        for id in coefficients.len()..cache.len() {
            let region = cache.region(id as u32);
            let new = RegionCoefficients::new(inertia, region, *nominal_step_s, *with_derivatives);
            coefficients.push(new);
        }
    }
}
