use super::{Central, DifferenceScheme};

/// Central differences at `h, h/2, h/4, …` extrapolated to a step of zero, `L` levels.
///
/// With `D_{k,0}` the central difference at `h/2ᵏ`, whose error is a series in `h²`,
///
/// ```text
/// D_{k,j} = D_{k,j−1} + (D_{k,j−1} − D_{k−1,j−1}) / (4ʲ − 1)
/// ```
///
/// removes its first `j` terms; `D_{L−1,L−1}` has error O(h²ᴸ). Since rounding grows down the table,
/// the entry that differs least from its two parents is taken, and that difference is the estimate of
/// its error. Source: L. F. Richardson (1911); C. Ridders, *Accurate computation of F'(x) and F'(x)
/// F''(x)* (1982). `2 L` evaluations, no allocation.
///
/// ```
/// use pam_autodiff::Richardson;
/// let estimate = Richardson::default().estimate(&mut |x: f64| x.exp(), 1.0);
/// assert!((estimate.derivative - 1.0_f64.exp()).abs() < 1e-11);
/// assert!(estimate.error < 1e-10);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Richardson {
    /// The largest step h, in units of x. `f` must be smooth over ±h.
    pub h: f64,
    /// Number of levels L, 1 to [`MAX_LEVELS`](Self::MAX_LEVELS); a single one has no error estimate.
    pub levels: usize,
}

/// A derivative and how far off it may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The estimate of `f'(x)`.
    pub derivative: f64,
    /// The estimate of its error, not a number if there is none.
    pub error: f64,
}

impl Richardson {
    /// More levels than this bring nothing in double precision.
    pub const MAX_LEVELS: usize = 12;

    /// The derivative with the estimate of its error.
    ///
    /// # Panics
    /// If the number of levels is 0 or above [`MAX_LEVELS`](Self::MAX_LEVELS).
    pub fn estimate(&self, f: &mut dyn FnMut(f64) -> f64, x: f64) -> Estimate {
        assert!((1..=Self::MAX_LEVELS).contains(&self.levels), "1 to 12 levels");
        let mut above = [0.0; Self::MAX_LEVELS];
        above[0] = Central { h: self.h }.derivative(f, x);
        let mut best = Estimate { derivative: above[0], error: f64::NAN };
        for k in 1..self.levels {
            let mut row = [0.0; Self::MAX_LEVELS];
            row[0] = Central { h: self.h / f64::powi(2.0, k as i32) }.derivative(f, x);
            let mut power = 1.0;
            for j in 1..=k {
                power *= 4.0;
                row[j] = row[j - 1] + (row[j - 1] - above[j - 1]) / (power - 1.0);
                let error = (row[j] - row[j - 1]).abs().max((row[j] - above[j - 1]).abs());
                if best.error.is_nan() || error <= best.error {
                    best = Estimate { derivative: row[j], error };
                }
            }
            above = row;
        }
        best
    }
}

/// Six levels from h = 0.1 on.
impl Default for Richardson {
    fn default() -> Self {
        Self { h: 0.1, levels: 6 }
    }
}

impl DifferenceScheme for Richardson {
    fn name(&self) -> &'static str {
        "richardson"
    }
    fn derivative(&self, f: &mut dyn FnMut(f64) -> f64, x: f64) -> f64 {
        self.estimate(f, x).derivative
    }
}
