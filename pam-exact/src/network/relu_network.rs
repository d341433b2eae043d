use super::plane::Plane;
use crate::simd::LANES;
use pam_core::{ForceModel, ModelError, ReluLayers};

/// One layer with its columns padded.
#[derive(Debug, Clone)]
pub(crate) struct Layer {
    pub(crate) inputs: usize,
    pub(crate) outputs: usize,
    /// Length of a padded column.
    pub(crate) stride: usize,
    /// The columns of the weight matrix, each padded with zeros.
    pub(crate) columns: Vec<f64>,
    /// The bias, padded with zeros.
    pub(crate) bias: Vec<f64>,
}

/// A force network `(m_f, m_e, x, ẋ) → f` with the activation `σ(z) = max(z, s z)`, `0 ≤ s ≤ 1`: ReLU for
/// `s = 0`, leaky ReLU otherwise.
#[derive(Debug, Clone)]
pub struct ReluNetwork {
    /// Hidden layers.
    pub(crate) hidden: Vec<Layer>,
    /// Weights of the output, padded like the last hidden layer.
    pub(crate) output: Vec<f64>,
    pub(crate) output_bias: f64,
    /// Rows of the last hidden layer, padded like the layer before it; empty if there is none.
    pub(crate) last_rows: Vec<f64>,
    /// Slope `s` of inactive units.
    pub(crate) slope: f64,
}

impl ReluNetwork {
    /// True if the exact methods apply to this force: it is a (leaky) ReLU network.
    #[must_use]
    pub fn applies_to(force: &impl ForceModel<f64>) -> bool {
        force.relu_layers().is_some()
    }

    /// Copies the weights of a force network.
    ///
    /// # Errors
    /// [`ModelError::Shape`] if the force is not a (leaky) ReLU network with a hidden layer.
    pub fn new(force: &impl ForceModel<f64>) -> Result<Self, ModelError> {
        let Some(ReluLayers { layers, slope }) = force.relu_layers() else {
            return Err(ModelError::Shape(
                "the exact method needs a network of leaky_relu or relu with a hidden layer; take a \
                 general solver for this force"
                    .into(),
            ));
        };
        let Some((last, hidden)) = layers.split_last() else {
            return Err(ModelError::Shape("a network needs at least one layer".into()));
        };
        let padded = |values: &[f64], stride: usize| {
            let mut column = values.to_vec();
            column.resize(stride, 0.0);
            column
        };
        let hidden: Vec<Layer> = hidden
            .iter()
            .map(|layer| {
                let outputs = layer.outputs();
                let stride = outputs.next_multiple_of(LANES);
                let columns = layer.weight_columns().chunks_exact(outputs);
                Layer {
                    inputs: layer.inputs(),
                    outputs,
                    stride,
                    columns: columns.flat_map(|c| padded(c, stride)).collect(),
                    bias: padded(layer.bias(), stride),
                }
            })
            .collect();
        let stride = hidden[hidden.len() - 1].stride;
        Ok(Self {
            output: padded(last.weight_columns(), stride),
            output_bias: last.bias()[0],
            last_rows: last_rows(&hidden),
            hidden,
            slope,
        })
    }

    /// Hidden units, padding included.
    pub(crate) fn units(&self) -> usize {
        self.start(self.hidden.len())
    }

    /// The first unit of a hidden layer.
    pub(crate) fn start(&self, layer: usize) -> usize {
        self.hidden[..layer].iter().map(|l| l.stride).sum()
    }

    /// The first unit of the last hidden layer.
    pub(crate) fn last_start(&self) -> usize {
        self.start(self.hidden.len() - 1)
    }

    /// The hidden layer of a unit.
    pub(crate) fn layer_of(&self, unit: usize) -> usize {
        (1..self.hidden.len()).take_while(|&l| self.start(l) <= unit).count()
    }

    /// Number of weights and biases.
    #[must_use]
    pub fn parameter_count(&self) -> usize {
        let hidden: usize = self.hidden.iter().map(|l| (l.inputs + 1) * l.outputs).sum();
        hidden + self.hidden[self.hidden.len() - 1].outputs + 1
    }

    /// The force at one input `(m_f, m_e, x, ẋ)`, mN, layer by layer.
    #[must_use]
    pub fn force_mn(&self, input: [f64; 4]) -> f64 {
        let mut values = input.to_vec();
        for layer in &self.hidden {
            let mut out = layer.bias.clone();
            for (value, column) in values.iter().zip(layer.columns.chunks_exact(layer.stride)) {
                for (o, w) in out.iter_mut().zip(column) {
                    *o += value * w;
                }
            }
            for o in &mut out {
                *o = if *o > 0.0 { *o } else { self.slope * *o };
            }
            out.truncate(layer.outputs);
            values = out;
        }
        self.output_bias + self.output.iter().zip(&values).map(|(w, v)| w * v).sum::<f64>()
    }

    /// The first layer's pre-activations on a plane, `(α, β, γ)`: they are the same in all patterns.
    pub(crate) fn first_layer(&self, plane: &Plane) -> [Vec<f64>; 3] {
        let first = &self.hidden[0];
        let column = |i: usize| first.columns[i * first.stride..(i + 1) * first.stride].to_vec();
        let mut alpha = first.bias.clone();
        for (i, &value) in plane.origin.iter().enumerate() {
            for (a, w) in alpha.iter_mut().zip(column(i)) {
                *a += w * value;
            }
        }
        [alpha, column(plane.axes[0]), column(plane.axes[1])]
    }
}

/// The last hidden layer's weights row by row, if there is a layer before it.
fn last_rows(hidden: &[Layer]) -> Vec<f64> {
    let [.., before, last] = hidden else { return Vec::new() };
    let mut rows = vec![0.0; last.stride * before.stride];
    for (i, column) in last.columns.chunks_exact(last.stride).enumerate() {
        for (k, w) in column.iter().enumerate() {
            rows[k * before.stride + i] = *w;
        }
    }
    rows
}
