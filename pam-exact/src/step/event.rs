//! The first zero crossing of one facet's margin along the motion.

use super::propagator::LONGEST;
use super::taylor::TaylorSeries;

/// The margin of a facet as an event function `g(τ) = Σ cₙ τⁿ` over a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct EventFunction {
    c: [f64; LONGEST],
    /// Rounding of the value.
    noise: f64,
}

/// A part of a step with the values at its ends.
#[derive(Debug, Clone, Copy, Default)]
struct Interval {
    a: f64,
    b: f64,
    at_a: f64,
    at_b: f64,
}

/// Most intervals that a search examines; a margin that turns a few times takes a hundred.
const MAX_EXAMINED: usize = 10_000;

/// Largest number of parts that wait to be examined.
const MAX_INTERVALS: usize = 64;

impl EventFunction {
    /// The margin `α + β x(τ) + γ ẋ(τ)` of a motion whose states are rounded relative to `magnitudes`.
    #[inline(always)]
    pub(crate) fn new(
        [alpha, beta, gamma]: [f64; 3],
        motion: &TaylorSeries<LONGEST>,
        magnitudes: [f64; 2],
    ) -> Self {
        let mut c = [0.0; LONGEST];
        for (n, c) in c.iter_mut().enumerate() {
            *c = beta * motion.x[n] + gamma * motion.v[n];
        }
        c[0] += alpha;
        let size = alpha.abs() + beta.abs() * magnitudes[0] + gamma.abs() * magnitudes[1];
        Self { c, noise: 4.0 * f64::EPSILON * size }
    }

    /// The rounding error that the value at the start may have.
    pub(crate) fn noise(&self) -> f64 {
        self.noise
    }

    #[inline(always)]
    fn value(&self, t: f64) -> f64 {
        self.c.iter().rev().fold(0.0, |sum: f64, c| sum.mul_add(t, *c))
    }

    #[inline(always)]
    fn value_and_slope(&self, t: f64) -> (f64, f64) {
        let (mut value, mut slope) = (0.0_f64, 0.0_f64);
        for c in self.c.iter().rev() {
            slope = slope.mul_add(t, value);
            value = value.mul_add(t, *c);
        }
        (value, slope)
    }

    /// Makes the motion start exactly on the facet.
    pub(crate) fn start_at_zero(&mut self) {
        self.c[0] = 0.0;
    }

    /// A bound of `|g̈|` over `[0, end]`.
    #[inline(always)]
    fn curvature(&self, end: f64) -> f64 {
        let (mut sum, mut power) = (0.0, 1.0);
        for n in 2..LONGEST {
            sum += (n * (n - 1)) as f64 * self.c[n].abs() * power;
            power *= end;
        }
        sum
    }

    /// The first time in `(0, end]` from which on the margin is negative, if there is one. A margin that
    /// starts at zero, to rounding, and rises counts as positive; one that starts at zero or below and
    /// falls leaves at time zero.
    ///
    /// No crossing is missed: a part of the step is dropped only if the values at its ends and the bound of
    /// the curvature prove that the margin stays positive in between, or that it is monotonic. Excursions
    /// below rounding are touches, not crossings.
    #[inline(always)]
    pub(crate) fn first_exit(&self, end: f64) -> Option<f64> {
        let curvature = self.curvature(end);
        if !(curvature.is_finite() && self.c[0].is_finite() && self.c[1].is_finite()) {
            // Nothing can be bounded; the state at the end of the step is not finite either, and ends the solve.
            return None;
        }
        let start = self.c[0];
        if start < -self.noise || (start <= self.noise && self.c[1] < 0.0) {
            return Some(0.0);
        }
        let least = self.c[1] - curvature * end;
        if least > 0.0 {
            return None; // rises throughout
        }
        let last = self.value(end);
        let whole = Interval { a: 0.0, b: end, at_a: start.max(0.0), at_b: last };
        if self.c[1] + curvature * end < 0.0 {
            // Falls throughout.
            return (last < 0.0).then(|| self.root(whole));
        }
        self.search(whole, curvature)
    }

    /// The first exit of a margin that may turn within the step, by bisection.
    #[inline(always)]
    fn search(&self, whole: Interval, curvature: f64) -> Option<f64> {
        let mut waiting = [Interval::default(); MAX_INTERVALS];
        let mut count = 1;
        waiting[0] = whole;
        let mut examined = 0;
        while count > 0 {
            count -= 1;
            examined += 1;
            if examined > MAX_EXAMINED {
                // Rounding hides where the margin turns: what counts is that it ends below zero, or not.
                return (whole.at_b < 0.0).then(|| self.root(whole));
            }
            let part = waiting[count];
            let Interval { a, b, at_a, at_b } = part;
            let width = b - a;
            // A smaller excursion below zero is a touch.
            if at_a.min(at_b) - 0.125 * curvature * width * width >= -self.noise {
                continue;
            }
            let (_, slope) = self.value_and_slope(a + 0.5 * width);
            let spread = 0.5 * curvature * width;
            if slope > spread {
                // Rises: negative only if it already was at the start of the part.
                continue;
            }
            if slope < -spread {
                if at_b < 0.0 {
                    return Some(self.root(part));
                }
                continue;
            }
            if width <= 1e-9 * whole.b || count + 2 > MAX_INTERVALS {
                if at_b < -self.noise {
                    return Some(b);
                }
                continue;
            }
            let middle = a + 0.5 * width;
            let at_middle = self.value(middle);
            if at_middle >= -self.noise {
                waiting[count] = Interval { a: middle, at_a: at_middle, ..part };
                count += 1;
            }
            waiting[count] = Interval { b: middle, at_b: at_middle, ..part };
            count += 1;
        }
        None
    }

    /// The root in an interval where the margin falls from `at_a ≥ 0` to `at_b < 0` monotonically: Newton's
    /// method within the bracket.
    #[inline(always)]
    fn root(&self, Interval { mut a, mut b, at_a, at_b }: Interval) -> f64 {
        let mut t = a + (b - a) * (at_a / (at_a - at_b));
        if a == 0.0 {
            // At the start of a step the parabola is a better guess than the chord.
            let (c1, c2) = (self.c[1], self.c[2]);
            let root = c1 * c1 - 4.0 * c2 * self.c[0];
            let guess = 2.0 * self.c[0] / (root.max(0.0).sqrt() - c1);
            if guess > a && guess < b {
                t = guess;
            }
        }
        for _ in 0..60 {
            let (g, slope) = self.value_and_slope(t);
            if g >= 0.0 {
                a = t;
            } else {
                b = t;
            }
            let mut next = t - g / slope;
            if !(next > a && next < b) {
                if (next - t).abs() <= 4.0 * f64::EPSILON * t {
                    return t;
                }
                next = 0.5 * (a + b);
            }
            if (next - t).abs() <= 4.0 * f64::EPSILON * t || g.abs() <= 0.25 * self.noise {
                return next;
            }
            t = next;
        }
        t
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn margin(c: &[f64]) -> EventFunction {
        let mut all = [0.0; LONGEST];
        all[..c.len()].copy_from_slice(c);
        EventFunction { c: all, noise: 1e-15 }
    }

    #[test]
    fn simple_and_double_crossings_are_found() {
        let simple = margin(&[1.0, -4.0]);
        assert!((simple.first_exit(1.0).unwrap() - 0.25).abs() < 1e-15);
        // Out and back within the step, both ends positive: (t − 0.4)(t − 0.40001).
        let double = margin(&[0.4 * 0.40001, -0.80001, 1.0]);
        assert!((double.first_exit(1.0).unwrap() - 0.4).abs() < 1e-9);
        assert_eq!(double.first_exit(0.3), None);
        // Three roots: the first counts.
        let triple = margin(&[0.1 * 0.5 * 0.9, -(0.05 + 0.09 + 0.45), 1.5, -1.0]);
        assert!((triple.first_exit(1.0).unwrap() - 0.1).abs() < 1e-14);
    }

    /// A motion that rests on the border, without rounding.
    #[test]
    fn a_margin_that_stays_zero_is_no_crossing() {
        let mut rest = margin(&[0.0, 0.0]);
        rest.noise = 0.0;
        assert_eq!(rest.first_exit(1.0), None);
    }

    /// Coefficients of a model that is none: no bound holds, and no bisection may go on for ever.
    #[test]
    fn coefficients_beyond_rounding_end() {
        for big in [1e300, f64::MAX, f64::INFINITY, f64::NAN] {
            for c in [[1.0, -big, big, -big], [big, -1.0, -big, big], [0.0, big, -big, 1.0]] {
                let _ = margin(&c).first_exit(0.5);
                let _ = margin(&c).first_exit(1e-3);
            }
        }
    }

    #[test]
    fn touches_and_returns_are_no_crossings() {
        assert_eq!(margin(&[0.25, -1.0, 1.0]).first_exit(1.0), None, "touches at 0.5");
        assert_eq!(margin(&[0.0, 2.0, 1.0]).first_exit(1.0), None, "leaves the border inwards");
        assert_eq!(margin(&[1e-17, -2.0]).first_exit(1.0), Some(0.0), "outwards at once");
        let back = margin(&[0.0, 1.0, -4.0]).first_exit(1.0).unwrap();
        assert!((back - 0.25).abs() < 1e-12, "comes back to the border it started from: {back}");
    }
}
