//! The closed form against short steps.

use pam_core::force::{Dense, Mlp};
use pam_core::{Activation, JointModel, NamedChoice, NetworkForce};
use pam_data::{MassOrigin, Recording, Subject};
use pam_solvers::{Interpolation, Tableau};
use pam_trajectory::{
    BatchedEngine, ClosedFormEngine, SolverSettings, SquaredError, StepChoice, TrajectoryEngine,
    TrajectoryGradient, TrajectoryRequest, Windows, predict,
};
use std::path::Path;

/// A joint of about 150 N/mm with kinks, and a recording of it under a sine.
fn joint() -> (JointModel<f64, NetworkForce<f64>>, Vec<Subject>) {
    let number = |k: usize| (1.7 * k as f64 + 0.3).sin();
    let rows: Vec<f64> = (0..4 * 12)
        .map(|k| number(k) / [0.1, 0.1, 0.8, 15.0][k % 4])
        .chain([0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0])
        .collect();
    let bias = (0..12).map(|k| 0.5 * number(k + 70)).chain([1e2, 1e3]).collect();
    let hidden = Dense::from_rows(&rows, bias).unwrap();
    let last: Vec<f64> = (0..12).map(|k| 8e3 * number(k + 99)).chain([150e3, 5e3]).collect();
    let output = Dense::from_rows(&last, vec![-150e3 * 1e2 - 5e3 * 1e3]).unwrap();
    let activation = Activation::from_name("leaky_relu").unwrap();
    let force = NetworkForce::new(Mlp::new(vec![hidden, output], activation).unwrap()).unwrap();
    let model = JointModel::datasheet(force);
    let subjects = recordings(&model);
    (model, subjects)
}

/// Recordings under a sine.
pub(super) fn recordings(model: &JointModel<f64, NetworkForce<f64>>) -> Vec<Subject> {
    let subjects = [[300.0, 500.0], [450.0, 350.0]].map(|kpa| {
        let mut r = Recording::empty(Path::new("joint"));
        r.time_s = (0..1500).map(|k| f64::from(k) * 1e-3).collect();
        r.force_mn = r.time_s.iter().map(|t| 1e5 * (9.0 * t).sin()).collect();
        r.displacement_mm = r.time_s.iter().map(|t| 0.5 * (9.0 * t).sin()).collect();
        r.velocity_mm_s = r.time_s.iter().map(|t| 4.5 * (9.0 * t).cos()).collect();
        r.pressure_flexor_kpa = vec![kpa[0]; 1500];
        r.pressure_extensor_kpa = vec![kpa[1]; 1500];
        let masses = model.gas_law_masses(0.0, kpa);
        Subject { recording: r, masses, origin: MassOrigin::Given }
    });
    subjects.to_vec()
}

pub(super) fn fine(interpolation: Interpolation) -> SolverSettings {
    let step = StepChoice::Constant { step_s: 2e-5 };
    SolverSettings { tableau: Tableau::rk4(), step, interpolation }
}

/// Distance of two vectors, relative to the second.
pub(super) fn off(a: &[f64], b: &[f64]) -> f64 {
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|v| v * v).sum::<f64>().sqrt();
    norm(&mut a.iter().zip(b).map(|(a, b)| a - b)) / norm(&mut b.iter().copied())
}

/// The parts of a gradient.
pub(super) fn parts(g: &TrajectoryGradient) -> [(&'static str, Vec<f64>); 4] {
    let raw = vec![g.raw.mass, g.raw.gas_coefficient, g.raw.deformation, g.auxiliary_damping];
    let air = g.masses.iter().flat_map(|m| [m.flexor_g, m.extensor_g]).collect();
    [
        ("weights", g.force.clone()),
        ("joint", raw),
        ("air", air),
        ("start", g.initial_states.concat()),
    ]
}

/// Loss and every part of the gradient are those of short steps.
#[test]
fn exact_gradient_is_that_of_short_steps() {
    let (model, subjects) = joint();
    let loss = SquaredError::published();
    for interpolation in [Interpolation::Hold, Interpolation::Linear, Interpolation::Ramp] {
        let settings = SolverSettings::exact(interpolation);
        assert!(settings.exact_applies_to(&model.force));
        let windows = Windows::of(subjects.clone(), None);
        let request = TrajectoryRequest::new(&model, &windows);
        let exact =
            ClosedFormEngine::new(interpolation).value_and_gradient(&request, &loss).unwrap();
        let steps = BatchedEngine::<f64>::new(fine(interpolation))
            .value_and_gradient(&request, &loss)
            .unwrap();
        assert!((exact.value - steps.value).abs() < 1e-6 * steps.value);
        for ((what, a), (_, b)) in parts(&exact).into_iter().zip(parts(&steps)) {
            let off = off(&a, &b);
            assert!(off < 1e-5, "{what} {}: {off:e}", interpolation.name());
        }
    }
}

/// A prediction is that of short steps, pressures too; what cannot be solved says so.
#[test]
fn exact_prediction_is_that_of_short_steps() {
    let (model, subjects) = joint();
    let s = &subjects[0];
    let exact =
        predict(&model, &s.recording, s.masses, &SolverSettings::exact(Interpolation::Hold))
            .unwrap();
    let steps = predict(&model, &s.recording, s.masses, &fine(Interpolation::Hold)).unwrap();
    for (a, b) in [
        (&exact.channels.x, &steps.channels.x),
        (&exact.channels.v, &steps.channels.v),
        (&exact.channels.pf, &steps.channels.pf),
        (&exact.channels.pe, &steps.channels.pe),
    ] {
        let scale = b.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6 * scale));
    }
    let smooth = model.map(
        |v| v,
        |f| {
            let tanh = Activation::from_name("tanh").unwrap();
            NetworkForce::new(Mlp::new(f.mlp().layers().to_vec(), tanh).unwrap()).unwrap()
        },
    );
    let settings = SolverSettings::exact(Interpolation::Hold);
    assert!(!settings.exact_applies_to(&smooth.force));
    let refused = predict(&smooth, &s.recording, s.masses, &settings).unwrap_err();
    assert!(refused.why.contains("leaky_relu"), "{}", refused.why);
}
