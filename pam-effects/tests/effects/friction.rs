//! Dry friction.

use crate::support::joint::{B, HOLD, K, M, driven, linear, linear_run, run, subject, undamped};
use pam_data::MassOrigin;
use pam_effects::effects::{EffectHooks, StribeckFriction};
use std::f64::consts::TAU;

/// A joint that is held stays where it is, to the last bit, as long as what pulls is below the limit.
#[test]
fn a_held_joint_does_not_move() {
    // 0.2 mm of spring is 30 N, the drive 15 N more.
    let drive = |t: f64| 15.0 * (TAU * t).sin();
    for effect in [("coulomb_friction", &[46.0][..]), ("stribeck_friction", &[5.0, 46.0, 1.0])] {
        let held = linear_run(6.0, 0.2, drive, &[effect]);
        assert!(held.x.iter().all(|&x| x == 0.2), "{}", effect.0);
        assert!(held.v.iter().all(|&v| v == 0.0), "{}", effect.0);
    }
    let weak = linear_run(6.0, 0.2, drive, &[("coulomb_friction", &[44.0])]);
    assert!(weak.x.iter().any(|&x| x != 0.2));
}

/// A slow ramp moves the joint when it passes the static limit, to within a step.
#[test]
fn the_joint_breaks_away_at_the_static_limit() {
    let ramp = |t: f64| 5.0 * t;
    for (effect, limit) in [
        (("coulomb_friction", &[20.0][..]), 20.0),
        (("stribeck_friction", &[8.0, 20.0, 1.0]), 20.0),
    ] {
        let moved = linear_run(6.0, 0.0, ramp, &[effect]);
        let first = moved.v.iter().position(|&v| v != 0.0).expect("it breaks away");
        let force = ramp(moved.time_s(first));
        assert!((force - limit).abs() < 5.0 * 2.0 * moved.step_s, "{}: {force}", effect.0);
    }
}

/// `F_c + (F_s − F_c) exp(−(v/v_s)²)`.
#[test]
fn the_stribeck_curve() {
    let p = [8.0, 20.0, 2.0];
    for v in [-5.0, -1.0, 0.0, 0.5, 2.0, 30.0] {
        let expected = 1e3 * (8.0 + 12.0 * (-(v / 2.0_f64).powi(2)).exp());
        let limit = EffectHooks::<f64>::dry_friction_mn(&StribeckFriction, &p, v);
        assert!((limit - expected).abs() < 1e-9 * expected, "{v}");
    }
}

/// Without damping the joint swings with amplitudes that fall by `2 F/K` each half period and stops inside
/// the band `|x| ≤ F/K`.
#[test]
fn free_motion_with_dry_friction_decays_linearly() {
    let (force, start) = (6e3, 1.0);
    let model = undamped();
    let subject = subject(&model, driven(6.0, start, |_| 0.0), MassOrigin::Given);
    let free = run(&model, &subject, &[("coulomb_friction", &[force / 1e3])]);
    let turns: Vec<f64> = (1..free.x.len() - 1)
        .filter(|&k| (free.x[k] - free.x[k - 1]) * (free.x[k + 1] - free.x[k]) < 0.0)
        .map(|k| free.x[k].abs())
        .collect();
    assert!(turns.len() >= 8, "{turns:?}");
    for (n, turn) in turns.iter().take(8).enumerate() {
        let expected = start - 2.0 * force / K * (n + 1) as f64;
        // A turn lies between grid points: x (ω h)²/8 with ω² = K/m, and the friction turns with the grid.
        let grid = start * K / M * free.step_s.powi(2);
        assert!((turn - expected).abs() < grid, "turn {n}: {turn} instead of {expected}");
    }
    let last = free.x.len() - 1;
    assert!(free.v[last] == 0.0 && free.x[last].abs() <= force / K);
}

/// In a steady cycle the motor's work is what damping and friction take: `∮ F dx = ∮ B ẋ² dt + 4 F_c A`.
#[test]
fn friction_takes_four_times_force_times_amplitude_a_cycle() {
    for (hertz, force) in [(0.5, 30.0), (1.0, 12.0)] {
        let rate = TAU * hertz;
        let drive = |t: f64| 110.0 * (rate * t).sin();
        let model = linear();
        let length = 6.0 + 3.0 / hertz;
        let subject = subject(&model, driven(length, 0.0, drive), MassOrigin::Given);
        let cycle = run(&model, &subject, &[("coulomb_friction", &[force])]);
        let count = (2.0 / (hertz * cycle.step_s)).round() as usize;
        let last = cycle.x.len() - 1 - count..cycle.x.len() - 1;
        let h = cycle.step_s;
        let lost: f64 = last
            .clone()
            .map(|k| 1e3 * drive(cycle.time_s(k) - HOLD) * cycle.v[k] - B * cycle.v[k].powi(2))
            .sum::<f64>()
            * h;
        let high = last.clone().map(|k| cycle.x[k]).fold(f64::MIN, f64::max);
        let low = last.map(|k| cycle.x[k]).fold(f64::MAX, f64::min);
        let expected = 2.0 * 4.0 * 1e3 * force * 0.5 * (high - low);
        // Work is summed on a grid of 4 ms: (ω h)² at the corners of the velocity.
        assert!((lost / expected - 1.0).abs() < 5e-3, "{hertz} Hz: {}", lost / expected);
    }
}
