use num_dual::Dual64;

/// `f'(x)` by one dual-number evaluation, exact to rounding. At a kink it is the derivative of the
/// branch that `f` takes there.
///
/// ```
/// use pam_core::Scalar;
/// let d = pam_autodiff::derivative(|x| x * x * x, 2.0);
/// assert_eq!(d, 12.0);
/// ```
pub fn derivative(f: impl FnOnce(Dual64) -> Dual64, x: f64) -> f64 {
    f(Dual64::new(x, 1.0)).eps
}
