use super::BatchNetwork;
use pam_core::ActivationFunction;
use pam_core::simd::{AlignedVec, Float};

/// Sums of weight cotangents over a block of points.
///
/// They are kept in the network's own float for one block and emptied into doubles block by block, so
/// that a gradient over a million points loses nothing in `f32`.
#[derive(Debug, Clone)]
pub struct NetworkSums<T> {
    /// Per layer `[inputs, output_stride]`; the last one `[outputs, input_stride]`.
    pub(super) weights: Vec<AlignedVec<T>>,
    /// Per layer `[output_stride]`.
    pub(super) biases: Vec<AlignedVec<T>>,
    pub(super) ones: Vec<T>,
}

impl<T: Float, A: ActivationFunction> BatchNetwork<T, A> {
    /// Empty sums for blocks of up to `capacity` points.
    #[must_use]
    pub fn sums(&self, capacity: usize) -> NetworkSums<T> {
        let last = self.hidden();
        let weights = self.layers.iter().enumerate().map(|(k, l)| {
            let len =
                if k == last { l.outputs * l.input_stride } else { l.inputs * l.output_stride };
            AlignedVec::zeros(len)
        });
        NetworkSums {
            weights: weights.collect(),
            biases: self.layers.iter().map(|l| AlignedVec::zeros(l.output_stride)).collect(),
            ones: vec![T::narrow(1.0); capacity],
        }
    }

    /// Adds the sums to `parameters` (in the order of the network's parameters: layer by layer, weight
    /// columns, then bias) and to `constants`, the cotangents of the constant inputs, whose values are
    /// `constant_values`; then empties the sums.
    ///
    /// # Panics
    /// If a slice is too short.
    pub fn drain_into(
        &self,
        sums: &mut NetworkSums<T>,
        constant_values: &[f64],
        parameters: &mut [f64],
        constants: &mut [f64],
    ) {
        let last = self.hidden();
        let mut rest = parameters;
        for (k, layer) in self.layers.iter().enumerate() {
            let n = layer.outputs;
            if k == 0 {
                // A constant input c scales its column: ∂z/∂W = c ∂z/∂b, and ∂z/∂c = W.
                let bias = &sums.biases[0];
                for ((column, &value), c) in
                    self.constant_columns.iter().zip(constant_values).zip(constants.iter_mut())
                {
                    let (own, next) = rest.split_at_mut(n);
                    rest = next;
                    for ((o, b), w) in own.iter_mut().zip(&**bias).zip(column) {
                        *o += value * b.widen();
                        *c += w.widen() * b.widen();
                    }
                }
            }
            let (own, next) = rest.split_at_mut(n * layer.inputs);
            let weights = &sums.weights[k];
            for (i, column) in own.chunks_exact_mut(n).enumerate() {
                for (j, o) in column.iter_mut().enumerate() {
                    *o += if k == last {
                        weights[j * layer.input_stride + i].widen()
                    } else {
                        weights[i * layer.output_stride + j].widen()
                    };
                }
            }
            let (own, next) = next.split_at_mut(n);
            rest = next;
            for (o, b) in own.iter_mut().zip(&*sums.biases[k]) {
                *o += b.widen();
            }
        }
        for sum in sums.weights.iter_mut().chain(&mut sums.biases) {
            sum.fill(T::default());
        }
    }
}
