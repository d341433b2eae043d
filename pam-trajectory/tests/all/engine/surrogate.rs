//! Surrogates against short steps through the network.

use super::exact::{fine, off, parts, recordings};
use pam_core::force::{Dense, Mlp};
use pam_core::{Activation, JointModel, NamedChoice, NetworkForce};
use pam_data::Subject;
use pam_solvers::Interpolation;
use pam_surrogate::SurrogateSettings;
use pam_trajectory::engine::SurrogateEngine;
use pam_trajectory::{
    BatchedEngine, SolverSettings, SquaredError, TrajectoryEngine, TrajectoryRequest, Windows,
    predict,
};

/// A joint of some 150 N/mm with an activation of this name, and recordings of it.
fn joint_with(activation: Activation) -> (JointModel<f64, NetworkForce<f64>>, Vec<Subject>) {
    let number = |k: usize| (1.7 * k as f64 + 0.3).sin();
    // Twelve units of any direction, and pairs whose difference is close to a spring and a damper.
    let mut rows: Vec<f64> =
        (0..4 * 12).map(|k| number(k) / [0.1, 0.1, 0.8, 15.0][k % 4]).collect();
    let mut last: Vec<f64> = (0..12).map(|k| 8e3 * number(k + 99)).collect();
    for (input, scale, slope) in [(2, 4.0, 150e3), (3, 40.0, 5e3)] {
        for sign in [1.0, -1.0] {
            let mut row = [0.0; 4];
            row[input] = sign / scale;
            rows.extend(row);
            last.push(sign * slope * scale);
        }
    }
    let bias = (0..12).map(|k| 0.5 * number(k + 70)).chain([0.0; 4]).collect();
    let hidden = Dense::from_rows(&rows, bias).unwrap();
    let output = Dense::from_rows(&last, vec![0.0]).unwrap();
    let force = NetworkForce::new(Mlp::new(vec![hidden, output], activation).unwrap()).unwrap();
    let model = JointModel::datasheet(force);
    let subjects = recordings(&model);
    (model, subjects)
}

fn surrogate(interpolation: Interpolation) -> SurrogateEngine {
    let settings = SurrogateSettings {
        force_error_mn: 1e-3,
        step_error_mm: 1e-10,
        ..SurrogateSettings::default()
    };
    SurrogateEngine::new(interpolation, settings)
}

/// Loss and every part of the gradient are those of short steps, for every smooth activation and reading of the force.
#[test]
fn surrogate_gradient_is_that_of_short_steps() {
    let loss = SquaredError::published();
    let readings = [Interpolation::Hold, Interpolation::Linear, Interpolation::Ramp];
    let smooth = ["tanh", "softplus", "silu", "gelu", "sine"];
    let cases = smooth.iter().map(|name| (*name, Interpolation::Linear));
    for (name, interpolation) in cases.chain(readings.map(|reading| ("silu", reading))) {
        let (model, subjects) = joint_with(Activation::from_name(name).unwrap());
        let windows = Windows::of(subjects, None);
        let request = TrajectoryRequest::new(&model, &windows);
        let mut engine = surrogate(interpolation);
        let found = engine.value_and_gradient(&request, &loss).unwrap();
        assert!(found.failures.is_empty(), "{name}: {:?}", found.failures);
        let mut steps = BatchedEngine::<f64>::new(fine(interpolation));
        let expected = steps.value_and_gradient(&request, &loss).unwrap();
        let value = (found.value / expected.value - 1.0).abs();
        assert!(value < 1e-6, "{name} {}: value off {value:e}", interpolation.name());
        for ((what, a), (_, b)) in parts(&found).into_iter().zip(parts(&expected)) {
            let off = off(&a, &b);
            assert!(off < 1e-6, "{what} {name} {}: {off:e}", interpolation.name());
        }
    }
}

/// A prediction is that of short steps, pressures too.
#[test]
fn surrogate_prediction_is_that_of_short_steps() {
    let (model, subjects) = joint_with(Activation::from_name("silu").unwrap());
    let s = &subjects[0];
    let settings = SolverSettings::surrogate(Interpolation::Linear);
    let found = predict(&model, &s.recording, s.masses, &settings).unwrap().channels;
    let steps = fine(Interpolation::Linear);
    let expected = predict(&model, &s.recording, s.masses, &steps).unwrap().channels;
    let far =
        |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(far(&found.x, &expected.x) < 1e-6);
    assert!(far(&found.v, &expected.v) < 1e-4);
    assert!(far(&found.pf, &expected.pf) < 1e-4 && far(&found.pe, &expected.pe) < 1e-4);
}

/// A force that no surrogate follows is integrated by the steps of the settings, a smooth one is not.
#[test]
fn steps_take_over_where_a_surrogate_does_not_hold() {
    let general =
        SolverSettings { interpolation: Interpolation::Linear, ..SolverSettings::default() };
    let first = general.surrogate_first();
    for (name, follows) in [("silu", true), ("leaky_relu", false)] {
        let (model, subjects) = joint_with(Activation::from_name(name).unwrap());
        let s = &subjects[0];
        let found = predict(&model, &s.recording, s.masses, &first).unwrap();
        let steps = predict(&model, &s.recording, s.masses, &general).unwrap();
        assert_eq!(found.statistics.evaluations == 0, follows, "{name}");
        let far = found.channels.x.iter().zip(&steps.channels.x).map(|(a, b)| (a - b).abs());
        assert!(far.fold(0.0, f64::max) < if follows { 1e-4 } else { f64::MIN_POSITIVE });
        assert_eq!(first.surrogate_applies_to(&model.force), follows);
    }
}

/// A force with kinks cannot be followed within the tolerance, and that is said.
#[test]
fn kinks_are_refused() {
    let (model, subjects) = joint_with(Activation::from_name("leaky_relu").unwrap());
    let windows = Windows::of(subjects, None);
    let request = TrajectoryRequest::new(&model, &windows);
    let mut engine = surrogate(Interpolation::Linear);
    let found = engine.value_and_gradient(&request, &SquaredError::published()).unwrap();
    assert_eq!(found.failures.len(), 2);
    assert!(
        found.failures[0].kind.describe(0.0).contains("bends too sharply"),
        "{:?}",
        found.failures[0]
    );
}

/// Where the force bends within a sample and the measured force is noisy, other steps take over, and the gradient stays that
/// of short steps.
#[test]
fn sharp_bends_and_noise_are_followed() {
    let (model, mut subjects) = joint_with(Activation::from_name("tanh").unwrap());
    // Dry friction: 4 N, within 0.2 mm/s of rest.
    let mut layers = model.force.mlp().layers().to_vec();
    let column = |dense: &Dense<f64>, i: usize| {
        let n = dense.outputs();
        dense.weight_columns()[i * n..(i + 1) * n].to_vec()
    };
    let mut rows: Vec<f64> = (0..layers[0].outputs())
        .flat_map(|j| (0..4).map(move |i| (j, i)))
        .map(|(j, i)| column(&layers[0], i)[j])
        .collect();
    rows.extend([0.0, 0.0, 0.0, 1.0 / 0.2]);
    let mut bias = layers[0].bias().to_vec();
    bias.push(0.0);
    let mut last = layers[1].weight_columns().to_vec();
    last.push(4e3);
    layers[1] = Dense::from_rows(&last, layers[1].bias().to_vec()).unwrap();
    layers[0] = Dense::from_rows(&rows, bias).unwrap();
    let tanh = Activation::from_name("tanh").unwrap();
    let model = model.map(|v| v, |_| NetworkForce::new(Mlp::new(layers, tanh).unwrap()).unwrap());
    for subject in &mut subjects {
        for (k, force) in subject.recording.force_mn.iter_mut().enumerate() {
            *force += 200.0 * (k as f64 * k as f64 * 0.37).sin();
        }
    }
    let windows = Windows::of(subjects, None);
    let request = TrajectoryRequest::new(&model, &windows);
    let loss = SquaredError::published();
    for interpolation in [Interpolation::Linear, Interpolation::Hold] {
        let found = surrogate(interpolation).value_and_gradient(&request, &loss).unwrap();
        assert!(found.failures.is_empty(), "{:?}", found.failures);
        assert!(found.statistics.rejected > 0, "no step was too long");
        let expected = BatchedEngine::<f64>::new(fine(interpolation))
            .value_and_gradient(&request, &loss)
            .unwrap();
        for ((what, a), (_, b)) in parts(&found).into_iter().zip(parts(&expected)) {
            let off = off(&a, &b);
            assert!(off < 1e-6, "{what} {}: {off:e}", interpolation.name());
        }
    }
}

/// Samples that are not equally far apart make no difference.
#[test]
fn unequal_samples_are_followed() {
    let (model, mut subjects) = joint_with(Activation::from_name("silu").unwrap());
    for subject in &mut subjects {
        let r = &mut subject.recording;
        for (k, time) in r.time_s.iter_mut().enumerate() {
            *time += 2e-4 * (0.3 * k as f64).sin();
        }
        r.force_mn = r.time_s.iter().map(|t| 1e5 * (9.0 * t).sin()).collect();
    }
    let windows = Windows::of(subjects, None);
    let request = TrajectoryRequest::new(&model, &windows);
    let loss = SquaredError::published();
    let linear = Interpolation::Linear;
    let found = surrogate(linear).value_and_gradient(&request, &loss).unwrap();
    let expected = BatchedEngine::<f64>::new(fine(linear)).value_and_gradient(&request, &loss);
    for ((what, a), (_, b)) in parts(&found).into_iter().zip(parts(&expected.unwrap())) {
        let off = off(&a, &b);
        assert!(off < 1e-6, "{what}: {off:e}");
    }
}
