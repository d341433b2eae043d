//! The published network.

use super::model::GruModel;
use super::network::Network;
use super::parameters::{INPUTS, OUTPUTS, Shape};
use super::scaling::Scaling;
use crate::error::BaselineError;
use crate::pytorch::Checkpoint;
use std::path::Path;

/// Reads the published checkpoint (`gru_model_1_checkpoint.pt`): arrays of `model_state`, scalers and
/// lengths.
///
/// # Errors
/// [`BaselineError`] if the file is no checkpoint, or an array is missing or of another shape.
pub fn read_checkpoint(path: &Path) -> Result<GruModel, BaselineError> {
    let fail = |message: String| BaselineError::file(path, message);
    let checkpoint = Checkpoint::open(path)?;
    let size = |name: &str| {
        checkpoint
            .int(name)
            .and_then(|v| usize::try_from(v).ok())
            .ok_or_else(|| fail(format!("there is no size `{name}`")))
    };
    let shape = Shape { hidden: size("hidden_dim")?, layers: size("num_layers")? };
    if shape.hidden == 0 || !shape.hidden.is_multiple_of(16) || shape.layers == 0 {
        return Err(fail(format!(
            "{} layers of {} are not supported; the width must be a multiple of 16",
            shape.layers, shape.hidden
        )));
    }
    let tensors = checkpoint.tensors("model_state")?;
    let mut numbers = Vec::with_capacity(shape.len());
    for part in shape.parts() {
        let tensor = tensors
            .get(&part.name)
            .ok_or_else(|| fail(format!("`model_state` has no `{}`", part.name)))?;
        if tensor.shape != part.shape {
            return Err(fail(format!(
                "`{}` has shape {:?}, not {:?}",
                part.name, tensor.shape, part.shape
            )));
        }
        numbers.extend(tensor.values.iter().map(|v| f64::from(*v)));
    }
    let five = |name: &str| -> Result<[f64; INPUTS], BaselineError> {
        let values = checkpoint.vector(name)?;
        let values: [f32; INPUTS] =
            values.try_into().map_err(|_| fail(format!("`{name}` must hold {INPUTS} numbers")))?;
        Ok(values.map(f64::from))
    };
    let scaling = Scaling { low: five("input_scaler_min")?, high: five("input_scaler_max")? };
    for (name, own) in [("output_scaler_min", scaling.low), ("output_scaler_max", scaling.high)] {
        let output: Vec<f64> = checkpoint.vector(name)?.into_iter().map(f64::from).collect();
        if output[..] != own[..OUTPUTS] {
            return Err(fail(format!("`{name}` differs from that of the inputs")));
        }
    }
    Ok(GruModel {
        network: Network::new(shape, &numbers),
        numbers,
        scaling,
        warm_up: size("seq_len")?,
        samples_per_step: 1,
        step_s: None,
        history: None,
    })
}
