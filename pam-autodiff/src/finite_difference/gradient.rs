use super::DifferenceScheme;

/// The gradient `∂f/∂x_k` `[n]` by a scheme, variable by variable; `n` times the scheme's evaluations. One
/// step serves all variables; where they differ in size use
/// [`scaled_gradient_by_difference`].
///
/// ```
/// use pam_autodiff::{Central, gradient_by_difference};
/// let g = gradient_by_difference(&Central { h: 1e-3 }, |x| x[0] * x[0] * x[1], &[1.0, 2.0]);
/// assert!((g[0] - 4.0).abs() < 1e-9 && (g[1] - 1.0).abs() < 1e-9);
/// ```
pub fn gradient_by_difference(
    scheme: &dyn DifferenceScheme,
    f: impl FnMut(&[f64]) -> f64,
    x: &[f64],
) -> Vec<f64> {
    differences(scheme, f, x, |_| 1.0)
}

/// [`gradient_by_difference`] of the variables in units of their `sizes`: the scheme's step for variable
/// `k` is `h · sizes[k]`.
///
/// # Panics
/// If there is not one size for each variable.
///
/// ```
/// use pam_autodiff::{Central, scaled_gradient_by_difference};
/// let (x, sizes) = ([1e6, 1e-6], [1e6, 1e-6]);
/// let g = scaled_gradient_by_difference(&Central { h: 1e-3 }, |x| x[0] * x[0] * x[1], &x, &sizes);
/// assert!((g[0] - 2.0).abs() < 1e-9 && (g[1] / 1e12 - 1.0).abs() < 1e-9);
/// ```
pub fn scaled_gradient_by_difference(
    scheme: &dyn DifferenceScheme,
    f: impl FnMut(&[f64]) -> f64,
    x: &[f64],
    sizes: &[f64],
) -> Vec<f64> {
    assert_eq!(sizes.len(), x.len(), "one size for each variable");
    differences(scheme, f, x, |k| sizes[k])
}

fn differences(
    scheme: &dyn DifferenceScheme,
    mut f: impl FnMut(&[f64]) -> f64,
    x: &[f64],
    size: impl Fn(usize) -> f64,
) -> Vec<f64> {
    let mut moved = x.to_vec();
    let mut along = |k: usize| {
        let mut of_one = |units: f64| {
            moved[k] = units * size(k);
            f(&moved)
        };
        let slope = scheme.derivative(&mut of_one, x[k] / size(k)) / size(k);
        moved[k] = x[k];
        slope
    };
    (0..x.len()).map(&mut along).collect()
}
