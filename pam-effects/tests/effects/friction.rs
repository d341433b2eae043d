//! Dry friction.

use crate::support::joint::{B, HOLD, K, M, P, driven, linear, linear_run, run, subject, undamped};
use pam_core::units::ATMOSPHERE_KPA;
use pam_data::MassOrigin;
use pam_effects::effects::{EffectHooks, FixedState, StribeckFriction};
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
        let mut joint = FixedState::at_rest([P; 2]);
        joint.motion.velocity_mm_s = v;
        let limit = EffectHooks::<f64>::dry_friction_mn(&StribeckFriction, &p, &joint.point(), &[]);
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

/// Friction of the load is its coefficient times the mean gauge pressure, here 310.7 kPa: it holds that much, and takes four
/// times that and the amplitude a cycle.
#[test]
fn friction_of_the_load_is_proportional_to_gauge_pressure() {
    let gauge = P - ATMOSPHERE_KPA;
    let limit = 20.0;
    let own: &[f64] = &[limit / gauge];
    for (share, held) in [(0.99, true), (1.01, false)] {
        let run =
            linear_run(6.0, 0.0, |t| share * limit * (TAU * t).sin(), &[("load_friction", own)]);
        assert_eq!(run.x.iter().all(|&x| x == 0.0), held, "{share} of the limit");
    }
    // The mean of both pressures changes with the square of x alone: by less than 1e-3 within 1 mm.
    let drive = |t: f64| 110.0 * (TAU * t).sin();
    let load = linear_run(9.0, 0.0, drive, &[("load_friction", own)]);
    let plain = linear_run(9.0, 0.0, drive, &[("coulomb_friction", &[limit])]);
    let free = linear_run(9.0, 0.0, drive, &[]);
    let rms = |f: &dyn Fn(usize) -> f64| plain.settled().map(|k| f(k).powi(2)).sum::<f64>().sqrt();
    let effect = rms(&|k| plain.x[k] - free.x[k]);
    let difference = rms(&|k| plain.x[k] - load.x[k]);
    assert!(difference < 2e-3 * effect, "{}", difference / effect);
}

/// The joint with set-valued friction and a force that acts half a sample late, by 2 µs of Moreau's time stepping: the
/// displacement at multiples of `every_s`.
fn marched(
    duration_s: f64,
    force_n: impl Fn(f64) -> f64,
    friction_n: f64,
    every_s: f64,
) -> Vec<f64> {
    const H: f64 = 2e-6;
    let damped = 1.0 + 0.5 * H * B / M;
    let (mut x, mut v) = (0.0_f64, 0.0_f64);
    let every = (every_s / H).round() as usize;
    let mut out = Vec::new();
    for i in 0..=(duration_s / H).round() as usize {
        if i % every == 0 {
            out.push(x);
        }
        let force = 1e3 * force_n((i as f64 + 0.5) * H - HOLD) - K * (x + 0.5 * H * v);
        let free = (v * (2.0 - damped) + H / M * force) / damped;
        let most = H / M * 1e3 * friction_n / damped;
        let after = if free.abs() <= most { 0.0 } else { free - most.copysign(free) };
        x += 0.5 * H * (v + after);
        v = after;
    }
    out
}

/// What friction does to the motion is right to a thousandth also where the joint turns within a step, at 8 Hz
/// four times in 62 steps.
#[test]
fn fast_reversals_are_accurate() {
    let model = linear();
    for hertz in [1.0, 4.0, 8.0] {
        for friction in [5.0, 25.0] {
            let drive = |t: f64| 100.0 * (TAU * hertz * t).sin();
            let subject = subject(&model, driven(3.0, 0.0, drive), MassOrigin::Given);
            let rough = run(&model, &subject, &[("coulomb_friction", &[friction])]);
            let free = run(&model, &subject, &[]);
            let exact = [friction, 0.0].map(|f| marched(3.0, drive, f, rough.step_s));
            // How the motion begins depends on the first samples.
            let rms = |f: &dyn Fn(usize) -> f64| {
                (250..rough.x.len()).map(|k| f(k).powi(2)).sum::<f64>().sqrt()
            };
            let effect = rms(&|k| exact[0][k] - exact[1][k]);
            let whole = rms(&|k| rough.x[k] - exact[0][k]) / effect;
            let own = rms(&|k| (rough.x[k] - free.x[k]) - (exact[0][k] - exact[1][k])) / effect;
            println!(
                "{hertz} Hz, {friction} N: {own:.1e} of friction's effect, {whole:.1e} in all"
            );
            assert!(own < 1e-3, "{hertz} Hz, {friction} N: {own:e}");
        }
    }
}

/// Derivatives of the motion by the friction force pass the turns: they are those of the marched joint, by central
/// differences.
#[test]
fn derivatives_pass_the_turns() {
    use pam_effects::effects::{AnyEffect, Derivatives, by_id};
    use pam_effects::simulation::{Base, Nuisances, Trajectory, Trial, simulate};
    let model = linear();
    let hertz = 6.0;
    let drive = |t: f64| 100.0 * (TAU * hertz * t).sin();
    let subject = subject(&model, driven(2.0, 0.0, drive), MassOrigin::Given);
    let trial = Trial::new(&model, &subject);
    let effect: &dyn AnyEffect = by_id("coulomb_friction").expect("an id");
    let mut out = Trajectory::default();
    let value = [Derivatives::variable(15.0, 0)];
    let none = Nuisances::none();
    simulate(&trial, &Base::of(&model), &[effect], &value, &none, &mut out).expect("in range");
    let [up, down] = [15.5, 14.5].map(|f| marched(2.0, drive, f, trial.record.step_s));
    let (mut miss, mut size) = (0.0, 0.0);
    for (k, x) in out.channels[0].iter().enumerate() {
        let expected = up[k] - down[k];
        miss += (x.derivatives[0] - expected).powi(2);
        size += expected.powi(2);
    }
    let relative = (miss / size).sqrt();
    println!("derivative by the friction: {relative:.1e}");
    assert!(relative < 5e-3, "{relative:e}");
}
