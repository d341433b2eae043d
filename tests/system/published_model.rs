//! The published weights load and give the published numbers.

use approx::{assert_abs_diff_eq, assert_relative_eq};
use num_dual::{Dual64, HyperDual64};
use pam_autodiff::{
    Central, DifferenceScheme, FourPointSmoothed, linearise, stiffness_by_difference_n_mm,
};
use pam_core::{AnyForce, ForceInput, ForceModel, JointModel, Scalar, scalar};
use pam_data::{Recording, load_model};
use pam_solvers::{Interpolation, Tableau};
use pam_tests::published_weights;
use pam_trajectory::{SolverSettings, StepChoice, predict};
use std::f64::consts::TAU;
use std::path::Path;

fn model() -> JointModel<f64, AnyForce<f64>> {
    load_model(published_weights()).unwrap().model
}

fn at(x: f64, v: f64, mf: f64, me: f64) -> ForceInput<f64> {
    ForceInput { displacement_mm: x, velocity_mm_s: v, mass_flexor_g: mf, mass_extensor_g: me }
}

/// Table of the paper: K̂ with h = 1 mm at x = ẋ = 0.
#[test]
fn smoothed_stiffness_is_the_published_one() {
    let force = model().force;
    for (mass, expected) in [(0.031_527_2, 127.3), (0.121_101_5, 175.3)] {
        let scheme = FourPointSmoothed { h: 1.0 };
        let k = stiffness_by_difference_n_mm(&force, &at(0.0, 0.0, mass, mass), &scheme);
        assert_abs_diff_eq!(k, expected, epsilon = 0.1);
    }
}

#[test]
fn parameters_are_the_published_ones() {
    let p = model().physical();
    assert_relative_eq!(p.mass_kg, 304.648, max_relative = 1e-5);
    assert_relative_eq!(p.gas_coefficient, 8.47e7, max_relative = 1e-9);
    assert_relative_eq!(p.deformation, 3.690_974, max_relative = 1e-6);
    // 170 kPa in both muscles is the lower end of the published stiffness range.
    let pressures = model().gas_law_pressures_kpa(
        0.0,
        pam_core::SealedMasses { flexor_g: 0.031_527_2, extensor_g: 0.031_527_2 },
    );
    assert_abs_diff_eq!(pressures[0], 170.0, epsilon = 0.1);
}

/// Away from kinks the exact derivative is the difference quotient; the force is piecewise affine, so
/// both agree to rounding. A kink between the two points shows as a disagreement and is left out, but
/// most points must remain.
#[test]
fn exact_slopes_equal_finite_differences_away_from_kinks() {
    let force = model().force;
    let dual = force.map(Dual64::constant);
    let mut work = scalar::zeros(force.work_len());
    let mut compared = 0;
    for i in 0..400 {
        let s = |k: f64| (f64::from(i) * k).sin();
        let point = at(1.5 * s(1.3), 8.0 * s(2.7), 0.075 + 0.04 * s(0.7), 0.075 + 0.04 * s(3.1));
        let line = linearise(&dual, &point);
        let mut along_x = |x: f64| {
            force.restoring_force_mn(&ForceInput { displacement_mm: x, ..point }, &mut work)
        };
        let h = 1e-5;
        let x = point.displacement_mm;
        let (left, right) = ((along_x(x) - along_x(x - h)) / h, (along_x(x + h) - along_x(x)) / h);
        if (left - right).abs() > 1e-2 {
            continue;
        }
        compared += 1;
        let fd = Central { h }.derivative(&mut along_x, x);
        assert_relative_eq!(line.stiffness_n_mm * 1e3, fd, max_relative = 1e-6);
    }
    assert!(compared > 350, "only {compared} of 400 points lie away from kinks");
}

/// The same field runs with hyper-dual numbers; inside an activation pattern the force has no
/// curvature.
#[test]
fn the_force_is_affine_inside_a_pattern() {
    let force = model().force.map(HyperDual64::constant);
    let mut work = scalar::zeros(force.work_len());
    let mut point = at(0.31, 1.7, 0.07, 0.08).lift::<HyperDual64>();
    point.displacement_mm = HyperDual64::new(0.31, 1.0, 1.0, 0.0);
    let f = force.restoring_force_mn(&point, &mut work);
    assert_eq!(f.eps1eps2, 0.0);
    assert!(f.eps1 > 1e4);
}

/// Zero-order hold on the 1 kHz grid with the published network, 1 ms steps: within 1e-5 mm of a
/// reference that shares no solver code, takes 40 steps a sample and never leaves its hold.
#[test]
fn a_held_simulation_agrees_with_a_fine_reference() {
    let model = model();
    let n = 2000;
    let mut recording = Recording::empty(Path::new("run"));
    recording.time_s = (0..n).map(|k| f64::from(k) * 1e-3).collect();
    recording.force_mn = recording.time_s.iter().map(|t| 170e3 * (TAU * 1.0 * t).sin()).collect();
    recording.displacement_mm = vec![0.05; n as usize];
    recording.velocity_mm_s = vec![0.0; n as usize];
    recording.pressure_flexor_kpa = vec![412.0; n as usize];
    recording.pressure_extensor_kpa = vec![412.0; n as usize];
    let masses = model.gas_law_masses(0.05, [412.0, 412.0]);
    let settings = SolverSettings {
        tableau: Tableau::tsit5(),
        step: StepChoice::Constant { step_s: 1e-3 },
        interpolation: Interpolation::Hold,
    };
    let prediction = predict(&model, &recording, masses, &settings).unwrap();

    let mass = model.physical().mass_kg;
    let mut work = scalar::zeros(model.force.work_len());
    let mut acceleration = |x: f64, v: f64, force: f64| {
        let input = at(x, v, masses.flexor_g, masses.extensor_g);
        (force - model.force.restoring_force_mn(&input, &mut work)) / mass
    };
    let (mut x, mut v) = (0.05, 0.0);
    let h = 1e-3 / 10.0;
    let mut worst = 0.0_f64;
    for k in 1..n as usize {
        let f = recording.force_mn[k - 1];
        for _ in 0..10 {
            let a1 = acceleration(x, v, f);
            let a2 = acceleration(x + 0.5 * h * v, v + 0.5 * h * a1, f);
            let v2 = v + 0.5 * h * a1;
            let a3 = acceleration(x + 0.5 * h * v2, v + 0.5 * h * a2, f);
            let v3 = v + 0.5 * h * a2;
            let v4 = v + h * a3;
            let a4 = acceleration(x + h * v3, v4, f);
            x += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
            v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
        }
        worst = worst.max((prediction.channels.x[k] - x).abs());
    }
    assert!(worst < 1e-5, "largest distance {worst:e} mm");

    // The four-state form keeps P V = C m: the pressures are algebra of the displacement.
    for k in (0..n as usize).step_by(97) {
        let p = model.gas_law_pressures_kpa(prediction.channels.x[k], masses);
        assert_abs_diff_eq!(prediction.channels.pf[k], p[0], epsilon = 1e-6);
        assert_abs_diff_eq!(prediction.channels.pe[k], p[1], epsilon = 1e-6);
    }
}
