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
//! float32 tensors are read as well.
//!
//! Metadata: `format` = `pam-model`, `format_version`, `force`, `activation`,
//! `activation_parameters` (JSON), `inputs`, `output`, `units`, `sign`, `name`, `provenance`,
//! `trained`.

use super::{ModelInfo, SavedModel};
use crate::atomic::write_atomic;
use crate::error::{DataError, read_bytes};
use pam_core::force::Dense;
use pam_core::{
    Activation, AnyForce, JointModel, Mlp, MuscleGeometry, NetworkForce, RawParameters,
    SpringDamper,
};
use safetensors::tensor::{Dtype, SafeTensors, TensorView};
use std::collections::HashMap;
use std::path::Path;

const FORMAT: &str = "pam-model";
const VERSION: &str = "1";
const INPUTS: &str = "mass_flexor_g,mass_extensor_g,displacement_mm,velocity_mm_s";
const OUTPUT: &str = "restoring_force_mn";

/// Writes a model. The same model gives the same bytes.
///
/// # Errors
/// [`DataError`] if the file cannot be written.
pub fn write(path: &Path, saved: &SavedModel) -> Result<(), DataError> {
    let model = &saved.model;
    let raw = model.raw;
    let mut tensors: Vec<(String, Vec<usize>, Vec<f64>)> = vec![
        ("raw_parameters".into(), vec![3], vec![raw.mass, raw.gas_coefficient, raw.deformation]),
        ("geometry".into(), vec![2], vec![model.geometry.radius_mm, model.geometry.length_mm]),
        ("auxiliary_damping".into(), vec![1], vec![model.auxiliary_damping_kg_s]),
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
    ];
    match &model.force {
        AnyForce::Network(force) => {
            for (k, layer) in force.mlp().layers().iter().enumerate() {
                let shape = vec![layer.outputs(), layer.inputs()];
                tensors.push((format!("weight_{k}"), shape, layer.weight_rows()));
                tensors.push((format!("bias_{k}"), vec![layer.outputs()], layer.bias().to_vec()));
            }
            let activation = force.mlp().activation();
            meta.push(("activation", activation.name().into()));
            let json = serde_json::to_value(activation).unwrap_or_default();
            let parameters = json.get(activation.name()).cloned().unwrap_or_default();
            meta.push(("activation_parameters", parameters.to_string()));
        }
        AnyForce::SpringDamper(s) => tensors.push((
            "spring_damper".into(),
            vec![4],
            vec![
                s.stiffness_mn_mm,
                s.stiffness_per_mass_mn_mm_g,
                s.shift_per_mass_mm_g,
                s.damping_kg_s,
            ],
        )),
    }
    write_atomic(path, &serialise(&tensors, &meta))
}

/// Safetensors bytes with metadata in the given order. (The library keeps metadata in a hash map,
/// whose order, and with it the file, would change from run to run.)
fn serialise(tensors: &[(String, Vec<usize>, Vec<f64>)], meta: &[(&str, String)]) -> Vec<u8> {
    let mut header = serde_json::Map::new();
    let metadata: serde_json::Map<String, serde_json::Value> =
        meta.iter().map(|(k, v)| ((*k).to_owned(), v.clone().into())).collect();
    header.insert("__metadata__".into(), metadata.into());
    let mut offset = 0;
    for (name, shape, values) in tensors {
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
    for (_, _, values) in tensors {
        out.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    }
    out
}

/// Reads a model.
///
/// # Errors
/// [`DataError::File`] naming the tensor or metadata entry that is missing or wrong.
pub fn read(path: &Path) -> Result<SavedModel, DataError> {
    let bytes = read_bytes(path)?;
    let fail = |message: String| DataError::file(path, message);
    let file = SafeTensors::deserialize(&bytes)
        .map_err(|e| fail(format!("not a readable safetensors file ({e}); it may be truncated")))?;
    let (_, header) = SafeTensors::read_metadata(&bytes).map_err(|e| fail(e.to_string()))?;
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
    let tensor = |name: &str| {
        let view = file.tensor(name).map_err(|_| fail(format!("tensor `{name}` is missing")))?;
        let values = numbers(&view).map_err(|e| fail(format!("tensor `{name}`: {e}")))?;
        Ok::<_, DataError>((view.shape().to_vec(), values))
    };
    let fixed = |name: &str, len: usize| {
        let (shape, values) = tensor(name)?;
        if values.len() == len {
            Ok(values)
        } else {
            Err(fail(format!("tensor `{name}` has shape {shape:?}, not [{len}]")))
        }
    };
    let force = match entry("force") {
        Some("mlp") => {
            let mut layers = Vec::new();
            while file.tensor(&format!("weight_{}", layers.len())).is_ok() {
                let k = layers.len();
                let (shape, weight) = tensor(&format!("weight_{k}"))?;
                let (_, bias) = tensor(&format!("bias_{k}"))?;
                if shape.len() != 2 || shape[0] != bias.len() {
                    return Err(fail(format!(
                        "layer {k}: weight of shape {shape:?} and bias of {} do not fit",
                        bias.len()
                    )));
                }
                layers.push(Dense::from_rows(&weight, bias).map_err(|e| fail(e.to_string()))?);
            }
            let activation = read_activation(
                entry("activation").unwrap_or("absent"),
                entry("activation_parameters"),
            )
            .map_err(fail)?;
            let network = Mlp::new(layers, activation)
                .and_then(NetworkForce::new)
                .map_err(|e| fail(e.to_string()))?;
            AnyForce::Network(network)
        }
        Some("spring_damper") => {
            let v = fixed("spring_damper", 4)?;
            AnyForce::SpringDamper(SpringDamper {
                stiffness_mn_mm: v[0],
                stiffness_per_mass_mn_mm_g: v[1],
                shift_per_mass_mm_g: v[2],
                damping_kg_s: v[3],
            })
        }
        other => {
            return Err(fail(format!(
                "unknown force `{}`; known: mlp, spring_damper",
                other.unwrap_or("absent")
            )));
        }
    };
    let raw = fixed("raw_parameters", 3)?;
    let geometry = fixed("geometry", 2)?;
    let model = JointModel {
        raw: RawParameters { mass: raw[0], gas_coefficient: raw[1], deformation: raw[2] },
        geometry: MuscleGeometry { radius_mm: geometry[0], length_mm: geometry[1] },
        auxiliary_damping_kg_s: fixed("auxiliary_damping", 1)?[0],
        force,
    };
    model.validate().map_err(|e| fail(e.to_string()))?;
    Ok(SavedModel {
        model,
        info: ModelInfo {
            name: entry("name").unwrap_or_default().to_owned(),
            provenance: entry("provenance").unwrap_or_default().to_owned(),
            trained: entry("trained") == Some("true"),
            source: Some(path.to_owned()),
        },
    })
}

fn read_activation(name: &str, parameters: Option<&str>) -> Result<Activation, String> {
    let default = Activation::from_name(name).map_err(|e| e.to_string())?;
    let Some(text) = parameters else { return Ok(default) };
    let inner: serde_json::Value =
        serde_json::from_str(text).map_err(|e| format!("activation_parameters: {e}"))?;
    serde_json::from_value(serde_json::json!({ name: inner }))
        .map_err(|e| format!("activation_parameters of {name}: {e}"))
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
