//! Formats survive the round trip and are what outsiders can read.

use pam_core::force::Dense;
use pam_core::{Activation, AnyForce, JointModel, Mlp, NetworkForce, SpringDamper};
use pam_data::formats::{csv_columns, npz_columns};
use pam_data::models::save_model;
use pam_data::{LoadOptions, ModelInfo, SavedModel, load_model, open_recordings};
use pam_tests::{published, published_weights, small_csv};
use std::path::Path;

#[test]
fn csv_and_npz_keep_every_digit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.csv");
    // A byte-order mark, as spreadsheets write it, does no harm.
    std::fs::write(&path, format!("\u{feff}{}", small_csv(500))).unwrap();
    let original = open_recordings(&path, &LoadOptions::default()).unwrap().remove(0);
    assert_eq!(original.given_masses.unwrap().flexor_g, 0.0765);
    assert!((original.force_mn[100] / 1000.0 - 55.0 * (0.6_f64 + 0.3).sin()).abs() < 1e-12);
    for name in ["again.csv", "again.npz"] {
        let other = folder.path().join(name);
        match name {
            "again.csv" => csv_columns::write(&other, &original).unwrap(),
            _ => npz_columns::write(&other, &original).unwrap(),
        }
        let back = open_recordings(&other, &LoadOptions::default()).unwrap().remove(0);
        assert_eq!(back.time_s, original.time_s, "{name}");
        assert_eq!(back.displacement_mm, original.displacement_mm, "{name}");
        assert_eq!(back.velocity_mm_s, original.velocity_mm_s, "{name}");
        assert_eq!(back.pressure_extensor_kpa, original.pressure_extensor_kpa, "{name}");
        assert_eq!(back.given_masses, original.given_masses, "{name}");
        for (a, b) in back.force_mn.iter().zip(&original.force_mn) {
            assert!((a - b).abs() <= 1e-10 * b.abs());
        }
    }
}

/// The velocity of a CSV is the file's, unless preprocessing is asked for.
#[test]
fn csv_is_taken_as_it_is_unless_preprocessing_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.csv");
    let text = small_csv(500).replace(",1.8,", ",99.5,");
    std::fs::write(&path, text).unwrap();
    let plain = open_recordings(&path, &LoadOptions::default()).unwrap().remove(0);
    assert_eq!(plain.velocity_mm_s[0], 99.5);
    let options = LoadOptions { preprocess: true, ..LoadOptions::default() };
    let filtered = open_recordings(&path, &options).unwrap().remove(0);
    assert!(filtered.velocity_mm_s[0] < 5.0);
    assert!((filtered.velocity_mm_s[250] - plain.velocity_mm_s[250]).abs() < 0.01);
}

#[test]
fn models_survive_both_formats() {
    let folder = tempfile::tempdir().unwrap();
    let published = load_model(published_weights()).unwrap();
    let own = folder.path().join("model.safetensors");
    save_model(&own, &published).unwrap();
    let back = load_model(&own).unwrap();
    assert_eq!(back.model, published.model);
    assert!(back.info.trained);
    let eqx = folder.path().join("model.eqx");
    save_model(&eqx, &back).unwrap();
    assert_eq!(load_model(&eqx).unwrap().model, published.model);
    save_model(folder.path().join("twice.safetensors"), &published).unwrap();
    let twice = std::fs::read(folder.path().join("twice.safetensors")).unwrap();
    assert_eq!(std::fs::read(&own).unwrap(), twice, "the same model gives the same bytes");
}

/// Any network and any named force is stored, with its settings.
#[test]
fn other_models_survive_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.safetensors");
    let value = |k: usize| (k as f64 * 0.7).sin();
    let layer = |outputs: usize, inputs: usize| {
        let weights: Vec<f64> = (0..outputs * inputs).map(value).collect();
        Dense::from_rows(&weights, (0..outputs).map(value).collect()).unwrap()
    };
    let layers = vec![layer(7, 4), layer(5, 7), layer(3, 5), layer(1, 3)];
    let steep = Activation::from_name_and_json("leaky_relu", "{\"slope\":0.3}").unwrap();
    let tanh = Activation::from_name("tanh").unwrap();
    let network = |activation| NetworkForce::new(Mlp::new(layers.clone(), activation).unwrap());
    let forces = [
        AnyForce::from(network(steep).unwrap()),
        AnyForce::from(network(tanh).unwrap()),
        AnyForce::from(SpringDamper::published()),
    ];
    for force in forces {
        let mut model = JointModel::datasheet(force);
        model.auxiliary_damping_kg_s = 6500.0;
        let info = ModelInfo { name: "a model".into(), ..ModelInfo::default() };
        save_model(&path, &SavedModel { model: model.clone(), info }).unwrap();
        let back = load_model(&path).unwrap();
        assert_eq!(back.model, model);
        assert_eq!((back.info.name.as_str(), back.info.trained), ("a model", false));
    }
    // The published format has no room for another activation.
    let error = save_model(folder.path().join("m.eqx"), &load_model(&path).unwrap()).unwrap_err();
    assert!(error.to_string().contains("no network"), "{error}");
}

/// The header is plain JSON behind an eight-byte length, as any safetensors reader expects.
#[test]
fn model_files_describe_themselves() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.safetensors");
    save_model(&path, &load_model(published_weights()).unwrap()).unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let length = u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
    let header: serde_json::Value = serde_json::from_slice(&bytes[8..8 + length]).unwrap();
    let meta = &header["__metadata__"];
    assert_eq!(meta["activation"], "leaky_relu");
    assert_eq!(meta["inputs"], "mass_flexor_g,mass_extensor_g,displacement_mm,velocity_mm_s");
    assert!(meta["units"].as_str().unwrap().contains("kPa absolute"));
    assert_eq!(header["weight_1"]["shape"], serde_json::json!([96, 96]));
    let offsets = &header["weight_0"]["data_offsets"];
    let begin = 8 + length + offsets[0].as_u64().unwrap() as usize;
    let first = f64::from_le_bytes(bytes[begin..begin + 8].try_into().unwrap());
    assert!((first - -9.015_628).abs() < 1e-6, "the first published weight, got {first}");
}

/// The measured run: units, orientation, and the decision on its pressures.
#[test]
fn the_real_run_is_read_in_our_units() {
    let r = open_recordings(published("data.mat"), &LoadOptions::default()).unwrap().remove(0);
    assert_eq!(r.len(), 28_027);
    assert!((r.force_mn[0] - 42_185.309).abs() < 1e-2);
    assert!((r.displacement_mm[0] - 0.149_21).abs() < 1e-4);
    assert!((r.pressure_flexor_kpa[0] - 366.335_463_38).abs() < 1e-6, "absolute as it stands");
    assert!(r.notes.iter().any(|n| n.contains("absolute") && n.contains("3.659")), "{:?}", r.notes);
    // The flexor's pressure falls as x rises.
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len() as f64;
    let (mx, mp) = (mean(&r.displacement_mm), mean(&r.pressure_flexor_kpa));
    let covariance: f64 = r
        .displacement_mm
        .iter()
        .zip(&r.pressure_flexor_kpa)
        .map(|(x, p)| (x - mx) * (p - mp))
        .sum();
    assert!(covariance < 0.0);
}

/// Folders give their recordings in order and pass other files over.
#[test]
fn folders_are_expanded() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["b.csv", "a.csv"] {
        std::fs::write(folder.path().join(name), small_csv(50)).unwrap();
    }
    std::fs::write(folder.path().join("notes.md"), "# Notes\n\nProse, with commas, is no data.")
        .unwrap();
    std::fs::write(folder.path().join("truth.json"), "{\"time_s\": [0, 1], \"seed\": 3}").unwrap();
    std::fs::copy(published_weights(), folder.path().join("model.eqx")).unwrap();
    let found = pam_data::collect_paths(&[folder.path().to_owned()]).unwrap();
    let names: Vec<_> = found.iter().map(|p| p.file_name().unwrap().to_str().unwrap()).collect();
    assert_eq!(names, ["a.csv", "b.csv"]);
    assert!(
        pam_data::collect_paths(&[Path::new("/nowhere").to_owned()]).is_ok(),
        "told when opened"
    );
}
