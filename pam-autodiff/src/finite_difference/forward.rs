use super::DifferenceScheme;

/// `[f(x+h) − f(x)] / h`; error O(h).
///
/// ```
/// use pam_autodiff::{DifferenceScheme, Forward};
/// assert_eq!(Forward { h: 0.5 }.derivative(&mut |x| x * x, 1.0), 2.5);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Forward {
    /// Step h, in units of x.
    pub h: f64,
}

/// `h = √ε`, where truncation and rounding of an `f` of size one balance.
impl Default for Forward {
    fn default() -> Self {
        Self { h: f64::EPSILON.sqrt() }
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
