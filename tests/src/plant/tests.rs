//! The plant against analytic solutions.

use super::acting::Acting;
use super::motion::Joint;
use super::network::ReluNetwork;
use super::*;

const STIFFNESS: f64 = 150e3;
const MASS: f64 = 300.0;

/// A joint with the linear restoring force `k x + b v`: `φ(u) − φ(−u) = 1.01 u` for a slope of 0.01.
fn linear(damping: f64) -> Plant {
    let k = STIFFNESS / 1.01;
    let b = damping / 1.01;
    // The second layer keeps both units apart by a bias that the output takes away again.
    let first = (vec![0.0, 0.0, k, b, 0.0, 0.0, -k, -b], vec![0.0; 2]);
    let far = 1e9;
    let second = (vec![1.0, 0.0, 0.0, 1.0], vec![far, far]);
    let network = ReluNetwork::new(0.01, [first, second], (vec![1.0, -1.0], 0.0));
    Plant { network, mass_kg: MASS, deformation: 3.69, gas_coefficient: 8.47e7 }
}

fn at_rest(plant: &Plant, effects: &[Hidden]) -> (Joint, Acting) {
    let acting = Acting::at(effects, 0.0);
    (Joint::at_rest(plant, [412.0, 412.0], &acting), acting)
}

/// Displacement at 1 s after release at 1 mm.
fn released(damping: f64, effects: &[Hidden], dt: f64) -> f64 {
    let (mut joint, acting) = at_rest(&linear(damping), effects);
    joint.x = 1.0;
    let steps = (1.0 / dt).round() as usize;
    (0..steps).for_each(|k| joint.step(0.0, (k as f64 + 0.5) * dt, &acting, dt));
    joint.x
}

/// `x = e^(−δt)(cos ωt + δ/ω sin ωt)`, and the error falls with the square of the step.
#[test]
fn a_damped_oscillation_is_that_of_the_books() {
    let damping = 6000.0;
    let delta: f64 = damping / (2.0 * MASS);
    let omega = (STIFFNESS / MASS - delta * delta).sqrt();
    let exact = (-delta).exp() * (omega.cos() + delta / omega * omega.sin());
    let error = |dt: f64| (released(damping, &[], dt) - exact).abs();
    let (coarse, fine) = (error(2.5e-4), error(1.25e-4));
    assert!(coarse < 1e-9, "{coarse} mm");
    let order = (error(2e-3) / error(1e-3)).log2();
    assert!((order - 2.0).abs() < 0.2, "{order}");
    assert!(fine < coarse);
}

/// With dry friction `F` a free oscillation loses `4 F/k` of amplitude in each period, and sticks where the spring
/// is weaker than the friction.
#[test]
fn dry_friction_takes_a_constant_amplitude_from_each_period() {
    let force = 12.0;
    let friction = Hidden::new("coulomb_friction", &[("force_n", force)]);
    let (mut joint, acting) = at_rest(&linear(0.0), &[friction]);
    joint.x = 1.0;
    let dt = 2.5e-4;
    let mut peaks = vec![1.0];
    for k in 0..8000 {
        let before = joint.v;
        joint.step(0.0, (f64::from(k) + 0.5) * dt, &acting, dt);
        if before > 0.0 && joint.v <= 0.0 {
            peaks.push(joint.x);
        }
    }
    let loss = 4e3 * force / STIFFNESS;
    for (n, pair) in peaks.windows(2).take(2).enumerate() {
        assert!((pair[0] - pair[1] - loss).abs() < 2e-5, "period {n}: {pair:?}, loss {loss}");
    }
    assert_eq!(joint.v, 0.0);
    assert!(joint.x.abs() <= 1e3 * force / STIFFNESS, "{} mm", joint.x);
    let stuck = joint.x;
    let free = 1e3 * force - STIFFNESS * stuck.abs();
    joint.step(0.9 * free.copysign(stuck), 2.0, &acting, dt);
    assert_eq!(joint.x.to_bits(), stuck.to_bits());
}

/// Friction that grows with load is the Coulomb friction of that pressure.
#[test]
fn load_friction_is_proportional_to_the_mean_gauge_pressure() {
    let gauge = 412.0 - ATMOSPHERE_KPA;
    let by_load = Hidden::new("load_friction", &[("force_n_per_kpa", 12.0 / gauge)]);
    let coulomb = Hidden::new("coulomb_friction", &[("force_n", 12.0)]);
    // The mean pressure changes by less than a percent while the joint moves.
    let [a, b] = [by_load, coulomb].map(|h| released(0.0, &[h], 2.5e-4));
    let free = released(0.0, &[], 2.5e-4);
    assert!((a - b).abs() < 0.02 * (b - free).abs(), "{a} {b} {free}");
}

/// A sealed chamber at rest leaks as `P − P_atm = (P₀ − P_atm) e^(−rate t)`, and only the side that leaks.
#[test]
fn a_leak_decays_to_the_atmosphere_on_its_side() {
    let leak = Hidden::new("leak", &[("extensor_rate_per_s", 0.02)]);
    let friction = Hidden::new("coulomb_friction", &[("force_n", 1e3)]);
    let (mut joint, acting) = at_rest(&linear(0.0), &[leak, friction]);
    let dt = 1e-3;
    (0..10_000).for_each(|k| joint.step(0.0, (f64::from(k) + 0.5) * dt, &acting, dt));
    let expected = ATMOSPHERE_KPA + (412.0 - ATMOSPHERE_KPA) * (-0.2_f64).exp();
    let [flexor, extensor] = joint.pressures_kpa;
    assert!((flexor - 412.0).abs() < 1e-9, "{flexor}");
    assert!((extensor - expected).abs() < 0.01, "{extensor} {expected}");
}

fn quiet(rate_hz: f64) -> Sensors {
    let none = Noise::white(0.0);
    Sensors {
        rate_hz,
        encoder_mm: 0.0,
        displacement: none,
        pressure: none,
        force: none,
        smooth_force: true,
        cutoff_hz: 0.0,
    }
}

fn published() -> Plant {
    Plant::of(&pam_data::load_model(&crate::published_weights()).unwrap().model)
}

fn recorded(effects: &[Hidden], rate_hz: f64, longest_step_s: f64) -> Recording {
    let excitation = Excitation::Sines(vec![[2.0, 130.0, 4.0]]);
    let sensors = quiet(rate_hz);
    let run = Experiment {
        longest_step_s,
        ..Experiment::new("nn_4545", [45.0, 45.0], &excitation, effects, &sensors, 1)
    };
    published().record(&run)
}

/// Amplitude and phase (rad) of the second half of a channel at 2 Hz.
fn phasor(r: &Recording, values: &[f64]) -> (f64, f64) {
    let half = r.len() / 2;
    let mean = values[half..].iter().sum::<f64>() / (r.len() - half) as f64;
    let w = std::f64::consts::TAU * 2.0;
    let sum = |f: fn(f64) -> f64| -> f64 {
        let each = r.time_s[half..].iter().zip(&values[half..]);
        each.map(|(t, v)| (v - mean) * f(w * t)).sum()
    };
    let (c, s) = (sum(f64::cos), sum(f64::sin));
    (c.hypot(s), c.atan2(s))
}

/// A first-order lag divides the amplitude by `√(1 + (f/f_c)²)` and shifts the phase by `atan(f/f_c)`; a delay shifts it by
/// `2π f τ`. The actuator's lag acts on the joint, which turns a phase into the same phase of x only where it is linear:
/// that is not asked here.
#[test]
fn lags_and_delays_shift_as_they_must() {
    let plain = recorded(&[], 500.0, 2.5e-4);
    let shift = |h: Hidden, pressure: bool| {
        let late = recorded(&[h], 500.0, 2.5e-4);
        let channel = |r: &Recording| {
            if pressure { r.pressure_flexor_kpa.clone() } else { r.displacement_mm.clone() }
        };
        let ((a, p), (b, q)) = (phasor(&plain, &channel(&plain)), phasor(&late, &channel(&late)));
        (b / a, (p - q).rem_euclid(std::f64::consts::TAU))
    };
    let ratio: f64 = 2.0 / 5.0;
    for (id, pressure) in [("position_sensor_lag", false), ("pressure_sensor_lag", true)] {
        let (gain, phase) = shift(Hidden::new(id, &[("cutoff_hz", 5.0)]), pressure);
        assert!((gain - 1.0 / (1.0 + ratio * ratio).sqrt()).abs() < 2e-3, "{id}: {gain}");
        assert!((phase - ratio.atan()).abs() < 2e-3, "{id}: {phase}");
    }
    for (id, pressure) in [("position_delay", false), ("pressure_delay", true)] {
        let (gain, phase) = shift(Hidden::new(id, &[("delay_ms", 20.0)]), pressure);
        assert!((gain - 1.0).abs() < 2e-3, "{id}: {gain}");
        assert!((phase - std::f64::consts::TAU * 0.04).abs() < 2e-3, "{id}: {phase}");
    }
    let (gain, phase) = shift(Hidden::new("actuator_lag", &[("cutoff_hz", 5.0)]), false);
    assert!(gain < 1.0 && phase > 0.2, "{gain} {phase}");
}

/// The default step is accurate: a step of a tenth changes the displacement by less than 0.1 µm without stick and slip,
/// and with it by less than 1 % of an encoder step.
#[test]
fn the_step_is_small_enough() {
    let stick = [
        Hidden::new(
            "stribeck_friction",
            &[("coulomb_n", 15.0), ("static_n", 25.0), ("velocity_mm_s", 2.0)],
        ),
        Hidden::new("coulomb_friction", &[("force_n", 10.0)]),
    ];
    for (effects, bound) in [(&[][..], 1e-4), (&stick[..], 1e-4)] {
        let [coarse, fine] = [2.5e-4, 2.5e-5].map(|dt| recorded(effects, 200.0, dt));
        let apart = coarse.displacement_mm.iter().zip(&fine.displacement_mm);
        let worst = apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst < bound, "{worst} mm with {} effects", effects.len());
    }
}

/// Before its onset an effect leaves every bit of the recording as it is.
#[test]
fn an_onset_begins_when_it_says() {
    let friction = Hidden::new("coulomb_friction", &[("force_n", 20.0)]).from_s(2.0);
    let (plain, late) = (recorded(&[], 100.0, 2.5e-4), recorded(&[friction], 100.0, 2.5e-4));
    let differs = |k: &usize| plain.displacement_mm[*k] != late.displacement_mm[*k];
    let first = (0..plain.len()).find(differs).expect("it acts");
    assert!((2.0..2.05).contains(&plain.time_s[first]), "{}", plain.time_s[first]);
}
