//! The backward pass in time: costates by the transposed propagators, moments region by region.

use crate::trajectory::forcing::ForcingSegments;
use crate::trajectory::forward::Segment;
use crate::trajectory::motion::MotionRegions;
use pam_core::simd::arch;
use pulp::{Simd, WithSimd};

/// Integrals of the velocity's costate `λ_v` times `1`, `x` and `ẋ` over all the time spent in a region.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct RegionMoments {
    pub(crate) one: f64,
    pub(crate) x: f64,
    pub(crate) v: f64,
}

/// Derivatives with respect to all but the network.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct CostateSums {
    /// By the state at the start.
    pub(crate) start: [f64; 2],
    /// By m.
    pub(crate) mass: f64,
    /// By B.
    pub(crate) damping: f64,
}

/// The backward pass of one trajectory.
pub(crate) struct CostatePass<'a, 'n> {
    pub(crate) regions: &'a MotionRegions<'n>,
    pub(crate) forcing: ForcingSegments<'a>,
    pub(crate) segments: &'a [Segment],
    /// Cotangents of the observed states, `[observation, (x, ẋ)]`.
    pub(crate) cotangents: &'a [f64],
    /// One for each region, zeros on entry.
    pub(crate) moments: &'a mut [RegionMoments],
}

impl CostatePass<'_, '_> {
    pub(crate) fn run(self) -> CostateSums {
        arch().dispatch(self)
    }
}

impl WithSimd for CostatePass<'_, '_> {
    type Output = CostateSums;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> CostateSums {
        let inverse_mass = 1.0 / self.regions.motion.mass_kg;
        let mut costate = [0.0; 2];
        let mut forcing_index = u32::MAX;
        let mut observation = self.cotangents.len() / 2;
        let (mut force, mut along_v) = (0.0, 0.0);
        let mut end = self.segments.len();
        while end > 0 {
            // Consecutive segments of one region.
            let region = self.segments[end - 1].region;
            let coefficients = &self.regions.coefficients[region as usize];
            let oscillator = coefficients.oscillator;
            let mut own = RegionMoments::default();
            while end > 0 && self.segments[end - 1].region == region {
                let s = &self.segments[end - 1];
                end -= 1;
                let forcing = self.forcing.get(s.forcing as usize).expect("segments are driven");
                if s.forcing != forcing_index {
                    forcing_index = s.forcing;
                    if forcing.observed {
                        observation -= 1;
                        costate[0] += self.cotangents[2 * observation];
                        costate[1] += self.cotangents[2 * observation + 1];
                    }
                }
                let w = [
                    (s.force_mn - coefficients.offset_mn) * inverse_mass,
                    forcing.rate_mn_s * inverse_mass,
                ];
                let step = coefficients.differentiable_step(s.length_s);
                let m = step.moments([s.x, s.v], w, costate);
                costate = step.propagator.pull_back(oscillator.kappa, costate);
                own.one += m.one;
                own.x += m.x;
                own.v += m.v;
                force += w[0] * m.one + w[1] * m.time;
            }
            force -= oscillator.kappa * own.x + oscillator.zeta * own.v;
            along_v += own.v;
            let total = &mut self.moments[region as usize];
            total.one += own.one;
            total.x += own.x;
            total.v += own.v;
        }
        // ẍ = (u − f − B ẋ)/m has the derivatives −ẍ/m by m and −ẋ/m by B.
        CostateSums {
            start: costate,
            mass: -force * inverse_mass,
            damping: -along_v * inverse_mass,
        }
    }
}
