//! The framework's model format: safetensors with metadata, readable from Python.
//!
//! Tensors (float64):
//!
//! | tensor | shape | holds |
//! |---|---|---|
//! | `raw_parameters` | `[3]` | mass, gas coefficient, deformation before softplus |
//! | `geometry` | `[2]` | r0, L0 in mm |
//! | `auxiliary_damping` | `[1]` | B in kg/s |
//! | `weight_k`, `bias_k` | `[outputs, inputs]`, `[outputs]` | layer k of a network |
//! | `spring_damper` | `[4]` | stiffness, stiffness per mass, shift per mass, damping |
//!
//! The last two rows are what the force models themselves give
//! ([`StoredForce`](pam_core::StoredForce)). float32 tensors are read as well.
//!
//! Metadata: `format` = `pam-model`, `format_version`, `force`, `inputs`, `output`, `units`, `sign`,
//! `name`, `provenance`, `trained`, `trained_on` (names of recordings, JSON), `effects` (of an extended model, JSON), `rig` (the rig file of its data, TOML), and the settings of the force: `activation` and
//! `activation_parameters` (JSON) for a network.

use super::saved_model::{ModelInfo, SavedModel};
use crate::atomic::write_atomic;
use crate::error::{DataError, read_bytes};
use crate::formats::format::{FileFormat, Head};
use crate::rig_file::RigFile;
use pam_core::force::{ForceParts, Tensor};
use pam_core::{AnyForce, JointModel, ModelError, MuscleGeometry, RawParameters};
use safetensors::tensor::{Dtype, SafeTensors, TensorView};
use std::collections::HashMap;
use std::path::Path;

/// The format of models of this framework.
#[derive(Debug)]
pub struct Safetensors;

impl FileFormat for Safetensors {
    fn id(&self) -> &'static str {
        "safetensors"
    }
    fn name(&self) -> &'static str {
        "a safetensors file"
    }
    fn recognises(&self, head: &Head<'_>) -> bool {
        // JSON behind its length, which is below 4 GiB; text may have a brace there too.
        let begins = head.bytes.get(4..9) == Some(b"\0\0\0\0{");
        begins || head.has_extension("safetensors")
    }
    fn holds_model(&self) -> bool {
        true
    }
    fn read_model(&self, path: &Path) -> Result<SavedModel, DataError> {
        read(path)
    }
}

const FORMAT: &str = "pam-model";
const VERSION: &str = "1";
const INPUTS: &str = "mass_flexor_g,mass_extensor_g,displacement_mm,velocity_mm_s";
const OUTPUT: &str = "restoring_force_mn";

/// Writes a model. The same model gives the same bytes.
///
/// # Errors
/// [`DataError`] if the file cannot be written.
pub fn write(path: impl AsRef<Path>, saved: &SavedModel) -> Result<(), DataError> {
    write_at(path.as_ref(), saved)
}

/// One instance, whatever the path is given as.
fn write_at(path: &Path, saved: &SavedModel) -> Result<(), DataError> {
    let model = &saved.model;
    let raw = model.raw;
    let vector = |name: &str, values: Vec<f64>| {
        (name.to_owned(), Tensor { shape: vec![values.len()], values })
    };
    let mut tensors = vec![
        vector("raw_parameters", vec![raw.mass, raw.gas_coefficient, raw.deformation]),
        vector("geometry", vec![model.geometry.radius_mm, model.geometry.length_mm]),
        vector("auxiliary_damping", vec![model.auxiliary_damping_kg_s]),
    ];
    let mut meta: Vec<(&str, String)> = vec![
        ("format", FORMAT.into()),
        ("format_version", VERSION.into()),
        ("force", model.force.kind().into()),
        ("inputs", INPUTS.into()),
        ("output", OUTPUT.into()),
        ("units", "mm, mm/s, kPa absolute, g, mN, kg, s".into()),
        ("sign", "restoring: m x'' = F_e - f - B x'".into()),
        ("name", saved.info.name.clone()),
        ("provenance", saved.info.provenance.clone()),
        ("trained", saved.info.trained.to_string()),
        ("trained_on", serde_json::json!(saved.info.trained_on).to_string()),
    ];
    if !saved.info.effects.is_empty() {
        meta.push(("effects", serde_json::json!(saved.info.effects).to_string()));
    }
    if let Some(rig) = &saved.info.rig {
        meta.push(("rig", rig.to_toml()));
    }
    let parts = model.force.to_parts();
    tensors.extend(parts.tensors);
    meta.extend(parts.settings.iter().map(|(k, v)| (k.as_str(), v.clone())));
    write_atomic(path, &serialise(&tensors, &meta))
}

/// Safetensors bytes with metadata in the given order. (The library keeps metadata in a hash map,
/// whose order, and with it the file, would change from run to run.)
fn serialise(tensors: &[(String, Tensor)], meta: &[(&str, String)]) -> Vec<u8> {
    let mut header = serde_json::Map::new();
    let metadata: serde_json::Map<String, serde_json::Value> =
        meta.iter().map(|(k, v)| ((*k).to_owned(), v.clone().into())).collect();
    header.insert("__metadata__".into(), metadata.into());
    let mut offset = 0;
    for (name, Tensor { shape, values }) in tensors {
        let end = offset + 8 * values.len();
        header.insert(
            name.clone(),
            serde_json::json!({"dtype": "F64", "shape": shape, "data_offsets": [offset, end]}),
        );
        offset = end;
    }
    let mut json = serde_json::Value::from(header).to_string().into_bytes();
    // The format wants the data aligned to eight bytes.
    json.resize(json.len().next_multiple_of(8), b' ');
    let mut out = (json.len() as u64).to_le_bytes().to_vec();
    out.extend_from_slice(&json);
    for (_, tensor) in tensors {
        out.extend(tensor.values.iter().flat_map(|v| v.to_le_bytes()));
    }
    out
}

/// Reads a model.
///
/// # Errors
/// [`DataError::File`] naming the tensor or metadata entry that is missing or wrong.
pub fn read(path: impl AsRef<Path>) -> Result<SavedModel, DataError> {
    read_at(path.as_ref())
}

/// One instance, whatever the path is given as.
fn read_at(path: &Path) -> Result<SavedModel, DataError> {
    parse(path, &read_bytes(path)?)
}

/// Reads a model from memory; `path` is for messages.
///
/// # Errors
/// As [`read`].
pub fn parse(path: impl AsRef<Path>, bytes: &[u8]) -> Result<SavedModel, DataError> {
    parse_at(path.as_ref(), bytes)
}

/// One instance, whatever the path is given as.
fn parse_at(path: &Path, bytes: &[u8]) -> Result<SavedModel, DataError> {
    let fail = |message: String| DataError::file(path, message);
    let file = SafeTensors::deserialize(bytes)
        .map_err(|e| fail(format!("not a readable safetensors file ({e}); it may be truncated")))?;
    let (_, header) = SafeTensors::read_metadata(bytes).map_err(|e| fail(e.to_string()))?;
    let meta: HashMap<String, String> = header.metadata().clone().unwrap_or_default();
    let entry = |key: &str| meta.get(key).map(String::as_str);
    if entry("format") != Some(FORMAT) {
        return Err(fail(format!(
            "safetensors, but not a model of this framework (metadata `format` is {:?}, not \
             `{FORMAT}`)",
            entry("format").unwrap_or("absent")
        )));
    }
    if entry("format_version") != Some(VERSION) {
        return Err(fail(format!(
            "model format version {:?}; this program reads version {VERSION}",
            entry("format_version").unwrap_or("absent")
        )));
    }
    if entry("inputs") != Some(INPUTS) || entry("output") != Some(OUTPUT) {
        return Err(fail(format!(
            "the model's inputs are `{}` and its output `{}`; a force of this joint maps `{INPUTS}` \
             to `{OUTPUT}`",
            entry("inputs").unwrap_or("absent"),
            entry("output").unwrap_or("absent")
        )));
    }
    let mut parts = ForceParts {
        tensors: Vec::new(),
        settings: meta.iter().map(|(k, v)| (k.clone(), v.clone())).collect(),
    };
    for name in file.names() {
        let view = file.tensor(name).map_err(|e| fail(format!("tensor `{name}`: {e}")))?;
        let values = numbers(&view).map_err(|e| fail(format!("tensor `{name}`: {e}")))?;
        parts.push_tensor(name, view.shape().to_vec(), values);
    }
    let in_file = |e: ModelError| fail(e.to_string());
    let force =
        AnyForce::from_parts(entry("force").unwrap_or("absent"), &parts).map_err(in_file)?;
    let [mass, gas_coefficient, deformation] = parts.vector("raw_parameters").map_err(in_file)?;
    let [radius_mm, length_mm] = parts.vector("geometry").map_err(in_file)?;
    let [auxiliary_damping_kg_s] = parts.vector("auxiliary_damping").map_err(in_file)?;
    let model = JointModel {
        raw: RawParameters { mass, gas_coefficient, deformation },
        geometry: MuscleGeometry { radius_mm, length_mm },
        auxiliary_damping_kg_s,
        force,
    };
    model.validate().map_err(|e| fail(e.to_string()))?;
    let effects = match entry("effects") {
        None => Vec::new(),
        Some(json) => serde_json::from_str(json)
            .map_err(|e| fail(format!("metadata `effects` cannot be read: {e}")))?,
    };
    let rig = entry("rig").map(|toml| RigFile::parse(toml, path)).transpose()?;
    Ok(SavedModel {
        model,
        info: ModelInfo {
            name: entry("name").unwrap_or_default().to_owned(),
            provenance: entry("provenance").unwrap_or_default().to_owned(),
            trained: entry("trained") == Some("true"),
            trained_on: entry("trained_on")
                .and_then(|names| serde_json::from_str(names).ok())
                .unwrap_or_default(),
            effects,
            rig,
            source: Some(path.to_owned()),
        },
    })
}

fn numbers(view: &TensorView<'_>) -> Result<Vec<f64>, String> {
    let data = view.data();
    let values: Vec<f64> = match view.dtype() {
        Dtype::F64 => data
            .chunks_exact(8)
            .map(|b| f64::from_le_bytes(b.try_into().expect("eight bytes")))
            .collect(),
        Dtype::F32 => data
            .chunks_exact(4)
            .map(|b| f64::from(f32::from_le_bytes(b.try_into().expect("four bytes"))))
            .collect(),
        other => return Err(format!("numbers of type {other:?}; F64 or F32 is needed")),
    };
    if values.iter().any(|v| !v.is_finite()) {
        return Err("holds a number that is not finite".into());
    }
    Ok(values)
}
