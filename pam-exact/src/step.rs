//! A closed-form step inside a pattern, and whether it can come near to a side.

use crate::fundamental::Response;
use crate::lanes::{along, none};
use crate::motion::{Law, jerk_bound};
use crate::network::LANES;
use crate::sides::Sides;
use pulp::Simd;

/// A step, and bounds of how far it strays from its chord.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Step {
    pub(crate) kappa: f64,
    pub(crate) zeta: f64,
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
    pub(crate) most: [f64; 2],
}

impl Step {
    /// The step of the usual length.
    #[inline(always)]
    pub(crate) fn usual(law: &Law, from: [f64; 2], w: [f64; 2]) -> Self {
        Self::new(law, &law.usual, law.jerk, law.covers_s, from, w)
    }

    /// A step as long as `rest_s`, or the longest that the law allows.
    #[inline(always)]
    pub(crate) fn up_to(law: &Law, rest_s: f64, usual_s: f64, from: [f64; 2], w: [f64; 2]) -> Self {
        let h = rest_s.min(law.longest_s);
        if h == usual_s {
            return Self::usual(law, from, w);
        }
        let response = Response::new(law.kappa, law.zeta, h, law.terms_of(h));
        let jerk = if h < usual_s { law.jerk } else { jerk_bound(law.kappa, law.zeta, h) };
        Self::new(law, &response, jerk, h, from, w)
    }

    #[inline(always)]
    fn new(
        law: &Law,
        response: &Response,
        jerk: [f64; 3],
        h: f64,
        from: [f64; 2],
        w: [f64; 2],
    ) -> Self {
        let a = law.acceleration(from, w[0]);
        Self {
            kappa: law.kappa,
            zeta: law.zeta,
            terms: law.terms_of(h),
            from,
            end: response.advance(law.kappa, from, w),
            a,
            w,
            h,
            most: law.bounds(h, jerk, from[1], a, w[1]),
        }
    }

    /// How far displacement and velocity may be from their chords.
    #[inline(always)]
    pub(crate) fn off_chord(&self) -> [f64; 2] {
        let reach = 0.125 * self.h * self.h;
        [reach * self.most[0], reach * self.most[1]]
    }

    /// What the rounding of displacement and velocity is relative to: their own size, and that of their
    /// changes, since they are sums of such.
    #[inline(always)]
    pub(crate) fn size_of_state(&self) -> [f64; 2] {
        let [x, v] = [self.from[0].abs(), self.from[1].abs()];
        [self.h.mul_add(v, x), self.h.mul_add(self.a.abs(), v)]
    }

    /// Acceleration at a state that is reached after `t`.
    #[inline(always)]
    pub(crate) fn acceleration(&self, [x, v]: [f64; 2], t: f64) -> f64 {
        let w = self.w[1].mul_add(t, self.w[0]);
        (-self.zeta).mul_add(v, (-self.kappa).mul_add(x, w))
    }
}

/// Margins of all sides at a state.
#[inline(always)]
pub(crate) fn margins(sides: &Sides, [x, v]: [f64; 2]) -> [f64; LANES] {
    let mut margins = [0.0; LANES];
    for (i, margin) in margins.iter_mut().enumerate() {
        *margin = sides.gamma[i].mul_add(v, sides.beta[i].mul_add(x, sides.alpha[i]));
    }
    margins
}

/// Whether no side's margin can become negative over a step, by the margins at its ends. Those at the end
/// go to `after`.
#[inline(always)]
pub(crate) fn none_near<S: Simd>(
    simd: S,
    sides: &Sides,
    before: &[f64; LANES],
    step: &Step,
    after: &mut [f64; LANES],
) -> bool {
    let off = step.off_chord();
    let (x, v) = (simd.splat_f64s(step.end[0]), simd.splat_f64s(step.end[1]));
    let (alpha, beta) = (S::as_simd_f64s(&sides.alpha).0, S::as_simd_f64s(&sides.beta).0);
    let gamma = S::as_simd_f64s(&sides.gamma).0;
    let before = S::as_simd_f64s(before).0;
    let after = S::as_mut_simd_f64s(after).0;
    let mut all_far = true;
    for k in 0..alpha.len() {
        let (b, c) = (beta[k], gamma[k]);
        after[k] = simd.mul_add_f64s(c, v, simd.mul_add_f64s(b, x, alpha[k]));
        let least = simd.min_f64s(before[k], after[k]);
        let far = along(simd, (simd.abs_f64s(b), simd.abs_f64s(c)), off);
        all_far &= none(simd, simd.less_than_or_equal_f64s(least, far));
    }
    all_far
}
