//! Where a step leaves its pattern: the time and state at which it crosses a side.

use crate::event::{COEFFICIENTS, Margin};
use crate::fundamental::Response;
use crate::motion::Law;
use pam_core::simd::arch;
use pulp::{Simd, WithSimd};

/// A step whose crossings are looked for.
pub(crate) struct Step<'a> {
    pub(crate) law: &'a Law,
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

/// A side that the motion may cross.
pub(crate) struct Line {
    pub(crate) alpha: f64,
    pub(crate) beta: f64,
    pub(crate) gamma: f64,
    /// Margins at both ends of the step.
    pub(crate) before: f64,
    pub(crate) after: f64,
    /// Whether the motion comes from it.
    pub(crate) entered: bool,
}

/// A crossing's time is found to this part of the step. The field is continuous across the border, so
/// what the state loses by an error `δ` of the time is of the order of `δ²`.
const ROOT_TOLERANCE: f64 = 1e-13;
/// Newton steps before the root is bracketed.
const NEWTON_STEPS: usize = 6;

impl Step<'_> {
    /// Time and state of the first exit across a line up to `limit`.
    ///
    /// A margin that falls throughout the step, by a bound of its curvature, has its root found by
    /// Newton's method on the motion itself; one that rises throughout has none. Any other goes the
    /// long way.
    #[inline(always)]
    pub(crate) fn exit(&self, line: &Line, limit: f64, on_border: bool) -> Option<(f64, [f64; 2])> {
        let [x, v] = self.from;
        let curvature = line.beta.abs().mul_add(self.most[0], line.gamma.abs() * self.most[1]);
        let slope = line.beta.mul_add(v, line.gamma * self.a);
        let noise = 4.0
            * f64::EPSILON
            * (line.alpha.abs() + (line.beta * x).abs() + (line.gamma * v).abs());
        // The tables of two patterns agree on their common border to rounding only.
        let start = if line.entered { 0.0 } else { line.before };
        if start > noise || (line.entered && slope > 0.0) {
            if slope > curvature * self.h {
                return None;
            }
            if slope < -curvature * self.h {
                if line.after >= 0.0 {
                    return None;
                }
                if let Some(root) = self.root(line, start, slope, curvature) {
                    return (root.0 <= limit).then_some(root);
                }
            }
        }
        self.long_way(line, limit, on_border)
    }

    /// The root of a margin that falls throughout the step to a negative value.
    #[inline(always)]
    fn root(&self, line: &Line, start: f64, slope: f64, curvature: f64) -> Option<(f64, [f64; 2])> {
        let law = self.law;
        let [x, v] = self.from;
        let terms = law.terms_of(self.h);
        let jerk = (-law.kappa).mul_add(v, (-law.zeta).mul_add(self.a, self.w[1]));
        let bend = line.beta.mul_add(self.a, line.gamma * jerk);
        let square = slope.mul_add(slope, -2.0 * bend * start);
        let mut t = 2.0 * start / (square.max(0.0).sqrt() - slope);
        for _ in 0..NEWTON_STEPS {
            if !(t >= 0.0 && t <= self.h) {
                return None;
            }
            let response = Response::new(law.kappa, law.zeta, t, terms);
            let [xt, vt] = response.advance(law.kappa, t, [x, v], self.a, self.w[1]);
            let at = law.acceleration([xt, vt], self.w[1].mul_add(t, self.w[0]));
            let margin = line.gamma.mul_add(vt, line.beta.mul_add(xt, line.alpha));
            let slope = line.beta.mul_add(vt, line.gamma * at);
            let dt = -margin / slope;
            t += dt;
            if curvature * dt * dt <= ROOT_TOLERANCE * self.h * slope.abs() {
                // Two terms of Taylor's series are enough for so small a change.
                let jerk = (-law.kappa).mul_add(vt, (-law.zeta).mul_add(at, self.w[1]));
                let state =
                    [dt.mul_add(vt + 0.5 * dt * at, xt), dt.mul_add(at + 0.5 * dt * jerk, vt)];
                return (t > 0.0 && t <= self.h).then_some((t, state));
            }
        }
        None
    }

    /// The exit of a margin that may turn within the step.
    #[cold]
    #[inline(never)]
    fn long_way(&self, line: &Line, limit: f64, on_border: bool) -> Option<(f64, [f64; 2])> {
        arch().dispatch(LongWay { step: self, line, limit, on_border })
    }
}

struct LongWay<'a, 's> {
    step: &'a Step<'s>,
    line: &'a Line,
    limit: f64,
    on_border: bool,
}

impl WithSimd for LongWay<'_, '_> {
    type Output = Option<(f64, [f64; 2])>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Option<(f64, [f64; 2])> {
        let Self { step, line, limit, on_border } = self;
        let len = step.law.terms_of(step.h).min(COEFFICIENTS);
        let series = Series::new(step.law, step.from, step.a, step.w[1], len);
        let mut margin = Margin::new([line.alpha, line.beta, line.gamma], &series.d, series.len);
        if line.entered {
            margin.start_at_zero();
        }
        if on_border && line.before <= 64.0 * margin.noise() {
            return None;
        }
        margin.first_exit(limit).map(|t| (t, series.at(t)))
    }
}

/// The displacement as a power series in the time from the start of a step.
struct Series {
    /// Derivatives over factorials; one more than `len`.
    d: [f64; COEFFICIENTS + 1],
    len: usize,
}

impl Series {
    #[inline(always)]
    fn new(law: &Law, [x, v]: [f64; 2], a: f64, rate: f64, len: usize) -> Self {
        let (kappa, zeta) = (law.kappa, law.zeta);
        let mut d = [0.0; COEFFICIENTS + 1];
        let (mut two_before, mut before) = (a, rate - kappa * v - zeta * a);
        d[0] = x;
        d[1] = v;
        d[2] = 0.5 * a;
        d[3] = INVERSE_FACTORIAL[3] * before;
        for n in 4..=len {
            (two_before, before) = (before, (-zeta).mul_add(before, -kappa * two_before));
            d[n] = INVERSE_FACTORIAL[n] * before;
        }
        Self { d, len }
    }

    /// Displacement and velocity after `t`.
    #[inline(always)]
    fn at(&self, t: f64) -> [f64; 2] {
        let (mut x, mut v) = (0.0_f64, 0.0_f64);
        for &d in self.d[..=self.len].iter().rev() {
            v = v.mul_add(t, x);
            x = x.mul_add(t, d);
        }
        [x, v]
    }
}

/// `1 / n!`.
const INVERSE_FACTORIAL: [f64; COEFFICIENTS + 1] = {
    let mut inverse = [1.0; COEFFICIENTS + 1];
    let mut n = 1;
    while n < inverse.len() {
        inverse[n] = inverse[n - 1] / n as f64;
        n += 1;
    }
    inverse
};
