//! Finite-difference schemes for a first derivative.

/// A scheme that estimates `f'(x)` from values of `f`.
pub trait DifferenceScheme {
    /// Name for tables and plots.
    fn name(&self) -> &'static str;

    /// The estimate of `f'(x)`.
    fn derivative(&self, f: &mut dyn FnMut(f64) -> f64, x: f64) -> f64;
}

/// `[f(x+h) − f(x)] / h`; error O(h).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Forward {
    /// Step h, in units of x.
    pub h: f64,
}

/// `[f(x+h) − f(x−h)] / 2h`; error O(h²).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Central {
    /// Step h, in units of x.
    pub h: f64,
}

/// `[f(x+2h) + f(x+h) − f(x−h) − f(x−2h)] / 6h`; error O(h²).
///
/// The paper's smoothed stiffness estimate (Wang and Realmuto 2026, section II-E). It averages over
/// kinks of a piecewise-affine force. The paper does not give h; h = 1 mm reproduces its range of
/// 126–176 N/mm and is the default.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FourPointSmoothed {
    /// Step h, in units of x.
    pub h: f64,
}

impl Default for FourPointSmoothed {
    fn default() -> Self {
        Self { h: 1.0 }
    }
}

impl DifferenceScheme for Forward {
    fn name(&self) -> &'static str {
        "forward"
    }
    fn derivative(&self, f: &mut dyn FnMut(f64) -> f64, x: f64) -> f64 {
        (f(x + self.h) - f(x)) / self.h
    }
}

impl DifferenceScheme for Central {
    fn name(&self) -> &'static str {
        "central"
    }
    fn derivative(&self, f: &mut dyn FnMut(f64) -> f64, x: f64) -> f64 {
        (f(x + self.h) - f(x - self.h)) / (2.0 * self.h)
    }
}

impl DifferenceScheme for FourPointSmoothed {
    fn name(&self) -> &'static str {
        "four_point_smoothed"
    }
    fn derivative(&self, f: &mut dyn FnMut(f64) -> f64, x: f64) -> f64 {
        let h = self.h;
        (f(x + 2.0 * h) + f(x + h) - f(x - h) - f(x - 2.0 * h)) / (6.0 * h)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The error of each scheme falls with its order when the step is halved.
    #[test]
    fn orders_are_as_stated() {
        let order = |at: &dyn Fn(f64) -> f64| {
            let exact = 0.7_f64.cos();
            let (coarse, fine) = ((at(2e-3) - exact).abs(), (at(1e-3) - exact).abs());
            (coarse / fine).log2()
        };
        let f = |x: f64| x.sin();
        assert!((order(&|h| Forward { h }.derivative(&mut { f }, 0.7)) - 1.0).abs() < 0.01);
        assert!((order(&|h| Central { h }.derivative(&mut { f }, 0.7)) - 2.0).abs() < 0.01);
        assert!(
            (order(&|h| FourPointSmoothed { h }.derivative(&mut { f }, 0.7)) - 2.0).abs() < 0.01
        );
        // All are exact on a straight line.
        let mut line = |x: f64| 3.0 * x - 1.0;
        let schemes: [&dyn DifferenceScheme; 3] =
            [&Forward { h: 0.5 }, &Central { h: 0.5 }, &FourPointSmoothed::default()];
        for s in schemes {
            assert!((s.derivative(&mut line, 2.0) - 3.0).abs() < 1e-14, "{}", s.name());
        }
    }
}
