//! A closed-form step inside a region, and a first check of the facets.

use super::coefficients::{JerkBound, RegionCoefficients, StepKernel};
use super::propagator::{Oscillator, Propagator};
use crate::regions::facets::FacetBlock;
use crate::simd::{LANES, linear_form, none};
use pulp::Simd;

/// A step, with bounds of its acceleration and jerk.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Step {
    pub(crate) oscillator: Oscillator,
    /// Terms of the series for times within the step.
    pub(crate) terms: usize,
    pub(crate) from: [f64; 2],
    pub(crate) end: [f64; 2],
    /// Acceleration at the start.
    pub(crate) a: f64,
    /// Forcing `w₀ + w₁ τ`.
    pub(crate) w: [f64; 2],
    pub(crate) h: f64,
    /// Bounds of acceleration and jerk.
    pub(crate) bounds: [f64; 2],
}

impl Step {
    /// The step of nominal length.
    #[inline(always)]
    pub(crate) fn nominal(coefficients: &RegionCoefficients, from: [f64; 2], w: [f64; 2]) -> Self {
        Self::new(coefficients, &coefficients.nominal, from, w)
    }

    /// A step of length `rest_s`, or the longest that the region allows.
    #[inline(always)]
    pub(crate) fn up_to(
        coefficients: &RegionCoefficients,
        rest_s: f64,
        from: [f64; 2],
        w: [f64; 2],
    ) -> Self {
        let StepKernel { jerk_bound, h: nominal_s, .. } = coefficients.nominal;
        let h = rest_s.min(coefficients.max_step_s);
        if h == nominal_s {
            return Self::nominal(coefficients, from, w);
        }
        let oscillator = coefficients.oscillator;
        let propagator = Propagator::new(oscillator, h, coefficients.terms_of(h));
        let jerk_bound = if h < nominal_s { jerk_bound } else { JerkBound::new(oscillator, h) };
        Self::new(coefficients, &StepKernel { propagator, jerk_bound, h }, from, w)
    }

    #[inline(always)]
    fn new(
        coefficients: &RegionCoefficients,
        kernel: &StepKernel,
        from: [f64; 2],
        w: [f64; 2],
    ) -> Self {
        let (oscillator, h) = (coefficients.oscillator, kernel.h);
        let a = oscillator.acceleration(from, w[0]);
        Self {
            oscillator,
            terms: coefficients.terms_of(h),
            from,
            end: kernel.propagator.advance(oscillator.kappa, from, w),
            a,
            w,
            h,
            bounds: kernel.jerk_bound.bounds(h, from[1], a, w[1]),
        }
    }

    /// Bounds of the distance of displacement and velocity from their chords, `h²/8` times their second
    /// derivatives.
    #[inline(always)]
    pub(crate) fn chord_deviation(&self) -> [f64; 2] {
        let reach = 0.125 * self.h * self.h;
        [reach * self.bounds[0], reach * self.bounds[1]]
    }

    /// The magnitudes to which the rounding of displacement and velocity is relative: their own and those of
    /// their changes.
    #[inline(always)]
    pub(crate) fn magnitudes(&self) -> [f64; 2] {
        let [x, v] = [self.from[0].abs(), self.from[1].abs()];
        [self.h.mul_add(v, x), self.h.mul_add(self.a.abs(), v)]
    }

    /// Acceleration at a state that is reached after `t`.
    #[inline(always)]
    pub(crate) fn acceleration(&self, state: [f64; 2], t: f64) -> f64 {
        self.oscillator.acceleration(state, self.w[1].mul_add(t, self.w[0]))
    }

    /// True if no facet's margin can become negative over the step, by the margins at its ends and the
    /// [`chord_deviation`](Self::chord_deviation). The margins at the end go to `after`.
    #[inline(always)]
    pub(crate) fn clears<S: Simd>(
        &self,
        simd: S,
        facets: &FacetBlock,
        before: &[f64; LANES],
        after: &mut [f64; LANES],
    ) -> bool {
        let deviation = self.chord_deviation();
        let (x, v) = (simd.splat_f64s(self.end[0]), simd.splat_f64s(self.end[1]));
        let (alpha, beta) = (S::as_simd_f64s(&facets.alpha).0, S::as_simd_f64s(&facets.beta).0);
        let gamma = S::as_simd_f64s(&facets.gamma).0;
        let before = S::as_simd_f64s(before).0;
        let after = S::as_mut_simd_f64s(after).0;
        let mut all_far = true;
        for k in 0..alpha.len() {
            let (b, c) = (beta[k], gamma[k]);
            after[k] = simd.mul_add_f64s(c, v, simd.mul_add_f64s(b, x, alpha[k]));
            let least = simd.min_f64s(before[k], after[k]);
            let far = linear_form(simd, [simd.abs_f64s(b), simd.abs_f64s(c)], deviation);
            all_far &= none(simd, simd.less_than_or_equal_f64s(least, far));
        }
        all_far
    }
}
