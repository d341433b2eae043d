//! The oscillator of a region, and what all its steps share.

use super::propagator::{
    DifferentiableStep, LONGEST, MAX_SPECTRAL_STEP, Oscillator, Propagator, SelfConvolution,
    series_terms,
};
use crate::regions::cache::Region;
use crate::regions::facets::FacetRange;

/// The joint without its network: m and B of `m ẍ = u − f(x, ẋ) − B ẋ`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Inertia {
    pub(crate) mass_kg: f64,
    pub(crate) damping_kg_s: f64,
}

/// The coefficients of `ẍ + ζ ẋ + κ x = (u − a)/m` in one region. The fields that a forward step reads come
/// first.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(crate) struct RegionCoefficients {
    pub(crate) oscillator: Oscillator,
    /// The constant part `a` of the force, mN.
    pub(crate) offset_mn: f64,
    /// The longest step, s.
    pub(crate) max_step_s: f64,
    /// The nominal step, or the longest if that is shorter.
    pub(crate) nominal: StepKernel,
    /// The facets of the region; a copy, so that a step need not read the region.
    pub(crate) facets: FacetRange,
    /// Terms of the series for steps up to the nominal one.
    terms: u32,
    /// Of the nominal step, if derivatives are wanted.
    convolution: SelfConvolution,
}

/// All that depends on a step's length alone.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub(crate) struct StepKernel {
    pub(crate) propagator: Propagator,
    pub(crate) jerk_bound: JerkBound,
    /// The length, s.
    pub(crate) h: f64,
}

/// A bound of the jerk over a step, `Σ` of these factors times `|w₁|`, `|v₀|` and `|a₀|`.
///
/// At any time `|j| ≤ |w₁| + |κ| |v| + |ζ| |a|`, with `|a| ≤ |a₀| + h |j|` and `|v| ≤ |v₀| + h |a|`; solved for
/// the largest `|j|`.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub(crate) struct JerkBound {
    by_rate: f64,
    by_velocity: f64,
    by_acceleration: f64,
}

impl JerkBound {
    #[inline(always)]
    pub(crate) fn new(Oscillator { kappa, zeta }: Oscillator, h: f64) -> Self {
        let (k, z) = (kappa.abs(), zeta.abs());
        let scale = 1.0 / (1.0 - h * (k * h + z));
        Self { by_rate: scale, by_velocity: scale * k, by_acceleration: scale * (k * h + z) }
    }

    /// Bounds of acceleration and jerk over a step of length `h` that begins with velocity `v` and
    /// acceleration `a`, under a forcing of slope `rate`.
    #[inline(always)]
    pub(crate) fn bounds(&self, h: f64, v: f64, a: f64, rate: f64) -> [f64; 2] {
        let a = a.abs();
        let by_start = self.by_velocity.mul_add(v.abs(), self.by_rate * rate.abs());
        let jerk = self.by_acceleration.mul_add(a, by_start);
        [h.mul_add(jerk, a), jerk]
    }
}

impl RegionCoefficients {
    #[inline(always)]
    pub(crate) fn new(
        inertia: Inertia,
        region: &Region,
        nominal_step_s: f64,
        with_derivatives: bool,
    ) -> Self {
        let [offset_mn, stiffness, damping] = region.force;
        let oscillator = Oscillator {
            kappa: stiffness / inertia.mass_kg,
            zeta: (damping + inertia.damping_kg_s) / inertia.mass_kg,
        };
        let rho = oscillator.spectral_bound();
        let max_step_s = MAX_SPECTRAL_STEP / rho;
        let h = nominal_step_s.min(max_step_s);
        let terms = series_terms(rho * h);
        Self {
            oscillator,
            offset_mn,
            max_step_s,
            nominal: StepKernel {
                propagator: Propagator::new(oscillator, h, terms),
                jerk_bound: JerkBound::new(oscillator, h),
                h,
            },
            facets: region.facets,
            terms: terms as u32,
            convolution: if with_derivatives {
                DifferentiableStep::new(oscillator, h, terms).convolution
            } else {
                SelfConvolution::default()
            },
        }
    }

    /// A step with its derivatives. The length zero stands for the nominal step.
    #[inline(always)]
    pub(crate) fn differentiable_step(&self, length_s: f64) -> DifferentiableStep {
        let oscillator = self.oscillator;
        if length_s == 0.0 {
            let propagator = self.nominal.propagator;
            return DifferentiableStep { oscillator, propagator, convolution: self.convolution };
        }
        DifferentiableStep::new(oscillator, length_s, self.terms_of(length_s))
    }

    /// Terms of the series for a step of length `h`.
    #[inline(always)]
    pub(crate) fn terms_of(&self, h: f64) -> usize {
        if h <= self.nominal.h { self.terms as usize } else { LONGEST }
    }
}
