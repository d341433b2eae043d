//! The first facet crossed, for margins that rise or fall throughout the step; all facets of a block at a
//! time.

use super::closed_form::Step;
use super::propagator::{LONGEST, MEDIUM, SHORT};
use super::taylor::TaylorSeries;
use crate::regions::facets::{FacetBlock, NONE};
use crate::simd::{LANE_NUMBERS, LANES, linear_form, none, tagged};
use pulp::Simd;

/// The result for all facets of a block.
pub(super) enum Outlook {
    /// No facet is crossed.
    Stays,
    Leaves(FacetCrossing),
    /// Each facet must be examined by itself.
    Undecided,
}

/// Time, state and lane of a crossing.
pub(super) struct FacetCrossing {
    pub(super) after_s: f64,
    pub(super) state: [f64; 2],
    pub(super) lane: usize,
}

/// Monotonicity of all margins over a step.
struct Monotonicity {
    /// Each margin stays positive, rises throughout or falls throughout.
    all_clear: bool,
    /// A margin falls throughout to a negative value.
    any_crossed: bool,
}

/// Tolerance of a crossing's time relative to the step, estimated from the last correction. The field is
/// continuous across the facet, so a time error `δ` changes the state by the order of `δ²` only.
const ROOT_TOLERANCE: f64 = 1e-12;
/// Steps of Halley's method before a root is left to the bracketing method.
const MAX_ROOT_STEPS: usize = 6;
/// Stands for the time of a crossing where there is none, longer than any step.
const NEVER: f64 = 1e300;
/// Shorter than [`NEVER`] and longer than any step.
const EVER: f64 = 1e299;
/// The last bits of a time hold the lane of its facet.
const LANE_BITS: u64 = LANES as u64 - 1;

impl Step {
    /// Examines all facets of a region at once. The first crossing is the one among those expected at whose
    /// time no other margin is negative yet. `entered` is the unit whose facet was crossed just before.
    #[inline(always)]
    pub(super) fn outlook<S: Simd>(&self, simd: S, facets: &FacetBlock, entered: u32) -> Outlook {
        let mut before = facets.margins(self.from);
        if entered != NONE {
            // The tables of two regions agree on their common facet to rounding only.
            for (before, unit) in before.iter_mut().zip(&facets.unit) {
                *before = if *unit == entered { 0.0 } else { *before };
            }
        }
        let Monotonicity { all_clear, any_crossed } = self.monotonicity(simd, facets, &before);
        if !all_clear {
            return Outlook::Undecided;
        }
        if !any_crossed {
            return Outlook::Stays;
        }
        let mut times = [NEVER; LANES];
        let first = self.expected_times(simd, facets, &before, &mut times);
        if first <= 0.0 {
            return Outlook::Undecided;
        }
        let lane = (first.to_bits() & LANE_BITS) as usize;
        let line = [facets.alpha[lane], facets.beta[lane], facets.gamma[lane]];
        let root = match self.terms {
            SHORT => self.root(&TaylorSeries::<{ SHORT - 3 }>::new(self), line, first),
            MEDIUM => self.root(&TaylorSeries::<{ MEDIUM - 3 }>::new(self), line, first),
            _ => self.root(&TaylorSeries::<LONGEST>::new(self), line, first),
        };
        let Some((after_s, state)) = root else { return Outlook::Undecided };
        let there = facets.margins(state);
        let mut earlier = false;
        for (i, (margin, time)) in there.iter().zip(&times).enumerate() {
            earlier |= (*margin < 0.0) & (*time < EVER) & (i != lane);
        }
        if earlier {
            return Outlook::Undecided;
        }
        Outlook::Leaves(FacetCrossing { after_s, state, lane })
    }

    /// Checks margins and slopes at the start against bounds of the curvature.
    #[inline(always)]
    fn monotonicity<S: Simd>(
        &self,
        simd: S,
        facets: &FacetBlock,
        before: &[f64; LANES],
    ) -> Monotonicity {
        let (deviation, magnitudes) = (self.chord_deviation(), self.magnitudes());
        let (zero, length) = (simd.splat_f64s(0.0), simd.splat_f64s(self.h));
        let (alpha, beta) = (S::as_simd_f64s(&facets.alpha).0, S::as_simd_f64s(&facets.beta).0);
        let (gamma, before) = (S::as_simd_f64s(&facets.gamma).0, S::as_simd_f64s(before).0);
        let (mut all_clear, mut any_crossed) = (true, false);
        for k in 0..alpha.len() {
            let (start, line) = (before[k], [beta[k], gamma[k]]);
            let sizes = [simd.abs_f64s(beta[k]), simd.abs_f64s(gamma[k])];
            let after = simd.add_f64s(alpha[k], linear_form(simd, line, self.end));
            let far = linear_form(simd, sizes, deviation);
            let near = simd.less_than_or_equal_f64s(simd.min_f64s(start, after), far);
            let bend = simd.mul_f64s(linear_form(simd, sizes, self.bounds), length);
            let slope = linear_form(simd, line, [self.from[1], self.a]);
            let rises = simd.greater_than_f64s(slope, bend);
            let falls = simd.less_than_f64s(slope, simd.neg_f64s(bend));
            let size = simd.add_f64s(simd.abs_f64s(alpha[k]), linear_form(simd, sizes, magnitudes));
            let noise = simd.mul_f64s(size, simd.splat_f64s(4.0 * f64::EPSILON));
            let inside = simd.greater_than_f64s(start, noise);
            let starts = simd.or_m64s(inside, simd.equal_f64s(start, zero));
            let clear = simd.or_m64s(simd.and_m64s(rises, starts), simd.and_m64s(falls, inside));
            all_clear &= none(simd, simd.and_m64s(near, simd.not_m64s(clear)));
            any_crossed |= !none(simd, simd.and_m64s(falls, simd.less_than_f64s(after, zero)));
        }
        Monotonicity { all_clear, any_crossed }
    }

    /// Writes the times at which the facets are crossed, if all are monotonic, and returns the first: the
    /// time as a cubic of the margin, from values and slopes at both ends. Its last bits hold the facet
    /// ([`LANE_BITS`]). Zero if a time is not within the step.
    #[inline(always)]
    fn expected_times<S: Simd>(
        &self,
        simd: S,
        facets: &FacetBlock,
        before: &[f64; LANES],
        times: &mut [f64; LANES],
    ) -> f64 {
        let a_end = self.acceleration(self.end, self.h);
        let (zero, length) = (simd.splat_f64s(0.0), simd.splat_f64s(self.h));
        let (one, three) = (simd.splat_f64s(1.0), simd.splat_f64s(3.0));
        let (never, keep) = (simd.splat_f64s(NEVER), simd.splat_u64s(!LANE_BITS));
        let (alpha, beta) = (S::as_simd_f64s(&facets.alpha).0, S::as_simd_f64s(&facets.beta).0);
        let (gamma, before) = (S::as_simd_f64s(&facets.gamma).0, S::as_simd_f64s(before).0);
        let numbers = S::as_simd_u64s(&LANE_NUMBERS).0;
        let (mut first, mut all_within) = (never, true);
        for k in 0..alpha.len() {
            let (start, line) = (before[k], [beta[k], gamma[k]]);
            let after = simd.add_f64s(alpha[k], linear_form(simd, line, self.end));
            let slope = linear_form(simd, line, [self.from[1], self.a]);
            let last_slope = linear_form(simd, line, [self.end[1], a_end]);
            let crossed =
                simd.and_m64s(simd.less_than_f64s(slope, zero), simd.less_than_f64s(after, zero));
            let drop = simd.sub_f64s(start, after);
            let u = simd.div_f64s(start, drop);
            let rest = simd.sub_f64s(one, u);
            let (tangent, last_tangent) =
                (simd.div_f64s(drop, slope), simd.div_f64s(drop, last_slope));
            let tangents =
                simd.sub_f64s(simd.mul_f64s(rest, tangent), simd.mul_f64s(u, last_tangent));
            let even = simd.mul_f64s(u, simd.sub_f64s(three, simd.add_f64s(u, u)));
            let time = simd.sub_f64s(simd.mul_f64s(even, length), simd.mul_f64s(rest, tangents));
            let time = simd.mul_f64s(u, time);
            let within = simd.and_m64s(
                simd.greater_than_f64s(time, zero),
                simd.less_than_or_equal_f64s(time, length),
            );
            all_within &= none(simd, simd.and_m64s(crossed, simd.not_m64s(within)));
            let time = simd.select_f64s(crossed, time, never);
            let time = tagged(simd, time, keep, numbers[k]);
            S::as_mut_simd_f64s(times).0[k] = time;
            first = simd.min_f64s(first, time);
        }
        if all_within { simd.reduce_min_f64s(first) } else { 0.0 }
    }

    /// The root of a margin `α + β x + γ ẋ` that falls throughout the step to a negative value, and the
    /// state there, from a first guess: Halley's method.
    #[inline(always)]
    fn root<const N: usize>(
        &self,
        series: &TaylorSeries<N>,
        [alpha, beta, gamma]: [f64; 3],
        mut t: f64,
    ) -> Option<(f64, [f64; 2])> {
        let (kappa, zeta) = (self.oscillator.kappa, self.oscillator.zeta);
        let curvature = beta.abs().mul_add(self.bounds[0], gamma.abs() * self.bounds[1]);
        for _ in 0..MAX_ROOT_STEPS {
            let [x, v] = series.at(t);
            let a = self.acceleration([x, v], t);
            let jerk = (-kappa).mul_add(v, (-zeta).mul_add(a, self.w[1]));
            let margin = gamma.mul_add(v, beta.mul_add(x, alpha));
            let inverse = 1.0 / beta.mul_add(v, gamma * a);
            let bend = beta.mul_add(a, gamma * jerk) * inverse;
            let newton = -margin * inverse;
            let dt = newton * (-0.5 * bend).mul_add(newton, 1.0);
            t += dt;
            if !(t > 0.0 && t <= self.h) {
                return None;
            }
            let change = curvature * inverse * dt;
            if change * change * dt.abs() <= ROOT_TOLERANCE * self.h {
                // A few terms of the Taylor series are enough for so small a change.
                let snap = (-kappa).mul_add(a, -zeta * jerk);
                let x = dt.mul_add(dt.mul_add(0.5 * dt.mul_add(jerk / 3.0, a), v), x);
                let v = dt.mul_add(dt.mul_add(0.5 * dt.mul_add(snap / 3.0, jerk), a), v);
                return Some((t, [x, v]));
            }
        }
        None
    }
}
