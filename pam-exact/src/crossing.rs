//! Where a step leaves its pattern: the time and state at which it crosses a side.

use crate::atlas::NONE;
use crate::event::Margin;
use crate::fundamental::{MEDIUM, SHORT};
use crate::lanes::{LANE_NUMBERS, along, none, tagged};
use crate::network::LANES;
use crate::series::{COEFFICIENTS, Series};
use crate::sides::Sides;
use crate::step::{Step, margins};
use pam_core::simd::arch;
use pulp::{Simd, WithSimd};

/// Where a step leaves its pattern.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Exit {
    pub(crate) after_s: f64,
    pub(crate) state: [f64; 2],
    /// The side that is crossed, and the unit whose border it is.
    pub(crate) block: usize,
    pub(crate) lane: usize,
    pub(crate) unit: u32,
}

/// What is known of all sides of a pattern at once.
enum Glance {
    /// No side is crossed.
    Stays,
    Leaves(Exit),
    /// Each side must be looked at.
    Unclear,
}

impl Exit {
    /// The first side that the motion crosses in a step. `entered` is the unit whose border was crossed
    /// just before.
    #[inline(always)]
    pub(crate) fn first<S: Simd>(
        simd: S,
        sides: &[Sides],
        step: &Step,
        entered: u32,
        on_border: bool,
    ) -> Option<Self> {
        if let ([sides], false) = (sides, on_border) {
            match step.glance(simd, sides, entered) {
                Glance::Stays => return None,
                Glance::Leaves(exit) => return Some(exit),
                Glance::Unclear => {}
            }
        }
        // A copy: the step that most crossings are found with can stay in registers.
        let step = *step;
        side_by_side(SideBySide { sides, step: &step, entered, on_border })
    }
}

/// A crossing's time is found to this part of the step, as estimated from the last correction. The field
/// is continuous across the border, so what the state loses by an error `δ` of the time is of the order
/// of `δ²`.
const ROOT_TOLERANCE: f64 = 1e-12;
/// Steps of Halley's method before a root is left to those that bracket it.
const ROOT_STEPS: usize = 6;
/// Stands for the time of a crossing where there is none, longer than any step.
const NEVER: f64 = 1e300;
/// Shorter than [`NEVER`] and longer than any step.
const EVER: f64 = 1e299;
/// The last bits of a time say which side it belongs to.
const LANE_BITS: u64 = LANES as u64 - 1;

impl Step {
    /// Looks at all sides of a pattern at once. The first crossing is the one of those expected at which
    /// none of the others is negative yet.
    #[inline(always)]
    fn glance<S: Simd>(&self, simd: S, sides: &Sides, entered: u32) -> Glance {
        let mut before = margins(sides, self.from);
        if entered != NONE {
            // The tables of two patterns agree on their common border to rounding only.
            for (before, unit) in before.iter_mut().zip(&sides.unit) {
                *before = if *unit == entered { 0.0 } else { *before };
            }
        }
        let (all_clear, any) = self.crosses_any(simd, sides, &before);
        if !all_clear {
            return Glance::Unclear;
        }
        if !any {
            return Glance::Stays;
        }
        let mut times = [NEVER; LANES];
        let first = self.expected_times(simd, sides, &before, &mut times);
        if first <= 0.0 {
            return Glance::Unclear;
        }
        let lane = (first.to_bits() & LANE_BITS) as usize;
        let line = [sides.alpha[lane], sides.beta[lane], sides.gamma[lane]];
        let root = match self.terms {
            SHORT => self.root(&Series::<{ SHORT - 3 }>::new(self), line, first),
            MEDIUM => self.root(&Series::<{ MEDIUM - 3 }>::new(self), line, first),
            _ => self.root(&Series::<COEFFICIENTS>::new(self), line, first),
        };
        let Some((after_s, state)) = root else { return Glance::Unclear };
        let there = margins(sides, state);
        let mut earlier = false;
        for (i, (margin, time)) in there.iter().zip(&times).enumerate() {
            earlier |= (*margin < 0.0) & (*time < EVER) & (i != lane);
        }
        if earlier {
            return Glance::Unclear;
        }
        Glance::Leaves(Exit { after_s, state, block: 0, lane, unit: sides.unit[lane] })
    }

    /// Whether all sides are clear, and if so whether any is crossed. Clear are those whose margin, by a
    /// bound of its curvature, stays positive, falls throughout the step or rises throughout.
    #[inline(always)]
    fn crosses_any<S: Simd>(&self, simd: S, sides: &Sides, before: &[f64; LANES]) -> (bool, bool) {
        let (off, size_of_state) = (self.off_chord(), self.size_of_state());
        let (zero, length) = (simd.splat_f64s(0.0), simd.splat_f64s(self.h));
        let (alpha, beta) = (S::as_simd_f64s(&sides.alpha).0, S::as_simd_f64s(&sides.beta).0);
        let (gamma, before) = (S::as_simd_f64s(&sides.gamma).0, S::as_simd_f64s(before).0);
        let (mut all_clear, mut any) = (true, false);
        for k in 0..alpha.len() {
            let (start, line) = (before[k], (beta[k], gamma[k]));
            let sizes = (simd.abs_f64s(beta[k]), simd.abs_f64s(gamma[k]));
            let after = simd.add_f64s(alpha[k], along(simd, line, self.end));
            let far = along(simd, sizes, off);
            let near = simd.less_than_or_equal_f64s(simd.min_f64s(start, after), far);
            let bend = simd.mul_f64s(along(simd, sizes, self.most), length);
            let slope = along(simd, line, [self.from[1], self.a]);
            let rises = simd.greater_than_f64s(slope, bend);
            let falls = simd.less_than_f64s(slope, simd.neg_f64s(bend));
            let size = simd.add_f64s(simd.abs_f64s(alpha[k]), along(simd, sizes, size_of_state));
            let noise = simd.mul_f64s(size, simd.splat_f64s(4.0 * f64::EPSILON));
            let inside = simd.greater_than_f64s(start, noise);
            let starts = simd.or_m64s(inside, simd.equal_f64s(start, zero));
            let clear = simd.or_m64s(simd.and_m64s(rises, starts), simd.and_m64s(falls, inside));
            all_clear &= none(simd, simd.and_m64s(near, simd.not_m64s(clear)));
            any |= !none(simd, simd.and_m64s(falls, simd.less_than_f64s(after, zero)));
        }
        (all_clear, any)
    }

    /// Writes when the sides are crossed, if [`crosses_any`](Self::crosses_any), and returns the first of
    /// these times: the time as a cubic of the margin, from values and slopes at both ends. Its last bits
    /// say which side it is ([`LANE_BITS`]). Zero if a time is not within the step.
    #[inline(always)]
    fn expected_times<S: Simd>(
        &self,
        simd: S,
        sides: &Sides,
        before: &[f64; LANES],
        times: &mut [f64; LANES],
    ) -> f64 {
        let a_end = self.acceleration(self.end, self.h);
        let (zero, length) = (simd.splat_f64s(0.0), simd.splat_f64s(self.h));
        let (one, three) = (simd.splat_f64s(1.0), simd.splat_f64s(3.0));
        let (never, keep) = (simd.splat_f64s(NEVER), simd.splat_u64s(!LANE_BITS));
        let (alpha, beta) = (S::as_simd_f64s(&sides.alpha).0, S::as_simd_f64s(&sides.beta).0);
        let (gamma, before) = (S::as_simd_f64s(&sides.gamma).0, S::as_simd_f64s(before).0);
        let numbers = S::as_simd_u64s(&LANE_NUMBERS).0;
        let (mut first, mut all_within) = (never, true);
        for k in 0..alpha.len() {
            let (start, line) = (before[k], (beta[k], gamma[k]));
            let after = simd.add_f64s(alpha[k], along(simd, line, self.end));
            let slope = along(simd, line, [self.from[1], self.a]);
            let last_slope = along(simd, line, [self.end[1], a_end]);
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
        series: &Series<N>,
        [alpha, beta, gamma]: [f64; 3],
        mut t: f64,
    ) -> Option<(f64, [f64; 2])> {
        let curvature = beta.abs().mul_add(self.most[0], gamma.abs() * self.most[1]);
        for _ in 0..ROOT_STEPS {
            let [x, v] = series.at(t);
            let a = self.acceleration([x, v], t);
            let jerk = (-self.kappa).mul_add(v, (-self.zeta).mul_add(a, self.w[1]));
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
                // A few terms of Taylor's series are enough for so small a change.
                let snap = (-self.kappa).mul_add(a, -self.zeta * jerk);
                let x = dt.mul_add(dt.mul_add(0.5 * dt.mul_add(jerk / 3.0, a), v), x);
                let v = dt.mul_add(dt.mul_add(0.5 * dt.mul_add(snap / 3.0, jerk), a), v);
                return Some((t, [x, v]));
            }
        }
        None
    }
}

/// A step whose sides are looked at one by one.
struct SideBySide<'a> {
    sides: &'a [Sides],
    step: &'a Step,
    entered: u32,
    on_border: bool,
}

#[cold]
#[inline(never)]
fn side_by_side(job: SideBySide<'_>) -> Option<Exit> {
    arch().dispatch(job)
}

impl WithSimd for SideBySide<'_> {
    type Output = Option<Exit>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Option<Exit> {
        let Self { sides, step, entered, on_border } = self;
        let off = step.off_chord();
        let series = Series::<COEFFICIENTS>::new(step);
        let mut found: Option<Exit> = None;
        for (block, sides) in sides.iter().enumerate() {
            let before = margins(sides, step.from);
            let after = margins(sides, step.end);
            for lane in 0..LANES {
                let line = [sides.alpha[lane], sides.beta[lane], sides.gamma[lane]];
                let far = line[1].abs().mul_add(off[0], line[2].abs() * off[1]);
                if before[lane].min(after[lane]) > far {
                    continue;
                }
                let mut margin = Margin::new(line, &series, step.size_of_state());
                // The tables of two patterns agree on their common border to rounding only.
                if sides.unit[lane] == entered {
                    margin.start_at_zero();
                }
                if on_border && before[lane] <= 64.0 * margin.noise() {
                    continue;
                }
                let limit = found.as_ref().map_or(step.h, |f| f.after_s);
                let Some(after_s) = margin.first_exit(limit) else { continue };
                if after_s < limit || found.is_none() {
                    let (state, unit) = (series.at(after_s), sides.unit[lane]);
                    found = Some(Exit { after_s, state, block, lane, unit });
                    if after_s == 0.0 {
                        return found;
                    }
                }
            }
        }
        found
    }
}
