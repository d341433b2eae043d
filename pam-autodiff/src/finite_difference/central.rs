use super::DifferenceScheme;

/// `[f(x+h) − f(x−h)] / 2h`; error O(h²).
///
/// ```
/// use pam_autodiff::{Central, DifferenceScheme};
/// assert_eq!(Central { h: 0.5 }.derivative(&mut |x| x * x, 1.0), 2.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Central {
    /// Step h, in units of x.
    pub h: f64,
}

/// `h = ∛ε`, where truncation and rounding of an `f` of size one balance.
impl Default for Central {
    fn default() -> Self {
        Self { h: f64::EPSILON.cbrt() }
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
