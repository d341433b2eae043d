//! The published weights: consecutive `.npy` records in one file, as `equinox.tree_serialise_leaves`
//! writes them: `W1[96,4] b1[96] W2[96,96] b2[96] W3[1,96] b3[1] params[3] r0 L0`. Any number of
//! layers is read; the activation is not in the file and is taken as LeakyReLU with slope 0.01.

use super::saved_model::{ModelInfo, SavedModel};
use crate::atomic::write_atomic;
use crate::error::{DataError, read_bytes};
use crate::formats::format::{FileFormat, Head};
use crate::formats::npy::{Array, read_npy, write_npy, write_npy_f32};
use pam_core::force::Dense;
use pam_core::{
    Activation, AnyForce, JointModel, Mlp, MuscleGeometry, NetworkForce, RawParameters,
};
use std::path::Path;

/// The format of published weights.
#[derive(Debug)]
pub struct Eqx;

impl FileFormat for Eqx {
    fn id(&self) -> &'static str {
        "eqx"
    }
    fn name(&self) -> &'static str {
        "an .eqx weight file"
    }
    fn recognises(&self, head: &Head<'_>) -> bool {
        head.bytes.starts_with(b"\x93NUMPY") || head.has_extension("eqx")
    }
    fn holds_model(&self) -> bool {
        true
    }
    fn read_model(&self, path: &Path) -> Result<SavedModel, DataError> {
        read(path)
    }
}

/// Reads published weights.
///
/// # Errors
/// [`DataError::File`] naming the record that is missing, damaged or of the wrong shape.
pub fn read(path: impl AsRef<Path>) -> Result<SavedModel, DataError> {
    read_at(path.as_ref())
}

/// One instance, whatever the path is given as.
fn read_at(path: &Path) -> Result<SavedModel, DataError> {
    let bytes = read_bytes(path)?;
    let fail = |message: String| DataError::file(path, message);
    let mut rest = bytes.as_slice();
    let mut records: Vec<Array> = Vec::new();
    while !rest.is_empty() {
        let number = records.len() + 1;
        records.push(read_npy(&mut rest).map_err(|e| fail(format!("record {number}: {e}")))?);
    }
    let count = records.len();
    if count < 5 || count.is_multiple_of(2) {
        return Err(fail(format!(
            "{count} records; a model has a weight and a bias a layer, then 3 parameters, r0 and L0 \
             (the file may be truncated)"
        )));
    }
    let mut layers = Vec::new();
    for (k, pair) in records[..count - 3].chunks_exact(2).enumerate() {
        let (weight, bias) = (&pair[0], &pair[1]);
        if weight.shape.len() != 2 || bias.shape != [weight.shape[0]] {
            return Err(fail(format!(
                "layer {k}: weight of shape {:?} and bias of shape {:?} do not fit",
                weight.shape, bias.shape
            )));
        }
        layers.push(
            Dense::from_rows(&weight.values, bias.values.clone())
                .map_err(|e| fail(format!("layer {k}: {e}")))?,
        );
    }
    let [mass, gas_coefficient, deformation] = records[count - 3].values[..] else {
        return Err(fail(format!(
            "record {} should hold the 3 raw parameters (m, C, nu), its shape is {:?}",
            count - 2,
            records[count - 3].shape
        )));
    };
    let (&[radius_mm], &[length_mm]) =
        (&records[count - 2].values[..], &records[count - 1].values[..])
    else {
        return Err(fail("the last two records should be the scalars r0 and L0".into()));
    };
    if let Some(k) = records.iter().position(|r| r.values.iter().any(|v| !v.is_finite())) {
        return Err(fail(format!("record {} holds a number that is not finite", k + 1)));
    }
    let activation = Activation::from_name("leaky_relu").map_err(|e| fail(e.to_string()))?;
    let force = Mlp::new(layers, activation)
        .and_then(NetworkForce::new)
        .map_err(|e| fail(e.to_string()))?;
    let model = JointModel {
        raw: RawParameters { mass, gas_coefficient, deformation },
        geometry: MuscleGeometry { radius_mm, length_mm },
        auxiliary_damping_kg_s: 0.0,
        force: AnyForce::Network(force),
    };
    model.validate().map_err(|e| fail(e.to_string()))?;
    let name = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    Ok(SavedModel {
        model,
        info: ModelInfo {
            provenance: format!("published weights, file {name}.eqx"),
            name,
            trained: true,
            // The file does not say; the weights that are published were trained on these.
            trained_on: crate::conditions::training_names(),
            effects: Vec::new(),
            rig: None,
            source: Some(path.to_owned()),
        },
    })
}

/// Writes a network model with LeakyReLU and no auxiliary damping in the published format (float32
/// weights, float64 geometry).
///
/// # Errors
/// [`DataError::File`] if the model is none that the format can hold.
pub fn write(path: impl AsRef<Path>, saved: &SavedModel) -> Result<(), DataError> {
    write_at(path.as_ref(), saved)
}

/// One instance, whatever the path is given as.
fn write_at(path: &Path, saved: &SavedModel) -> Result<(), DataError> {
    let fail = |why: &str| DataError::file(path, format!("the .eqx format cannot hold {why}"));
    let AnyForce::Network(force) = &saved.model.force else {
        return Err(fail("a force that is no network"));
    };
    if Activation::from_name("leaky_relu").ok() != Some(*force.mlp().activation()) {
        return Err(fail("an activation other than LeakyReLU with slope 0.01"));
    }
    if saved.model.auxiliary_damping_kg_s != 0.0 {
        return Err(fail("auxiliary damping"));
    }
    if !saved.info.effects.is_empty() {
        return Err(fail("effects of an extended model"));
    }
    let mut out = Vec::new();
    let io = |e: std::io::Error| DataError::io(path, e);
    for layer in force.mlp().layers() {
        let (n, m) = (layer.outputs() as u64, layer.inputs() as u64);
        write_npy_f32(&mut out, &[n, m], &layer.weight_rows()).map_err(io)?;
        write_npy_f32(&mut out, &[n], layer.bias()).map_err(io)?;
    }
    let raw = saved.model.raw;
    write_npy_f32(&mut out, &[3], &[raw.mass, raw.gas_coefficient, raw.deformation]).map_err(io)?;
    for value in [saved.model.geometry.radius_mm, saved.model.geometry.length_mm] {
        write_npy(&mut out, &Array::scalar(value)).map_err(io)?;
    }
    write_atomic(path, &out)
}
