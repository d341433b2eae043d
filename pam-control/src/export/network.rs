use crate::error::ControlError;
use pam_core::{Activation, JointModel, NetworkForce};
use pam_embedded::network::{MAGIC, VERSION};

/// Float of an exported network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Precision {
    /// Four bytes a number.
    F32,
    /// Eight bytes a number.
    F64,
}

/// A model as the bytes of a [`pam_embedded::Network`].
///
/// # Errors
/// [`ControlError::Spec`] if the evaluator does not know the network's activation.
pub fn network_bytes<F>(
    model: &JointModel<f64, F>,
    force: &NetworkForce<f64>,
    precision: Precision,
) -> Result<Vec<u8>, ControlError> {
    let layers = force.mlp().layers();
    let activation = embedded(force.mlp().activation())?;
    let parameter = match activation {
        pam_embedded::Activation::LeakyRelu(slope) => slope,
        _ => 0.0,
    };
    let size = if precision == Precision::F32 { 4 } else { 8 };
    let mut bytes = MAGIC.to_vec();
    for number in [VERSION, activation.number(), size, layers.len() as u32] {
        bytes.extend_from_slice(&number.to_le_bytes());
    }
    let p = model.physical();
    let (radius, length) = (model.geometry.radius_mm, model.geometry.length_mm);
    for number in [parameter, p.mass_kg, p.gas_coefficient, p.deformation, radius, length] {
        bytes.extend_from_slice(&number.to_le_bytes());
    }
    for layer in layers {
        for number in [layer.inputs() as u32, layer.outputs() as u32] {
            bytes.extend_from_slice(&number.to_le_bytes());
        }
    }
    for layer in layers {
        for value in layer.weight_rows().iter().chain(layer.bias()) {
            match precision {
                Precision::F32 => bytes.extend_from_slice(&(*value as f32).to_le_bytes()),
                Precision::F64 => bytes.extend_from_slice(&value.to_le_bytes()),
            }
        }
    }
    Ok(bytes)
}

/// The evaluator's activation for a model's.
fn embedded(activation: &Activation) -> Result<pam_embedded::Activation, ControlError> {
    use pam_embedded::Activation as Embedded;
    // An activation that is added to the models need not be one of the evaluator.
    #[allow(unreachable_patterns)]
    Ok(match activation {
        Activation::LeakyRelu(a) => Embedded::LeakyRelu(a.slope),
        Activation::Relu(_) => Embedded::LeakyRelu(0.0),
        Activation::Tanh(_) => Embedded::Tanh,
        Activation::Softplus(_) => Embedded::Softplus,
        Activation::Silu(_) => Embedded::Silu,
        Activation::Gelu(_) => Embedded::Gelu,
        Activation::Elu(_) => Embedded::Elu,
        Activation::Sine(_) => Embedded::Sine,
        other => {
            return Err(ControlError::Spec {
                text: other.name().to_owned(),
                why: "the evaluator for microcontrollers does not have this activation; add it to \
                      pam-embedded/src/activation.rs, or export the table alone"
                    .into(),
            });
        }
    })
}
