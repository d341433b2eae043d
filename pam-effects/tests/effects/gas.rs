//! The air.

use crate::support::joint::{K, P, driven, linear, linear_run, run, subject, volumes};
use pam_core::units::ATMOSPHERE_KPA;
use pam_data::MassOrigin;
use std::f64::consts::TAU;

fn drive(t: f64) -> f64 {
    140.0 * (TAU * 0.5 * t).sin()
}

fn nu() -> f64 {
    linear().physical().deformation
}

/// `P = P_0 (V_0/V)ⁿ`, with no leak and no feedback; the motion is the plain one.
#[test]
fn pressures_follow_the_exponent_and_the_geometry() {
    let plain = linear_run(6.0, 0.0, drive, &[]);
    let cases = [
        ("polytropic_gas", 1.0, 1.0, 1.0),
        ("polytropic_gas", 1.3, 1.3, 1.0),
        ("geometry_coefficient", 0.2, 1.0, 1.2),
    ];
    for (id, value, exponent, factor) in cases {
        let run = linear_run(6.0, 0.0, drive, &[(id, &[value, 0.0])]);
        let (at_rest, _) = volumes(0.0, factor * nu());
        for k in 0..run.x.len() {
            let (now, _) = volumes(run.x[k], factor * nu());
            for i in 0..2 {
                let expected = P * (at_rest[i] / now[i]).powf(exponent);
                let miss = (run.p[i][k] - expected).abs();
                assert!(miss < 1e-9 * P, "{id} {k}: {miss}");
            }
        }
        assert_eq!(run.x, plain.x, "{id}");
    }
}

/// With feedback the changed pressures push: at rest `K x = F + Σ ΔP_i dV_i/dx`, ΔP against the base law.
#[test]
fn changed_pressures_push_on_the_joint() {
    let force = 120e3;
    let cases: [(&str, f64, f64, f64); 2] =
        [("polytropic_gas", 1.4, 1.4, 1.0), ("geometry_coefficient", 0.3, 1.0, 1.3)];
    for (id, value, exponent, factor) in cases {
        let run = linear_run(6.0, 0.0, |_| force / 1e3, &[(id, &[value, 1.0])]);
        let x = *run.x.last().expect("points");
        let (v0, _) = volumes(0.0, nu());
        let (v, slope) = volumes(x, nu());
        let (w0, _) = volumes(0.0, factor * nu());
        let (w, _) = volumes(x, factor * nu());
        let push: f64 =
            (0..2).map(|i| (P * (w0[i] / w[i]).powf(exponent) - P * v0[i] / v[i]) * slope[i]).sum();
        // 1 kPa mm² = 1 mN.
        assert!((K * x - force - push).abs() < 1e-3 * push.abs(), "{id}: {x} {push}");
        assert!(push < -1e3, "a stiffer gas pushes back: {push}");
    }
}

/// At constant volume `dP/dt = −rate (P − P_atm)`. Euler's steps of 4 ms err by rate h/2, 2e-4 at 0.1/s.
#[test]
fn leaking_chambers_empty_exponentially() {
    let rates = [0.1, 0.02];
    let run = linear_run(10.0, 0.0, |_| 0.0, &[("leak", &rates)]);
    for (k, time) in (0..run.x.len()).map(|k| (k, run.time_s(k))) {
        for (series, rate) in run.p.iter().zip(rates) {
            let expected = ATMOSPHERE_KPA + (P - ATMOSPHERE_KPA) * (-rate * time).exp();
            assert!((series[k] - expected).abs() < 3e-4 * P, "{time}: {}", series[k]);
        }
    }
}

/// A chamber whose tendon is slack keeps its volume, hence its pressure.
#[test]
fn a_slack_chamber_stops_following() {
    let d = 0.4;
    let run = linear_run(6.0, 0.0, drive, &[("tendon_slack", &[d, 0.0])]);
    let (rest, _) = volumes(0.0, nu());
    let mut beyond = 0;
    for k in 0..run.x.len() {
        let (flexor, _) = volumes(run.x[k].min(d), nu());
        let (extensor, _) = volumes(run.x[k].max(-d), nu());
        assert!((run.p[0][k] - P * rest[0] / flexor[0]).abs() < 1e-9 * P);
        assert!((run.p[1][k] - P * rest[1] / extensor[1]).abs() < 1e-9 * P);
        beyond += usize::from(run.x[k].abs() > d);
    }
    assert!(beyond > 500);
}

/// Masses that follow from a sealed reading move with a true reading that differs; given masses do not.
#[test]
fn masses_by_the_gas_law_follow_the_true_reading() {
    let model = linear();
    let swing = |origin: MassOrigin, effects: &[(&str, &[f64])]| {
        let run = run(&model, &subject(&model, driven(6.0, 0.0, drive), origin), effects);
        (run.p[0].clone(), run.p[1].clone())
    };
    let (plain, _) = swing(MassOrigin::GasLaw, &[]);
    let bias: &[(&str, &[f64])] = &[("pressure_bias", &[30.0, -20.0])];
    let (given, _) = swing(MassOrigin::Given, bias);
    let (by_law, extensor) = swing(MassOrigin::GasLaw, bias);
    for k in 0..plain.len() {
        // Closed chambers: P − P(0) = C m (1/V − 1/V_0).
        assert!((given[k] - plain[k]).abs() < 1e-9 * P);
        let expected = P + (plain[k] - P) * (P - 30.0) / P;
        assert!((by_law[k] - expected).abs() < 1e-9 * P);
    }
    assert!((extensor[0] - P).abs() < 1e-9 * P, "the first sample is as measured");
}
