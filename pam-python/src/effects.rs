//! The effects of models, and those that the virtual rig can hide.

use crate::errors::{effect, raised};
use pam_effects::effects::{EffectInfo, register};
use pam_effects::expression;
use pyo3::prelude::*;
use serde_json::{Value, json};
use std::path::PathBuf;

/// Descriptions as JSON, each with the text that defines it if it is an expression.
fn list<'a>(infos: impl Iterator<Item = (&'a EffectInfo, Option<&'a str>)>) -> String {
    let one = |(info, definition): (&EffectInfo, Option<&str>)| {
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
            "definition": definition,
        })
    };
    Value::Array(infos.map(one).collect()).to_string()
}

/// Makes the effects of a text or of a file known to models, diagnoses and the virtual rig, each of which evaluates them on its
/// own; returns their descriptions as JSON.
#[pyfunction]
pub(crate) fn define_effects(text: Option<&str>, path: Option<PathBuf>) -> PyResult<String> {
    let read = match (text, &path) {
        (Some(text), _) => expression::parse(text),
        (None, path) => expression::load(path.clone().unwrap_or_default()),
    };
    let found = read.map_err(raised)?;
    // The rig keeps what it reads; a model's effects are registered once it has.
    match (text, path) {
        (Some(text), _) => drop(pam_rig::effects::expression::read(text).map_err(effect)?),
        (None, path) => {
            drop(pam_rig::effects::expression::load(path.unwrap_or_default()).map_err(raised)?);
        }
    }
    found.iter().try_for_each(|e| register(*e)).map_err(raised)?;
    Ok(list(found.iter().map(|e| (e.info(), e.definition()))))
}

/// The effects that models can have and diagnoses can name, as JSON.
#[pyfunction]
pub(crate) fn effect_list() -> String {
    let all = pam_effects::effects::all();
    list(all.into_iter().map(|e| (e.info(), e.definition())))
}

/// The effects that the virtual rig can hide, as JSON.
#[pyfunction]
pub(crate) fn hidden_effect_list() -> String {
    let own = pam_rig::effects::ALL.iter().map(|e| (e.info, None));
    let defined = pam_rig::effects::expression::known();
    list(own.chain(defined.iter().map(|e| (e.info, Some(e.text.as_str())))))
}
