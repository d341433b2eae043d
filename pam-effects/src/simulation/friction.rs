//! Dry friction in a step: sliding, turning, sticking, breaking away.
//!
//! Friction is the set-valued force `−L(x, v) Sgn(v)` with the limit L of all dry frictions, so the joint is a system of
//! Filippov: smooth while it slides one way, at rest while the other forces stay within ±L, and switched where the
//! velocity passes zero. Every smooth piece is integrated to fourth order and steps are cut at the switches, which
//! keeps that order (Acary and Brogliato 2008, chapter 7).
//!
//! **Derivatives.** The instants at which the joint turns or breaks away depend on everything before and carry derivatives,
//! which the lengths of the pieces inherit. What Newton's method leaves of the velocity at a turn is small and
//! carried on as the deviation that it is: by the ratio `a₂/a₁` of the accelerations after and before (the saltation of
//! a discontinuous field, Leine and Nijmeijer 2004).

use super::base::BaseForce;
use super::integrator::JointIntegrator;
use super::substep::{At, Substep};
use crate::effects::EffectScalar;

/// Switches in one substep; a joint that switches more often in it rests until its end.
const MOST_SWITCHES: usize = 8;
/// Iterations of Newton's method for the time of a turn. The parabola is mostly right to 1e-3 of a step, and every iteration adds as many
/// digits; where the joint speeds up before it turns, the first ones halve the interval.
const ITERATIONS: usize = 6;
/// Share of a step below which nothing is left of it.
const NOTHING: f64 = 1e-9;

impl<S: EffectScalar, F: BaseForce<S>> JointIntegrator<'_, S, F> {
    /// Displacement and velocity at the end of a substep with dry friction.
    #[inline(always)]
    pub(super) fn slide_and_stick(
        &self,
        air: &F::Sealed<'_>,
        step: &Substep<S>,
        from: At<S>,
    ) -> [S; 2] {
        let mut at = from;
        let mut direction = sign(at.v);
        for _ in 0..MOST_SWITCHES {
            if step.to - at.share.real() < NOTHING {
                return [at.x, at.v];
            }
            if direction == 0.0 {
                let Some((share, way)) = self.breaks_away(air, step, at) else {
                    return [at.x, S::zero()];
                };
                if share.real() > at.share.real() {
                    (at.share, at.v) = (share, S::zero());
                }
                direction = way;
            }
            let (rate, end) = if at.share.real() == step.from {
                self.slide(air, step, direction)
            } else {
                let to = S::constant(step.to);
                (
                    self.acceleration(air, step, &at, direction),
                    self.piece(air, step, at, to, direction),
                )
            };
            if end[1].real() * direction > 0.0 {
                return end;
            }
            if at.v.real() * direction <= 0.0 {
                // It cannot leave its place this way.
                return [at.x, S::zero()];
            }
            (at, direction) = self.turned(air, step, at, [rate, end[1]], direction);
        }
        [at.x, S::zero()]
    }

    /// The joint where its velocity is zero, and the direction in which it goes on; 0 if it stays. `ahead` is
    /// the acceleration at `at` and the velocity at the end of the step if it went on sliding.
    fn turned(
        &self,
        air: &F::Sealed<'_>,
        step: &Substep<S>,
        at: At<S>,
        ahead: [S; 2],
        direction: f64,
    ) -> (At<S>, f64) {
        // First by the parabola through velocity and acceleration at the start and velocity at the end, then
        // by Newton's method on the step itself. Its number of iterations is fixed: a reverse sweep repeats
        // the steps and must not take another way by rounding.
        let left = step.to - at.share.real();
        let [rate, last] = ahead.map(|v| v.real() * direction);
        let first = at.v.real() * direction;
        let slope = rate * left * step.grid_s;
        let bend = last - first - slope;
        let root = (slope * slope - 4.0 * bend * first).max(0.0).sqrt();
        let part = (2.0 * first / (root - slope)).clamp(0.0, 1.0);
        let [earliest, latest] = [at.share.real(), step.to].map(S::constant);
        let mut share = S::constant(at.share.real() + part * left);
        let place = |share: S| {
            let [x, v] = self.piece(air, step, at, share, direction);
            At { share, x, v }
        };
        let mut there = place(share);
        // It still slides at the first of these, and has turned at the second one.
        let mut between = [at.share.real(), step.to];
        for _ in 0..ITERATIONS {
            let slowing = self.acceleration(air, step, &there, direction);
            let has_turned = there.v.real() * direction <= 0.0;
            between[usize::from(has_turned)] = share.real();
            let next = share - there.v / slowing.scaled(step.grid_s);
            let is_between = (between[0] - NOTHING..=between[1] + NOTHING).contains(&next.real());
            share = if is_between && slowing.real() * direction < 0.0 {
                next.clamped(earliest, latest)
            } else {
                S::constant(0.5 * (between[0] + between[1]))
            };
            there = place(share);
        }

        let rest = At { v: S::zero(), ..there };
        let pull = self.pull_mn(air, step, &rest).real();
        let limit = self.friction_limit_mn(air, step, &rest).real();
        if pull * direction >= -limit {
            return (rest, 0.0);
        }
        let deviation = there.v - S::constant(there.v.real());
        let carried = (pull + direction * limit) / (pull - direction * limit);
        (At { v: deviation.scaled(carried), ..rest }, -direction)
    }

    /// A Runge–Kutta step of fourth order of any length, with its derivatives.
    fn piece(
        &self,
        air: &F::Sealed<'_>,
        step: &Substep<S>,
        at: At<S>,
        to: S,
        direction: f64,
    ) -> [S; 2] {
        let h = (to - at.share).scaled(step.grid_s);
        let middle = (at.share + to).scaled(0.5);
        let rate = |share: S, x: S, v: S| {
            (v, self.acceleration(air, step, &At { share, x, v }, direction))
        };
        let along = |(v, a): (S, S), h: S| (at.x + v * h, at.v + a * h);
        let k1 = rate(at.share, at.x, at.v);
        let (x, v) = along(k1, h.scaled(0.5));
        let k2 = rate(middle, x, v);
        let (x, v) = along(k2, h.scaled(0.5));
        let k3 = rate(middle, x, v);
        let (x, v) = along(k3, h);
        let k4 = rate(to, x, v);
        let sum = |a: S, b: S, c: S, d: S| (a + (b + c).scaled(2.0) + d).scaled(1.0 / 6.0);
        let (x, v) = along((sum(k1.0, k2.0, k3.0, k4.0), sum(k1.1, k2.1, k3.1, k4.1)), h);
        [x, v]
    }

    /// Where in the step a joint at rest starts to move, and its direction, by the parabola through the force at three
    /// instants.
    fn breaks_away(&self, air: &F::Sealed<'_>, step: &Substep<S>, at: At<S>) -> Option<(S, f64)> {
        let limit = self.friction_limit_mn(air, step, &At { v: S::zero(), ..at });
        let pull = |share: S| self.pull_mn(air, step, &At { share, x: at.x, v: S::zero() });
        let exceeds = |pull: S| pull.real().abs() > limit.real();
        let (left, start) = (S::constant(step.to) - at.share, pull(at.share));
        if exceeds(start) {
            return Some((at.share, start.real().signum()));
        }
        let [middle, end] = [0.5, 1.0].map(|part| pull(at.share + left.scaled(part)));
        let passed = [middle, end].into_iter().find(|&p| exceeds(p))?;
        let way = passed.real().signum();
        // way · pull − limit over the share of what is left.
        let [start, middle, end] = [start, middle, end].map(|p| p.scaled(way) - limit);
        let slope = middle.scaled(4.0) - start.scaled(3.0) - end;
        let bend = (start + end - middle.scaled(2.0)).scaled(2.0);
        let (a, b, c) = (bend.real(), slope.real(), start.real());
        let part = -2.0 * c / (b + (b * b - 4.0 * a * c).max(0.0).sqrt());
        let part = if part.is_finite() { part.clamp(0.0, 1.0) } else { 0.0 };
        // One step of Newton's method gives the root its derivatives.
        let miss = start + slope.scaled(part) + bend.scaled(part * part);
        let rising = (b + 2.0 * a * part).max(f64::MIN_POSITIVE);
        let deviation = miss - S::constant(miss.real());
        let part = S::constant(part) - deviation.scaled(1.0 / rising);
        Some((at.share + left * part, way))
    }
}

fn sign<S: EffectScalar>(v: S) -> f64 {
    let v = v.real();
    if v == 0.0 { 0.0 } else { v.signum() }
}
