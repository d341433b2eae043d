//! The spring–damper joint against its closed-form solution, and the invariants of its gas.

use approx::assert_abs_diff_eq;
use pam_core::joint::{ME, MF, PE, PF, V, X};
use pam_core::{JointModel, SealedMasses, SpringDamper};
use pam_solvers::{
    Constant, ConstantStep, InputFn, Integrator, PidController, SaveAt, Tableau, Term,
};
use std::f64::consts::TAU;

const STIFFNESS: f64 = 150e3;
const DAMPING: f64 = 3000.0;

fn model() -> JointModel<f64, SpringDamper<f64>> {
    let mut model = JointModel::datasheet(SpringDamper::constant(STIFFNESS, DAMPING));
    model.auxiliary_damping_kg_s = 3500.0;
    model
}

fn masses() -> SealedMasses {
    SealedMasses::new(0.06, 0.08).unwrap()
}

/// `m ẍ + b ẋ + k x = A sin ωt` from `(x0, v0)`, solved by hand: particular plus damped oscillation.
fn forced_oscillator(
    t: f64,
    mass: f64,
    amplitude: f64,
    omega: f64,
    x0: f64,
    v0: f64,
) -> (f64, f64) {
    let (b, k) = (DAMPING + 3500.0, STIFFNESS);
    let (re, im) = (k - mass * omega * omega, b * omega);
    let scale = amplitude / (re * re + im * im);
    let (s, c) = (scale * re, -scale * im);
    let particular = |t: f64| {
        let (sin, cos) = (omega * t).sin_cos();
        (s * sin + c * cos, omega * (s * cos - c * sin))
    };
    let decay = b / (2.0 * mass);
    let wd = (k / mass - decay * decay).sqrt();
    let p0 = particular(0.0);
    let (a0, w0) = (x0 - p0.0, v0 - p0.1);
    let a1 = (w0 + decay * a0) / wd;
    let (sin, cos) = (wd * t).sin_cos();
    let e = (-decay * t).exp();
    let free = e * (a0 * cos + a1 * sin);
    let free_rate = -decay * free + e * wd * (a1 * cos - a0 * sin);
    let p = particular(t);
    (p.0 + free, p.1 + free_rate)
}

#[test]
fn tsit5_at_1e_10_is_exact_to_1e_9_mm_over_70_s() {
    let model = model();
    let mass = model.physical().mass_kg;
    let (amplitude, omega) = (133.5e3, TAU * 2.0);
    let input = InputFn::new(1, |t: f64, u: &mut [f64]| u[0] = amplitude * (omega * t).sin());
    let (x0, v0) = (0.4, -2.0);
    let [pf, pe] = model.gas_law_pressures_kpa(x0, masses());
    let times: Vec<f64> = (0..=7000).map(|k| f64::from(k) * 0.01).collect();
    let solution = Integrator::new(Tableau::tsit5(), PidController::new(1e-10, 1e-10))
        .solve(
            &Term::new(model.sealed(masses()), input),
            0.0,
            70.0,
            &[x0, v0, pf, pe],
            SaveAt::Times(&times),
        )
        .unwrap();
    for (i, &t) in times.iter().enumerate() {
        let (x, v) = forced_oscillator(t, mass, amplitude, omega, x0, v0);
        assert_abs_diff_eq!(solution.state(i)[X], x, epsilon = 1e-9);
        assert_abs_diff_eq!(solution.state(i)[V], v, epsilon = 1e-7);
        let p = model.gas_law_pressures_kpa(x, masses());
        assert_abs_diff_eq!(solution.state(i)[PF], p[0], epsilon = 1e-7);
        assert_abs_diff_eq!(solution.state(i)[PE], p[1], epsilon = 1e-7);
    }
}

#[test]
fn pressure_times_volume_stays_constant_to_the_tolerance() {
    let model = model();
    let p = model.physical();
    for tolerance in [1e-5, 1e-8] {
        let input = InputFn::new(1, |t: f64, u: &mut [f64]| u[0] = 150e3 * (9.0 * t).sin());
        let [pf, pe] = model.gas_law_pressures_kpa(0.0, masses());
        let solution = Integrator::new(Tableau::tsit5(), PidController::new(tolerance, tolerance))
            .solve(
                &Term::new(model.sealed(masses()), input),
                0.0,
                20.0,
                &[0.0, 0.0, pf, pe],
                SaveAt::Steps,
            )
            .unwrap();
        for i in 0..solution.len() {
            let y = solution.state(i);
            let v = model.geometry.volumes(y[X], p.deformation);
            let (cf, ce) = (y[PF] * v.flexor_mm3, y[PE] * v.extensor_mm3);
            // Errors of many steps add up; fifty times the tolerance of one bounds them.
            let bound = 50.0 * tolerance;
            assert!((cf / (p.gas_coefficient * 0.06) - 1.0).abs() < bound);
            assert!((ce / (p.gas_coefficient * 0.08) - 1.0).abs() < bound);
        }
    }
}

#[test]
fn energy_is_kept_without_damping_and_falls_with_it() {
    let mut model = JointModel::datasheet(SpringDamper::constant(STIFFNESS, 0.0));
    let mass = model.physical().mass_kg;
    let energy = |y: &[f64]| 0.5 * mass * y[V] * y[V] + 0.5 * STIFFNESS * y[X] * y[X];
    let run = |model: &JointModel<f64, SpringDamper<f64>>| {
        let [pf, pe] = model.gas_law_pressures_kpa(1.0, masses());
        let term = Term::new(model.sealed(masses()), Constant(vec![0.0]));
        let solver = Integrator::new(Tableau::dormand_prince5(), PidController::new(1e-10, 1e-10));
        solver.solve(&term, 0.0, 10.0, &[1.0, 0.0, pf, pe], SaveAt::Steps).unwrap()
    };
    let free = run(&model);
    let start = energy(free.state(0));
    for i in 0..free.len() {
        assert!((energy(free.state(i)) / start - 1.0).abs() < 1e-7);
    }
    model.auxiliary_damping_kg_s = 500.0;
    let damped = run(&model);
    for i in 1..damped.len() {
        assert!(energy(damped.state(i)) <= energy(damped.state(i - 1)) * (1.0 + 1e-9));
    }
}

/// With open valves the masses follow the flows and P V = C m keeps holding.
#[test]
fn open_valves_fill_the_chambers_by_the_gas_law() {
    let model = model();
    let p = model.physical();
    let m = masses();
    let [pf, pe] = model.gas_law_pressures_kpa(0.0, m);
    let input = InputFn::new(3, |t: f64, u: &mut [f64]| {
        u[0] = 50e3 * (5.0 * t).sin();
        u[1] = 0.01;
        u[2] = -0.005 * (2.0 * t).cos();
    });
    let y0 = [0.0, 0.0, pf, pe, m.flexor_g, m.extensor_g];
    let solution = Integrator::new(Tableau::tsit5(), PidController::new(1e-9, 1e-9))
        .solve(&Term::new(model.with_open_valves(), input), 0.0, 3.0, &y0, SaveAt::End)
        .unwrap();
    let y = solution.state(0);
    assert_abs_diff_eq!(y[MF], 0.06 + 0.03, epsilon = 1e-8);
    assert_abs_diff_eq!(y[ME], 0.08 - 0.0025 * (6.0_f64).sin(), epsilon = 1e-8);
    let v = model.geometry.volumes(y[X], p.deformation);
    assert_abs_diff_eq!(y[PF], p.gas_coefficient * y[MF] / v.flexor_mm3, epsilon = 1e-4);
    assert_abs_diff_eq!(y[PE], p.gas_coefficient * y[ME] / v.extensor_mm3, epsilon = 1e-4);
}

/// The same field runs in single precision.
#[test]
fn single_precision_agrees_with_double() {
    let model = JointModel::datasheet(SpringDamper::constant(STIFFNESS as f32, 6500.0));
    let m = SealedMasses { flexor_g: 0.06_f32, extensor_g: 0.08 };
    let [pf, pe] = model.gas_law_pressures_kpa(0.0, m);
    let input = InputFn::new(1, |_t: f64, u: &mut [f32]| u[0] = 100e3);
    let solution = Integrator::new(Tableau::rk4(), ConstantStep::new(1e-3))
        .solve(&Term::new(model.sealed(m), input), 0.0, 5.0, &[0.0, 0.0, pf, pe], SaveAt::End)
        .unwrap();
    // At rest: x = F / K.
    assert!((f64::from(solution.state(0)[X]) - 100.0 / 150.0).abs() < 1e-4);
}
