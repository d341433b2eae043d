//! Shared parts of networks on batches: products of their layers, sums for gradients, checks of settings.
//!
//! Members of the batch are columns. Matrices lie column by column, their columns as far apart as they have rows.

use pam_core::simd::Float;
use pam_core::simd::gemm::{Finish, Layout, Product, Start};

/// Columns of a batch: so many, so far apart.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Columns<'a, T> {
    pub(crate) values: &'a [T],
    pub(crate) count: usize,
    pub(crate) stride: usize,
}

impl<'a, T> Columns<'a, T> {
    pub(crate) fn of(values: &'a [T], count: usize, stride: usize) -> Self {
        Self { values, count, stride }
    }
}

/// `C = start + A B` with A `[rows, inner]`.
pub(crate) fn multiply<T: Float>(
    [rows, inner]: [usize; 2],
    a: &[T],
    b: Columns<'_, T>,
    start: Start<'_, T>,
    c: &mut [T],
) {
    let Columns { values: b, count: columns, stride: b_stride } = b;
    let (layout, finish) = (Layout::Columns, Finish::Store);
    Product { rows, inner, columns, a, b, layout, b_stride, start, finish, c }.run();
}

/// `A Bᵀ` of `rows` by `inputs`, summed over the columns: the gradient of a layer's weights from the
/// cotangents of its sums (`a`, columns of `rows`) and what it read (`b`).
pub(crate) fn weight_gradient<T: Float>(
    [rows, inputs]: [usize; 2],
    a: &[T],
    b: Columns<'_, T>,
    c: &mut [T],
) {
    let Columns { values: b, count: inner, stride: b_stride } = b;
    let (layout, finish, start) = (Layout::Rows, Finish::Store, Start::Zero);
    Product { rows, inner, columns: inputs, a, b, layout, b_stride, start, finish, c }.run();
}

/// Sums over columns of `rows` numbers: the gradient of a layer's biases.
pub(crate) fn row_sums<T: Float>(columns: &[T], rows: usize) -> Vec<f64> {
    let mut sums = vec![0.0; rows];
    for column in columns.chunks_exact(rows) {
        for (s, v) in sums.iter_mut().zip(column) {
            *s += v.widen();
        }
    }
    sums
}

/// Checks the width of layers.
pub(crate) fn check_width(name: &str, width: usize) -> Result<(), String> {
    if width == 0 || !width.is_multiple_of(16) {
        return Err(format!("{name} = {width} must be a multiple of 16"));
    }
    Ok(())
}

/// Checks numbers of something.
pub(crate) fn check_counts(counts: &[(&str, usize)]) -> Result<(), String> {
    match counts.iter().find(|(_, value)| *value == 0) {
        Some((name, _)) => Err(format!("{name} must be positive")),
        None => Ok(()),
    }
}

/// Checks sizes of something.
pub(crate) fn check_positive(values: &[(&str, f64)]) -> Result<(), String> {
    match values.iter().find(|(_, value)| !(value.is_finite() && *value > 0.0)) {
        Some((name, value)) => Err(format!("{name} = {value} must be positive and finite")),
        None => Ok(()),
    }
}

/// A rate that falls from its start to zero as a cosine, at a share of the way.
pub(crate) fn cosine_rate(start: f64, share: f64) -> f64 {
    0.5 * start * (1.0 + (std::f64::consts::PI * share).cos())
}
