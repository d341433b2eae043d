//! Dry friction in a step: sliding, turning, sticking, breaking away.
//!
//! Friction is the set-valued force `−L(x, v) Sgn(v)` with the limit L of all dry frictions, so the joint is a system of
//! Filippov: smooth while it slides one way, at rest while the other forces stay within ±L, and switched where the
//! velocity passes zero. Every smooth piece is integrated to fourth order and steps are cut at the switches, which
//! keeps that order (Acary and Brogliato 2008, chapter 7).
//!
//! **Derivatives.** The time t* at which the joint turns depends on everything before. With an acceleration a₁ before
//! and a₂ after, a deviation δv at the turn moves it by −δv/a₁ and leaves `δv a₂/a₁` behind (the saltation
//! of a discontinuous field, Leine and Nijmeijer 2004); a joint that comes to rest forgets δv. Times of
//! breaking away leave no trace in first order: the acceleration there begins at zero.

use super::base::BaseForce;
use super::integrator::{At, JointIntegrator, Substep};
use crate::effects::EffectScalar;

/// Switches in one substep; a joint that switches more often in it rests until its end.
const MOST_SWITCHES: usize = 8;
/// Share of a step below which nothing is left of it.
const NOTHING: f64 = 1e-9;

impl<S: EffectScalar, F: BaseForce<S>> JointIntegrator<'_, S, F> {
    /// Displacement and velocity at the end of a substep with dry friction.
    pub(super) fn slide_and_stick(
        &self,
        air: &F::Sealed<'_>,
        step: &Substep<S>,
        from: At<S>,
    ) -> [S; 2] {
        let mut at = from;
        let mut direction = sign(at.v);
        for _ in 0..MOST_SWITCHES {
            if step.to - at.share < NOTHING {
                return [at.x, at.v];
            }
            if direction == 0.0 {
                let Some((share, way)) = self.breaks_away(air, step, at) else {
                    return [at.x, S::zero()];
                };
                if share > at.share {
                    (at.share, at.v) = (share, S::zero());
                }
                direction = way;
            }
            let (rate, end) = self.slide(air, step, at, step.to, direction);
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
        let left_s = (step.to - at.share) * step.grid_s;
        // First by the parabola through velocity and acceleration at the start and velocity at the end, then
        // by Newton's method on the step itself. Its number of iterations is fixed: a reverse sweep repeats
        // the steps and must not take another way by rounding.
        let [rate, last] = ahead.map(|v| v.real() * direction);
        let first = at.v.real() * direction;
        let (slope, bend) = (rate * left_s, last - first - rate * left_s);
        let root = (slope * slope - 4.0 * bend * first).max(0.0).sqrt();
        let part = (2.0 * first / (root - slope)).clamp(0.0, 1.0);
        let share = |part: f64| at.share + part * (step.to - at.share);
        let guess = share(part);
        let [x, v] = self.slide(air, step, at, guess, direction).1;
        let slowing = self.acceleration(air, step, At { share: guess, x, v }, direction).real();
        let shift = -v.real() / (slowing * left_s);
        let turn = share(if shift.is_finite() { (part + shift).clamp(0.0, 1.0) } else { part });
        let [x, v] = self.slide(air, step, at, turn, direction).1;

        let rest = At { share: turn, x, v: S::zero() };
        let (pull, limit) =
            (self.pull_mn(air, step, rest).real(), self.friction_limit_mn(x, S::zero()).real());
        if pull * direction >= -limit {
            return (rest, 0.0);
        }
        // What the joint carries through the turn is a deviation alone.
        let deviation = v - S::constant(v.real());
        let carried = (pull + direction * limit) / (pull - direction * limit);
        (At { v: deviation.scaled(carried), ..rest }, -direction)
    }

    /// Where in the step a joint at rest starts to move, and its direction: the force between three instants runs
    /// straight.
    fn breaks_away(&self, air: &F::Sealed<'_>, step: &Substep<S>, at: At<S>) -> Option<(f64, f64)> {
        let limit = self.friction_limit_mn(at.x, S::zero()).real();
        let pull = |share: f64| {
            self.pull_mn(air, step, At { share, x: at.x, v: S::zero() }).real()
        };
        let mut before = (at.share, pull(at.share));
        if before.1.abs() > limit {
            return Some((at.share, before.1.signum()));
        }
        for share in [0.5 * (at.share + step.to), step.to] {
            let after = (share, pull(share));
            if after.1.abs() > limit {
                let way = after.1.signum();
                let part = (limit - way * before.1) / (way * (after.1 - before.1));
                return Some((before.0 + part * (after.0 - before.0), way));
            }
            before = after;
        }
        None
    }
}

fn sign<S: EffectScalar>(v: S) -> f64 {
    let v = v.real();
    if v == 0.0 { 0.0 } else { v.signum() }
}
