use super::{Dense, ForceInput, ForceModel, ForceParts, Mlp, ReluLayers, StoredForce};
use crate::activation::{Activation, ActivationFunction};
use crate::error::ModelError;
use crate::scalar::Scalar;
use std::any::Any;

/// A learned restoring force: a network with inputs `(m_f, m_e, x, ẋ)`, unscaled, and one output in
/// mN. The order is that of the published weights.
#[derive(Debug, Clone, PartialEq)]
pub struct NetworkForce<S, A = Activation> {
    mlp: Mlp<S, A>,
}

impl<S: Scalar, A: ActivationFunction> NetworkForce<S, A> {
    /// Number of inputs of a force network: `(m_f, m_e, x, ẋ)`.
    pub const INPUTS: usize = 4;

    /// Takes a network with four inputs and one output.
    ///
    /// # Errors
    /// [`ModelError::Shape`] for any other network.
    pub fn new(mlp: Mlp<S, A>) -> Result<Self, ModelError> {
        if mlp.inputs() != Self::INPUTS || mlp.outputs() != 1 {
            return Err(ModelError::Shape(format!(
                "a force network maps 4 inputs (m_f, m_e, x, v) to 1 force, this one maps {} to {}",
                mlp.inputs(),
                mlp.outputs()
            )));
        }
        Ok(Self { mlp })
    }

    /// The network itself.
    #[must_use]
    pub fn mlp(&self) -> &Mlp<S, A> {
        &self.mlp
    }

    /// The same force with other numbers, weight by weight.
    pub fn map<T: Scalar>(&self, f: impl FnMut(S) -> T) -> NetworkForce<T, A> {
        NetworkForce { mlp: self.mlp.map(f) }
    }
}

impl<S: Scalar, A: ActivationFunction> ForceModel<S> for NetworkForce<S, A> {
    fn restoring_force_mn(&self, input: &ForceInput<S>, work: &mut [S]) -> S {
        let features = [
            input.mass_flexor_g,
            input.mass_extensor_g,
            input.displacement_mm,
            input.velocity_mm_s,
        ];
        let mut force = [S::zero()];
        self.mlp.forward_into(&features, &mut force, work);
        force[0]
    }

    fn work_len(&self) -> usize {
        self.mlp.work_len()
    }

    fn relu_layers(&self) -> Option<ReluLayers<'_, S>> {
        let layers = self.mlp.layers();
        let slope = self.mlp.activation().relu_slope()?;
        (layers.len() > 1).then_some(ReluLayers { layers, slope })
    }

    fn network(&self) -> Option<&NetworkForce<S>> {
        (self as &dyn Any).downcast_ref()
    }
}

impl NetworkForce<f64> {
    /// The same network with other numbers in its last layer.
    fn with_output(&self, weight: impl Fn(f64) -> f64, bias: impl Fn(f64) -> f64) -> Option<Self> {
        let (last, before) = self.mlp.layers().split_last()?;
        let weights: Vec<f64> = last.weight_rows().into_iter().map(weight).collect();
        let biases = last.bias().iter().copied().map(bias).collect();
        let mut layers = before.to_vec();
        layers.push(Dense::from_rows(&weights, biases).ok()?);
        Self::new(Mlp::new(layers, *self.mlp.activation()).ok()?).ok()
    }
}

/// Tensors `weight_k` of shape `[outputs, inputs]` and `bias_k` of shape `[outputs]` for each layer;
/// settings `activation` (name) and `activation_parameters` (JSON).
impl StoredForce for NetworkForce<f64> {
    fn scaled(&self, factor: f64) -> Option<Self> {
        self.with_output(|w| factor * w, |b| factor * b)
    }

    fn shifted(&self, offset_mn: f64) -> Option<Self> {
        self.with_output(|w| w, |b| b + offset_mn)
    }

    fn to_parts(&self) -> ForceParts {
        let mut parts = ForceParts::default();
        for (k, layer) in self.mlp.layers().iter().enumerate() {
            let (outputs, inputs) = (layer.outputs(), layer.inputs());
            parts.push_tensor(format!("weight_{k}"), vec![outputs, inputs], layer.weight_rows());
            parts.push_tensor(format!("bias_{k}"), vec![outputs], layer.bias().to_vec());
        }
        let activation = self.mlp.activation();
        parts.settings = vec![
            ("activation".into(), activation.name().into()),
            ("activation_parameters".into(), activation.parameters_json()),
        ];
        parts
    }

    fn from_parts(parts: &ForceParts) -> Result<Self, ModelError> {
        let mut layers = Vec::new();
        while let Some(weight) = parts.tensor(&format!("weight_{}", layers.len())) {
            let k = layers.len();
            let bias = parts.require(&format!("bias_{k}"))?;
            if weight.shape.len() != 2 || bias.shape != [weight.shape[0]] {
                return Err(ModelError::Shape(format!(
                    "layer {k}: weight of shape {:?} and bias of shape {:?} do not fit",
                    weight.shape, bias.shape
                )));
            }
            layers.push(Dense::from_rows(&weight.values, bias.values.clone())?);
        }
        let name = parts.setting("activation").unwrap_or("absent");
        let activation = match parts.setting("activation_parameters") {
            Some(json) => Activation::from_name_and_json(name, json)?,
            None => Activation::from_name(name)?,
        };
        Self::new(Mlp::new(layers, activation)?)
    }

    fn describe(&self) -> String {
        let inputs = self.mlp.layers().iter().map(Dense::inputs);
        let widths: Vec<String> =
            inputs.chain([self.mlp.outputs()]).map(|width| width.to_string()).collect();
        format!("network {} with {}", widths.join("–"), self.mlp.activation())
    }
}
