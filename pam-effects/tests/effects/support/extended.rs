//! The model that comes with the program, with effects.

use pam_core::{AnyForce, JointModel};
use pam_data::{ModelInfo, load_model};
use pam_effects::effects::by_id;
use pam_effects::{ActiveEffect, ExtendedModel};
use std::path::Path;

/// The model that comes with the program: a smooth network, whose loss has derivatives everywhere.
pub(crate) fn smooth() -> JointModel<f64, AnyForce<f64>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../pam-cli/models/default.safetensors");
    load_model(&path).expect("the default model").model
}

/// The model with effects.
pub(crate) fn extended(effects: &[(&str, Vec<f64>)]) -> ExtendedModel {
    let active = effects.iter().map(|(id, values)| ActiveEffect {
        effect: by_id(id).expect("an id"),
        values: values.clone(),
    });
    plain().with(active)
}

/// The model with one effect.
pub(crate) fn extended_by(effect: ActiveEffect) -> ExtendedModel {
    plain().with([effect])
}

fn plain() -> ExtendedModel {
    ExtendedModel { joint: smooth(), info: ModelInfo::default(), effects: Vec::new() }
}
