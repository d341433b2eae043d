//! The effects of models, and those that the virtual rig can hide.

use pyo3::prelude::*;
use serde_json::{Value, json};

fn list<'a>(infos: impl Iterator<Item = &'a pam_effects::effects::EffectInfo>) -> String {
    let one = |info: &pam_effects::effects::EffectInfo| {
        json!({
            "id": info.id,
            "group": info.group.label(),
            "description": info.description,
            "excited_by": info.excited_by,
            "parameters": info.parameters.iter().map(|p| json!({
                "name": p.name,
                "meaning": p.meaning,
                "range": p.range,
                "off": p.off,
            })).collect::<Vec<_>>(),
            "switches": info.switches.iter().map(|s| json!({
                "name": s.name,
                "meaning": s.meaning,
            })).collect::<Vec<_>>(),
        })
    };
    Value::Array(infos.map(one).collect()).to_string()
}

/// The effects that models can have and diagnoses can name, as JSON.
#[pyfunction]
pub(crate) fn effect_list() -> String {
    list(pam_effects::effects::all().into_iter().map(|e| e.info()))
}

/// The effects that the virtual rig can hide, as JSON.
#[pyfunction]
pub(crate) fn hidden_effect_list() -> String {
    list(pam_rig::effects::ALL.iter().map(|e| e.info))
}
