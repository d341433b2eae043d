//! Extended models in files, and what is refused.

use crate::support::joint::linear;
use crate::support::values::medium;
use pam_data::ModelInfo;
use pam_data::models::{load_model, save_model};
use pam_effects::EffectError;
use pam_effects::effects::{ALL, by_id};
use pam_effects::{ActiveEffect, EffectRecord, ExtendedModel};

#[test]
fn an_extended_model_comes_back_from_its_file() {
    let plain = ExtendedModel {
        joint: linear(),
        info: ModelInfo { name: "m".into(), ..ModelInfo::default() },
        effects: Vec::new(),
    };
    // Numbers that no short decimal holds.
    let effects = medium().into_iter().map(|(id, values)| ActiveEffect {
        effect: by_id(id).expect("an id"),
        values: values
            .iter()
            .map(|v| if v.fract() == 0.0 { *v } else { v * (1.0 / 3.0) })
            .collect(),
    });
    let model = plain.with(effects);
    let folder = tempfile::tempdir().expect("a folder");
    let paths = [folder.path().join("a.safetensors"), folder.path().join("b.safetensors")];
    save_model(&paths[0], &model.to_saved()).expect("written");
    let back =
        ExtendedModel::from_saved(load_model(&paths[0]).expect("read")).expect("known effects");
    assert_eq!(back.joint, model.joint);
    assert_eq!(back.effects.len(), model.effects.len());
    for (a, b) in back.effects.iter().zip(&model.effects) {
        assert_eq!(a.effect.info().id, b.effect.info().id);
        assert_eq!(a.values, b.values, "{}", a.effect.info().id);
    }
    assert_eq!(back.describe_effects(), model.describe_effects());
    save_model(&paths[1], &back.to_saved()).expect("written");
    let [first, second] = paths.map(|p| std::fs::read(p).expect("there"));
    assert!(first == second, "the bytes differ");
}

fn stored(id: &str, values: &[(&str, f64)]) -> EffectRecord {
    EffectRecord {
        effect: id.into(),
        values: values.iter().map(|(k, v)| ((*k).to_owned(), *v)).collect(),
        definition: None,
    }
}

/// Every refusal names the effect, the value, and what would do.
#[test]
fn wrong_effects_are_refused_by_name() {
    let cases: [(EffectRecord, &[&str]); 4] = [
        (
            stored("columb_friction", &[("force_n", 1.0)]),
            &["no effect `columb_friction`", "coulomb_friction"],
        ),
        (stored("creep", &[("stiffness_n_mm", 1.0)]), &["time_constant_s", "missing"]),
        (
            stored("coulomb_friction", &[("force_n", 1.0), ("force_kn", 1.0)]),
            &["force_kn", "force_n"],
        ),
        (stored("coulomb_friction", &[("force_n", f64::NAN)]), &["force_n", "NaN"]),
    ];
    for (effect, words) in cases {
        match effect.resolve(ALL) {
            Err(error @ (EffectError::Vocabulary(_) | EffectError::Unknown { .. })) => {
                let message = error.to_string();
                assert!(message.contains(&format!("effect `{}`", effect.effect)));
                for word in words {
                    assert!(message.contains(word), "{message}");
                }
            }
            other => panic!("{} was not refused: {other:?}", effect.effect),
        }
    }
    let mut saved =
        ExtendedModel { joint: linear(), info: ModelInfo::default(), effects: Vec::new() }
            .to_saved();
    saved.info.effects.push(serde_json::json!(stored("phlogiston", &[])));
    assert!(matches!(ExtendedModel::from_saved(saved), Err(EffectError::Unknown { .. })));
}

/// A switch that is not mentioned is off.
#[test]
fn switches_may_be_left_out() {
    let active = stored("polytropic_gas", &[("exponent", 1.2)]).resolve(ALL);
    assert_eq!(active.expect("valid").values, [1.2, 0.0]);
}
