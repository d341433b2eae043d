//! The published files: their predictions are those of NumPy and PyTorch, stored by
//! `pam-bench/peers/gru_fixture.py`.

use crate::published;
use pam_baselines::gru::{BatchGradient, GruModel, INPUTS, Network, Window};
use pam_baselines::koopman::{Dictionary, KoopmanModel};
use pam_baselines::method::FittedModel;
use pam_data::formats::npz;
use serde_json::Value;

fn peers() -> Value {
    let text = include_str!("../fixtures/published_peers.json");
    serde_json::from_str(text).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn published_gru() -> GruModel {
    let path = published("gru_model.npz");
    GruModel::from_npz(&path).unwrap()
}

/// The inputs of the script.
fn sample(t: usize, c: usize) -> f32 {
    let (t, c) = (t as f64, c as f64);
    (0.6 * (0.05 * t + 0.9 * c).sin() + 0.2 * (0.013 * t * (c + 1.0)).cos()) as f32
}

fn window(shift: usize) -> Vec<[f32; INPUTS]> {
    (0..200).map(|t| std::array::from_fn(|c| sample(t + shift, c))).collect()
}

#[test]
fn koopman_steps_are_those_of_numpy() {
    let model = KoopmanModel::from_npz(published("koopman_model.npz")).unwrap();
    assert_eq!(model.dictionary, Dictionary::Linear);
    assert_eq!(model.map.len(), 4 * 6);
    let expected = &peers()["koopman"];
    let forces = numbers(&expected["forces_mn"]);
    for (k, force) in forces.iter().enumerate() {
        let state: [f64; 4] = numbers(&expected["states"][k]).try_into().unwrap();
        let next = model.step(&state, *force);
        for (own, numpy) in next.iter().zip(numbers(&expected["next"][k])) {
            // Sums in another order: the last bits.
            assert!((own - numpy).abs() <= 4e-15 * numpy.abs().max(1.0), "{own} {numpy}");
        }
    }
    // The published map decays without input.
    let radius = model.stability.relifted[0].magnitude;
    assert!(radius > 0.99 && radius < 1.01, "{radius}");
}

#[test]
fn gru_outputs_are_those_of_pytorch() {
    let model = published_gru();
    let expected = &peers()["gru"];
    // 3·96 rows of 5 + 96 and of 96 + 96 inputs with two biases each, 96·97 and 4·97 of the head.
    assert_eq!(model.parameter_count(), 288 * (101 + 2) + 288 * (192 + 2) + 96 * 97 + 4 * 97);
    for (name, own) in
        [("input_scaler_min", model.scaling.low), ("input_scaler_max", model.scaling.high)]
    {
        assert_eq!(numbers(&expected[name]), own);
    }
    let window = window(0);
    let forces: Vec<f32> = window[100..199].iter().map(|s| s[4]).collect();
    let predicted = model.predict_scaled(&window[..100], &forces);
    assert_eq!(predicted.len(), 100);
    let mut worst = 0.0_f64;
    for (own, torch) in predicted.iter().step_by(9).zip(expected["outputs"].as_array().unwrap()) {
        for (own, torch) in own.iter().zip(numbers(torch)) {
            worst = worst.max((f64::from(*own) - torch).abs());
        }
    }
    assert!(worst < 1e-5, "{worst:e}");
}

#[test]
fn gru_loss_and_gradient_are_those_of_pytorch() {
    let model = published_gru();
    let expected = &peers()["gru"];
    let data: Vec<Vec<[f32; INPUTS]>> = [0, 7, 14].map(window).to_vec();
    let windows: Vec<Window<'_, f32>> = data.iter().map(|s| Window { samples: s }).collect();
    let network = Network::<f32>::new(model.network.shape, &model.numbers);
    let mut gradient = vec![0.0; model.numbers.len()];
    let loss =
        BatchGradient::new(&network, 3, 100, 100).run(&network, &windows, Some(&mut gradient));
    let torch = expected["loss"].as_f64().unwrap();
    assert!((loss - torch).abs() < 1e-5 * torch, "{loss} {torch}");
    for part in network.shape.parts() {
        let norm = gradient[part.range].iter().map(|g| g * g).sum::<f64>().sqrt();
        let torch = expected["gradient_norm"][&part.name].as_f64().unwrap();
        assert!((norm - torch).abs() < 1e-4 * torch, "{}: {norm} {torch}", part.name);
    }
}

/// Files that `FittedModel::arrays` fills give the same model.
#[test]
fn saved_models_are_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.npz");
    let gru = published_gru();
    npz::write(&path, &gru.arrays()).unwrap();
    let again = GruModel::from_npz(&path).unwrap();
    assert_eq!((again.numbers, again.scaling.low), (gru.numbers, gru.scaling.low));
    assert_eq!((again.warm_up, again.samples_per_step, again.step_s), (100, 1, None));
    let koopman = KoopmanModel::from_npz(published("koopman_model.npz")).unwrap();
    npz::write(&path, &koopman.arrays()).unwrap();
    assert_eq!(KoopmanModel::from_npz(&path).unwrap(), koopman);
}

#[test]
fn damaged_and_foreign_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("broken.npz");
    let bytes = std::fs::read(published("koopman_model.npz")).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    let message = GruModel::from_npz(&path).unwrap_err().to_string();
    assert!(message.contains("broken.npz"), "{message}");
    let koopman = published("koopman_model.npz");
    let message = GruModel::from_npz(&koopman).unwrap_err().to_string();
    assert!(message.contains("no array `gru.weight_hh_l0`"), "{message}");
    let mut arrays = published_gru().arrays();
    let bias = arrays.get_mut("gru.bias_ih_l1").unwrap();
    bias.shape = vec![287];
    bias.values.pop();
    npz::write(&path, &arrays).unwrap();
    let message = GruModel::from_npz(&path).unwrap_err().to_string();
    assert!(message.contains("`gru.bias_ih_l1` has shape [287], not [288]"), "{message}");
}
