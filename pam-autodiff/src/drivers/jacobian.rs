use super::{Function, Point, Recorder};
use crate::numbers::Chunk;

/// Columns of the Jacobian that one evaluation in forward mode gives: a vector of doubles.
pub const CHUNK: usize = 8;

/// The Jacobian `∂f_i/∂x_j` `[m, n]`, row by row, in forward mode: one evaluation with chunks for every
/// [`CHUNK`] inputs.
///
/// ```
/// use pam_autodiff::{Function, jacobian_forward, jacobian_reverse};
/// use pam_core::Scalar;
/// struct SumAndProduct;
/// impl Function for SumAndProduct {
///     fn output_len(&self) -> usize {
///         2
///     }
///     fn eval<S: Scalar>(&self, x: &[S], out: &mut [S]) {
///         (out[0], out[1]) = (x[0] + x[1], x[0] * x[1]);
///     }
/// }
/// let jacobian = [1.0, 1.0, 3.0, 2.0];
/// assert_eq!(jacobian_forward(&SumAndProduct, &[2.0, 3.0]), jacobian);
/// assert_eq!(jacobian_reverse(&SumAndProduct, &[2.0, 3.0]), jacobian);
/// ```
pub fn jacobian_forward(f: &impl Function, x: &[f64]) -> Vec<f64> {
    let mut jacobian = vec![0.0; f.output_len() * x.len()];
    jacobian_forward_into::<CHUNK>(f, x, &mut jacobian, &mut Point::new());
    jacobian
}

/// Writes the [`jacobian_forward`], `N` columns at a time.
///
/// # Panics
/// If `jacobian` has not `m n` entries.
///
/// ```
/// use pam_autodiff::{Function, Point, jacobian_forward_into};
/// use pam_core::Scalar;
/// struct Twice;
/// impl Function for Twice {
///     fn eval<S: Scalar>(&self, x: &[S], out: &mut [S]) {
///         out[0] = x[0].scaled(2.0);
///     }
/// }
/// let mut jacobian = [0.0];
/// jacobian_forward_into::<4>(&Twice, &[1.0], &mut jacobian, &mut Point::new());
/// assert_eq!(jacobian, [2.0]);
/// ```
pub fn jacobian_forward_into<const N: usize>(
    f: &impl Function,
    x: &[f64],
    jacobian: &mut [f64],
    work: &mut Point<Chunk<N>>,
) {
    let outputs = f.output_len();
    const { assert!(N > 0, "a chunk has at least one direction") };
    assert_eq!(jacobian.len(), outputs * x.len(), "one entry for each output and input");
    for first in (0..x.len()).step_by(N) {
        let seeded = x.iter().enumerate().map(|(k, &value)| Chunk::seeded(value, k, first));
        let out = work.eval(|x, out| f.eval(x, out), seeded, outputs);
        for (row, out) in jacobian.chunks_exact_mut(x.len()).zip(out) {
            for (entry, &d) in row[first..].iter_mut().zip(&out.derivatives) {
                *entry = d;
            }
        }
    }
}

/// The Jacobian `∂f_i/∂x_j` `[m, n]`, row by row, in reverse mode: one recorded evaluation and one
/// sweep for each output. See [`jacobian_forward`] for an example.
pub fn jacobian_reverse(f: &impl Function, x: &[f64]) -> Vec<f64> {
    let mut jacobian = vec![0.0; f.output_len() * x.len()];
    jacobian_reverse_into(f, x, &mut jacobian, &mut Recorder::new());
    jacobian
}

/// Writes the [`jacobian_reverse`].
///
/// # Panics
/// If `jacobian` has not `m n` entries.
///
/// ```
/// use pam_autodiff::{Function, Recorder, jacobian_reverse_into};
/// use pam_core::Scalar;
/// struct Twice;
/// impl Function for Twice {
///     fn eval<S: Scalar>(&self, x: &[S], out: &mut [S]) {
///         out[0] = x[0].scaled(2.0);
///     }
/// }
/// let mut jacobian = [0.0];
/// jacobian_reverse_into(&Twice, &[1.0], &mut jacobian, &mut Recorder::new());
/// assert_eq!(jacobian, [2.0]);
/// ```
pub fn jacobian_reverse_into(
    f: &impl Function,
    x: &[f64],
    jacobian: &mut [f64],
    work: &mut Recorder,
) {
    let outputs = f.output_len();
    assert_eq!(jacobian.len(), outputs * x.len(), "one entry for each output and input");
    if x.is_empty() {
        return;
    }
    work.record(|x, out| f.eval(x, out), x.iter().copied(), outputs);
    for (i, row) in jacobian.chunks_exact_mut(x.len()).enumerate() {
        let (adjoints, x) = work.reverse((0..outputs).map(|k| f64::from(k == i)));
        row.fill(0.0);
        adjoints.add_to(x, row);
    }
}
