use super::function::require_one_output;
use super::{Function, Recorder};
use num_dual::Dual64;

/// Gradient and product `H v` `[n]` of the Hessian with a direction `v` `[n]`, of a function with one
/// output, forward over reverse: the tape of a run with dual numbers along `v` is swept once, so
/// the cost does not depend on `n`. Source: B. Pearlmutter, *Fast Exact Multiplication by the Hessian*
/// (1994).
///
/// # Panics
/// If `f` has not one output, or `v` is not as long as `x`.
///
/// ```
/// use pam_autodiff::{Function, hessian_vector};
/// use pam_core::Scalar;
/// struct Product;
/// impl Function for Product {
///     fn eval<S: Scalar>(&self, x: &[S], out: &mut [S]) {
///         out[0] = x[0] * x[1] * x[1];
///     }
/// }
/// let (gradient, product) = hessian_vector(&Product, &[2.0, 3.0], &[1.0, 0.0]);
/// assert_eq!((gradient, product), (vec![9.0, 12.0], vec![0.0, 6.0]));
/// ```
pub fn hessian_vector(f: &impl Function, x: &[f64], v: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let (mut gradient, mut product) = (vec![0.0; x.len()], vec![0.0; x.len()]);
    hessian_vector_into(f, x, v, &mut gradient, &mut product, &mut Recorder::new());
    (gradient, product)
}

/// Writes gradient and product of [`hessian_vector`] and returns `f(x)`.
///
/// # Panics
/// If `f` has not one output, or the lengths do not fit.
///
/// ```
/// use pam_autodiff::{Function, Recorder, hessian_vector_into};
/// use pam_core::Scalar;
/// struct Cube;
/// impl Function for Cube {
///     fn eval<S: Scalar>(&self, x: &[S], out: &mut [S]) {
///         out[0] = x[0] * x[0] * x[0];
///     }
/// }
/// let (mut gradient, mut product) = ([0.0], [0.0]);
/// let work = &mut Recorder::new();
/// hessian_vector_into(&Cube, &[2.0], &[1.0], &mut gradient, &mut product, work);
/// assert_eq!((gradient, product), ([12.0], [12.0]));
/// ```
pub fn hessian_vector_into(
    f: &impl Function,
    x: &[f64],
    v: &[f64],
    gradient: &mut [f64],
    product: &mut [f64],
    work: &mut Recorder<Dual64>,
) -> f64 {
    require_one_output(f);
    assert_eq!(v.len(), x.len(), "one change for each input");
    assert!(gradient.len() == x.len() && product.len() == x.len(), "one entry for each input");
    let moved = x.iter().zip(v).map(|(&x, &v)| Dual64::new(x, v));
    work.record(|x, out| f.eval(x, out), moved, 1);
    let value = work.values().map(|out| out.re).sum();
    let (adjoints, x) = work.reverse([Dual64::from_re(1.0)].into_iter());
    for ((&x, gradient), product) in x.iter().zip(gradient).zip(product) {
        let adjoint = adjoints.of(x);
        (*gradient, *product) = (adjoint.re, adjoint.eps);
    }
    value
}
