use pam_core::force::Dense;
use pam_core::simd::{AlignedVec, Float, padded};

/// One dense layer in both orders, padded to whole vectors with zeros.
#[derive(Debug, Clone)]
pub(super) struct Layer<T> {
    pub(super) inputs: usize,
    pub(super) outputs: usize,
    /// Distance between points of an input batch.
    pub(super) input_stride: usize,
    /// Distance between points of an output batch.
    pub(super) output_stride: usize,
    /// The weight matrix column by column, `[inputs, output_stride]`: for values and tangents.
    pub(super) columns: AlignedVec<T>,
    /// The weight matrix row by row, `[outputs, input_stride]`: for cotangents.
    pub(super) rows: AlignedVec<T>,
    /// The bias, `[output_stride]`.
    pub(super) bias: AlignedVec<T>,
}

impl<T: Float> Layer<T> {
    /// The layer without its first `skip` inputs.
    pub(super) fn new(dense: &Dense<f64>, skip: usize) -> Self {
        let (inputs, outputs) = (dense.inputs() - skip, dense.outputs());
        let (input_stride, output_stride) = (padded(inputs), padded(outputs));
        let mut layer = Self {
            inputs,
            outputs,
            input_stride,
            output_stride,
            columns: AlignedVec::zeros(inputs * output_stride),
            rows: AlignedVec::zeros(outputs * input_stride),
            bias: AlignedVec::zeros(output_stride),
        };
        for (i, column) in dense.weight_columns().chunks_exact(outputs).skip(skip).enumerate() {
            for (j, &w) in column.iter().enumerate() {
                layer.columns[i * output_stride + j] = T::narrow(w);
                layer.rows[j * input_stride + i] = T::narrow(w);
            }
        }
        for (b, &value) in layer.bias.iter_mut().zip(dense.bias()) {
            *b = T::narrow(value);
        }
        layer
    }

    /// Column `i` of a weight matrix, padded.
    pub(super) fn column(dense: &Dense<f64>, i: usize) -> Vec<T> {
        let n = dense.outputs();
        let mut column: Vec<T> =
            dense.weight_columns()[i * n..(i + 1) * n].iter().map(|&w| T::narrow(w)).collect();
        column.resize(padded(n), T::default());
        column
    }
}
