//! A multilayer perceptron of any depth and width.

use crate::activation::{self, Activation, ActivationFunction};
use crate::error::ModelError;
use crate::scalar::Scalar;

/// One dense layer, `out = W input + b`.
#[derive(Debug, Clone, PartialEq)]
pub struct Dense<S> {
    /// The weight matrix W `[outputs, inputs]`, stored column by column: entry `(j, i)` is at
    /// `i · outputs + j`.
    columns: Vec<S>,
    /// The bias b `[outputs]`.
    bias: Vec<S>,
}

impl<S: Scalar> Dense<S> {
    /// A layer from a weight matrix in row-major order `[outputs, inputs]` (as NumPy, JAX and
    /// PyTorch store it) and a bias.
    ///
    /// # Errors
    /// [`ModelError::Shape`] if the lengths do not fit or a dimension is zero.
    pub fn from_rows(weights: &[S], bias: Vec<S>) -> Result<Self, ModelError> {
        let outputs = bias.len();
        if outputs == 0 || weights.is_empty() || !weights.len().is_multiple_of(outputs) {
            return Err(ModelError::Shape(format!(
                "{} weights do not form rows for {outputs} outputs",
                weights.len()
            )));
        }
        let inputs = weights.len() / outputs;
        let columns =
            (0..inputs).flat_map(|i| (0..outputs).map(move |j| weights[j * inputs + i])).collect();
        Ok(Self { columns, bias })
    }

    /// Number of inputs.
    #[must_use]
    pub fn inputs(&self) -> usize {
        self.columns.len() / self.bias.len()
    }

    /// Number of outputs.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.bias.len()
    }

    /// The weight matrix in row-major order `[outputs, inputs]`.
    #[must_use]
    pub fn weight_rows(&self) -> Vec<S> {
        let (n, m) = (self.outputs(), self.inputs());
        (0..n).flat_map(|j| (0..m).map(move |i| self.columns[i * n + j])).collect()
    }

    /// The weight matrix column by column, as it is stored.
    #[must_use]
    pub fn weight_columns(&self) -> &[S] {
        &self.columns
    }

    /// The bias.
    #[must_use]
    pub fn bias(&self) -> &[S] {
        &self.bias
    }

    fn map<T>(&self, mut f: impl FnMut(S) -> T) -> Dense<T> {
        Dense {
            columns: self.columns.iter().map(|&w| f(w)).collect(),
            bias: self.bias.iter().map(|&b| f(b)).collect(),
        }
    }
}

/// A multilayer perceptron: dense layers with one activation between them and none at the output.
#[derive(Debug, Clone, PartialEq)]
pub struct Mlp<S, A = Activation> {
    layers: Vec<Dense<S>>,
    activation: A,
    /// Widest layer output, the unit of scratch memory.
    width: usize,
}

impl<S: Scalar, A: ActivationFunction> Mlp<S, A> {
    /// A network of the given layers.
    ///
    /// # Errors
    /// [`ModelError::Shape`] if there is no layer, or one layer's outputs are not the next one's
    /// inputs.
    pub fn new(layers: Vec<Dense<S>>, activation: A) -> Result<Self, ModelError> {
        if layers.is_empty() {
            return Err(ModelError::Shape("a network needs at least one layer".into()));
        }
        for (k, pair) in layers.windows(2).enumerate() {
            if pair[0].outputs() != pair[1].inputs() {
                return Err(ModelError::Shape(format!(
                    "layer {k} has {} outputs but layer {} takes {} inputs",
                    pair[0].outputs(),
                    k + 1,
                    pair[1].inputs()
                )));
            }
        }
        let width = layers.iter().map(Dense::outputs).max().unwrap_or(0);
        Ok(Self { layers, activation, width })
    }

    /// The layers, first to last.
    #[must_use]
    pub fn layers(&self) -> &[Dense<S>] {
        &self.layers
    }

    /// The activation between layers.
    #[must_use]
    pub fn activation(&self) -> &A {
        &self.activation
    }

    /// Number of inputs of the network.
    #[must_use]
    pub fn inputs(&self) -> usize {
        self.layers[0].inputs()
    }

    /// Number of outputs of the network.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.layers[self.layers.len() - 1].outputs()
    }

    /// Number of weights and biases.
    #[must_use]
    pub fn parameter_count(&self) -> usize {
        self.layers.iter().map(|l| l.columns.len() + l.bias.len()).sum()
    }

    /// Number of scratch scalars that [`forward_into`](Mlp::forward_into) needs.
    #[must_use]
    pub fn work_len(&self) -> usize {
        2 * self.width
    }

    /// Writes the network's output for one input vector to `out`. Allocates nothing.
    ///
    /// # Panics
    /// If the lengths of `input`, `out` or `work` do not fit.
    pub fn forward_into(&self, input: &[S], out: &mut [S], work: &mut [S]) {
        let (mut current, mut next) = work[..2 * self.width].split_at_mut(self.width);
        let last = self.layers.len() - 1;
        for (k, layer) in self.layers.iter().enumerate() {
            let n = layer.outputs();
            let source = if k == 0 { input } else { &current[..layer.inputs()] };
            if k == last {
                S::affine_into(&layer.columns, &layer.bias, source, out);
            } else {
                S::affine_into(&layer.columns, &layer.bias, source, &mut next[..n]);
                activation::apply(&self.activation, &mut next[..n]);
                std::mem::swap(&mut current, &mut next);
            }
        }
    }

    /// The same network with other numbers, weight by weight.
    pub fn map<T: Scalar>(&self, mut f: impl FnMut(S) -> T) -> Mlp<T, A> {
        Mlp {
            layers: self.layers.iter().map(|l| l.map(&mut f)).collect(),
            activation: self.activation,
            width: self.width,
        }
    }
}
