//! The first time at which a margin becomes negative.

use crate::series::{COEFFICIENTS, Series};

/// A margin `g(τ) = Σ cₙ τⁿ` over a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Margin {
    c: [f64; COEFFICIENTS],
    /// Rounding of the value.
    noise: f64,
}

/// Parts of a step that wait to be looked at.
const DEPTH: usize = 64;

impl Margin {
    /// The margin `α + β x(τ) + γ ẋ(τ)` of a motion whose states are rounded relative to `size`.
    #[inline(always)]
    pub(crate) fn new(
        [alpha, beta, gamma]: [f64; 3],
        motion: &Series<COEFFICIENTS>,
        size: [f64; 2],
    ) -> Self {
        let mut c = [0.0; COEFFICIENTS];
        for (n, c) in c.iter_mut().enumerate() {
            *c = beta * motion.x[n] + gamma * motion.v[n];
        }
        c[0] += alpha;
        let size = alpha.abs() + beta.abs() * size[0] + gamma.abs() * size[1];
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

    /// Says that the motion starts on the border itself.
    pub(crate) fn start_at_zero(&mut self) {
        self.c[0] = 0.0;
    }

    /// A bound of `|g̈|` over `[0, end]`.
    #[inline(always)]
    fn curvature(&self, end: f64) -> f64 {
        let (mut sum, mut power) = (0.0, 1.0);
        for n in 2..COEFFICIENTS {
            sum += (n * (n - 1)) as f64 * self.c[n].abs() * power;
            power *= end;
        }
        sum
    }

    /// The first time in `(0, end]` from which on the margin is negative, if there is one. A margin that
    /// starts at zero, to rounding, and rises counts as positive; one that starts at zero or below and
    /// falls leaves at time zero.
    ///
    /// Cannot miss: a part of the step is dropped only if the values at its ends and the bound of the
    /// curvature prove that the margin stays positive in between, or that it is monotonic. Excursions
    /// below rounding are touches, not crossings.
    #[inline(always)]
    pub(crate) fn first_exit(&self, end: f64) -> Option<f64> {
        let curvature = self.curvature(end);
        let start = self.c[0];
        if start < -self.noise || (start <= self.noise && self.c[1] < 0.0) {
            return Some(0.0);
        }
        let least = self.c[1] - curvature * end;
        if least > 0.0 {
            return None; // rises throughout
        }
        let last = self.value(end);
        if self.c[1] + curvature * end < 0.0 {
            // Falls throughout.
            return (last < 0.0).then(|| self.root(0.0, end, start.max(0.0), last));
        }
        self.search(end, start.max(0.0), last, curvature)
    }

    /// The first exit of a margin that may turn within the step.
    #[inline(always)]
    fn search(&self, end: f64, start: f64, last: f64, curvature: f64) -> Option<f64> {
        let mut parts = [(0.0, 0.0, 0.0, 0.0); DEPTH];
        let mut count = 1;
        parts[0] = (0.0, end, start, last);
        while count > 0 {
            count -= 1;
            let (a, b, ga, gb) = parts[count];
            let width = b - a;
            // What can be below zero in between is a touch.
            if ga.min(gb) - 0.125 * curvature * width * width >= -self.noise {
                continue;
            }
            let (_, slope) = self.value_and_slope(a + 0.5 * width);
            let spread = 0.5 * curvature * width;
            if slope > spread {
                // Rises: negative only if it already was at the start of the part.
                continue;
            }
            if slope < -spread {
                if gb < 0.0 {
                    return Some(self.root(a, b, ga, gb));
                }
                continue;
            }
            if width <= 1e-9 * end || count + 2 > DEPTH {
                if gb < -self.noise {
                    return Some(b);
                }
                continue;
            }
            let middle = a + 0.5 * width;
            let gm = self.value(middle);
            if gm < -self.noise {
                // The second half is of no interest any more.
                parts[count] = (a, middle, ga, gm);
                count += 1;
            } else {
                parts[count] = (middle, b, gm, gb);
                parts[count + 1] = (a, middle, ga, gm);
                count += 2;
            }
        }
        None
    }

    /// The root in `[a, b]`, where the margin falls from `ga ≥ 0` to `gb < 0` monotonically: Newton's
    /// method within the bracket.
    #[inline(always)]
    fn root(&self, mut a: f64, mut b: f64, ga: f64, gb: f64) -> f64 {
        let mut t = a + (b - a) * (ga / (ga - gb));
        if a == 0.0 {
            // From the start of a step its parabola says more than the chord.
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

    fn margin(c: &[f64]) -> Margin {
        let mut all = [0.0; COEFFICIENTS];
        all[..c.len()].copy_from_slice(c);
        Margin { c: all, noise: 1e-15 }
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

    #[test]
    fn touches_and_returns_are_no_crossings() {
        assert_eq!(margin(&[0.25, -1.0, 1.0]).first_exit(1.0), None, "touches at 0.5");
        assert_eq!(margin(&[0.0, 2.0, 1.0]).first_exit(1.0), None, "leaves the border inwards");
        assert_eq!(margin(&[1e-17, -2.0]).first_exit(1.0), Some(0.0), "outwards at once");
        let back = margin(&[0.0, 1.0, -4.0]).first_exit(1.0).unwrap();
        assert!((back - 0.25).abs() < 1e-12, "comes back to the border it started from: {back}");
    }
}
