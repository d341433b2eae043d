//! The plant of the studies against analytic solutions and an independent simulation, and the design of the studies.

use pam_core::activation::Activation;
use pam_core::force::{Dense, Mlp};
use pam_core::{AnyForce, JointModel, NetworkForce};
use pam_data::{Recording, load_model};
use pam_effects::ExtendedModel;
use pam_effects::simulation::{Base, Nuisances, Trajectory, Trial, simulate};
use pam_numerics::statistics::{root_mean_square, standard_deviation};
use pam_tests::diagnose::subject;
use pam_tests::magnitudes;
use pam_tests::plant::{Colour, Excitation, Experiment, Hidden, Noise, Plant, Sensors, masses};
use pam_tests::study::criteria::limits;
use pam_tests::study::{Case, Fault, Kind, Source, Strength, design, rows};
use pam_trajectory::{Predictor, SolverSettings};
use std::f64::consts::TAU;

/// mN/mm.
const STIFFNESS: f64 = 150e3;
const ATMOSPHERE_KPA: f64 = 101.325;

/// A joint with the restoring force `k x + b v` as a leaky ReLU network: `φ(u) − φ(−u) = 1.01 u` for a slope of 0.01. A bias
/// that the output takes away again keeps the second layer linear.
fn linear(damping: f64) -> JointModel<f64, AnyForce<f64>> {
    let [k, b] = [STIFFNESS, damping].map(|v| v / 1.01);
    let far = 1e9;
    let layers = vec![
        Dense::from_rows(&[0.0, 0.0, k, b, 0.0, 0.0, -k, -b], vec![0.0; 2]).unwrap(),
        Dense::from_rows(&[1.0, 0.0, 0.0, 1.0], vec![far; 2]).unwrap(),
        Dense::from_rows(&[1.0, -1.0], vec![0.0]).unwrap(),
    ];
    let activation = Activation::from_name("leaky_relu").unwrap();
    let network = NetworkForce::new(Mlp::new(layers, activation).unwrap()).unwrap();
    JointModel::datasheet(AnyForce::from(network))
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

fn recorded(
    model: &JointModel<f64, AnyForce<f64>>,
    excitation: &Excitation,
    effects: &[Hidden],
    sensors: &Sensors,
    longest_step_s: f64,
) -> Recording {
    let run = Experiment::new("nn_4545", [45.0, 45.0], excitation, effects, sensors, 1);
    Plant::of(model).record(&Experiment { longest_step_s, ..run })
}

fn published() -> JointModel<f64, AnyForce<f64>> {
    load_model(pam_tests::published_weights()).unwrap().model
}

/// A force that is held from the start.
fn held(force_n: f64, duration_s: f64) -> Excitation {
    Excitation::Steps { levels_n: vec![force_n], hold_s: duration_s }
}

/// `x = F/k (1 − e^(−δt)(cos ωt + δ/ω sin ωt))`, and the error falls with the square of the step.
#[test]
fn the_response_to_a_held_force_is_that_of_the_books() {
    let damping = 6000.0;
    let model = linear(damping);
    let mass = model.physical().mass_kg;
    let delta = damping / (2.0 * mass);
    let omega = (STIFFNESS / mass - delta * delta).sqrt();
    let worst = |step_s: f64| {
        let r = recorded(&model, &held(150.0, 1.0), &[], &quiet(100.0), step_s);
        let exact = |t: f64| {
            let decay = (-delta * t).exp();
            1.0 - decay * ((omega * t).cos() + delta / omega * (omega * t).sin())
        };
        let errors = r.time_s.iter().zip(&r.displacement_mm).map(|(t, x)| (x - exact(*t)).abs());
        errors.fold(0.0, f64::max)
    };
    let usual = worst(2.5e-4);
    assert!(usual < 1e-5, "{usual} mm");
    let order = (worst(2e-3) / worst(1e-3)).log2();
    assert!((order - 2.0).abs() < 0.2, "{order}");
}

/// With dry friction `F` an oscillation loses `4 F/k` of amplitude in each period, and sticks where the spring is weaker
/// than the friction.
#[test]
fn dry_friction_takes_a_constant_amplitude_from_each_period() {
    let friction = [Hidden::new("coulomb_friction", &[("force_n", 12.0)])];
    let r = recorded(&linear(0.0), &held(150.0, 4.0), &friction, &quiet(1000.0), 2.5e-4);
    let x = &r.displacement_mm;
    let peaks: Vec<f64> =
        x.windows(3).filter(|w| w[0] < w[1] && w[1] >= w[2]).map(|w| w[1]).collect();
    let loss = 4e3 * 12.0 / STIFFNESS;
    // The highest sample is within (ω/2 kHz)²/2 = 7e-5 of the peak.
    for pair in peaks.windows(2).take(2) {
        assert!((pair[0] - pair[1] - loss).abs() < 2e-4, "{pair:?}, loss {loss}");
    }
    let last = x[x.len() - 1];
    assert!((last - 1.0).abs() <= 1e3 * 12.0 / STIFFNESS, "{last} mm");
    assert!(x[x.len() - 500..].iter().all(|v| v.to_bits() == last.to_bits()), "it sticks");
}

/// A step in the encoder's zero is a position offset with an onset, and a step in a sensor's gain is a pressure gain with an onset: the
/// recordings are identical, so the study may count them as the same effect.
#[test]
fn sensor_steps_are_listed_effects_with_an_onset() {
    let jumps = [
        (
            Hidden::new("tendon_slip", &[("time_s", 1.0), ("slip_mm", 0.4)]),
            Hidden::new("position_offset", &[("offset_mm", 0.4)]),
        ),
        (
            Hidden::new("sensor_gain_jump", &[("time_s", 1.0), ("relative", 0.06)]),
            Hidden::new("pressure_gain", &[("flexor_relative", 0.06)]),
        ),
    ];
    let model = published();
    let of = |effects: &[Hidden]| recorded(&model, &held(40.0, 2.0), effects, &quiet(200.0), 1e-3);
    let none = of(&[]);
    for (jump, listed) in jumps {
        assert_eq!(jump.same_as(), listed.id);
        let found = of(std::slice::from_ref(&jump));
        assert_ne!(found, none);
        assert_eq!(found, of(&[listed.from_s(jump.begins_s())]), "{}", jump.id);
    }
}

#[test]
fn load_friction_is_proportional_to_the_mean_gauge_pressure() {
    // 45 psi.
    let gauge = 45.0 * 6.894_76;
    let model = linear(0.0);
    let end = |effects: &[Hidden]| {
        let r = recorded(&model, &held(150.0, 0.5), effects, &quiet(100.0), 2.5e-4);
        r.displacement_mm[r.len() - 1]
    };
    let by_load = end(&[Hidden::new("load_friction", &[("force_n_per_kpa", 12.0 / gauge)])]);
    let coulomb = end(&[Hidden::new("coulomb_friction", &[("force_n", 12.0)])]);
    // The mean pressure changes by less than a percent while the joint moves.
    assert!((by_load - coulomb).abs() < 0.02 * (coulomb - end(&[])).abs(), "{by_load} {coulomb}");
}

/// A sealed chamber at rest leaks as `P − P_atm = (P₀ − P_atm) e^(−rate t)`, and only on the side that leaks.
#[test]
fn a_leak_decays_to_the_atmosphere_on_its_side() {
    let effects = [
        Hidden::new("leak", &[("extensor_rate_per_s", 0.02)]),
        Hidden::new("coulomb_friction", &[("force_n", 1e3)]),
    ];
    let r = recorded(&linear(0.0), &held(0.0, 10.0), &effects, &quiet(100.0), 1e-3);
    let over = |k: usize| r.pressure_extensor_kpa[k] - ATMOSPHERE_KPA;
    let expected = (-0.02 * (r.time_s[r.len() - 1] - r.time_s[0])).exp();
    let found = over(r.len() - 1) / over(0);
    assert!((found - expected).abs() < 1e-4, "{found} {expected}");
    let flexor = &r.pressure_flexor_kpa;
    assert!((flexor[flexor.len() - 1] - flexor[0]).abs() < 1e-9);
}

/// Without effects the plant is the published model, simulated by other code.
#[test]
fn without_effects_the_plant_is_the_model() {
    let saved = load_model(pam_tests::published_weights()).unwrap();
    let sensors = Sensors { smooth_force: false, ..quiet(1000.0) };
    let r = recorded(&saved.model, &Excitation::published(0.1), &[], &sensors, 2.5e-4);
    let sealed = masses(&saved.model, &r);
    let model = ExtendedModel::from_saved(saved).unwrap();
    let run = model.predict(&r, sealed, &SolverSettings::default()).unwrap();
    let predicted = run.to_recording(&r, sealed);
    let worst =
        |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let x = worst(&predicted.displacement_mm, &r.displacement_mm);
    let p = worst(&predicted.pressure_extensor_kpa, &r.pressure_extensor_kpa);
    assert!(x < 1e-3 && p < 0.02, "{x} mm, {p} kPa");
}

/// The force of the published network has kinks, several of which a fast motion crosses within 4 ms. Steps of that length alias high harmonics
/// to lines between the harmonics of the excitation, of 5 ‰ of the motion here, and a diagnosis of precise recordings took such
/// lines for an effect of dry friction.
#[test]
fn kinks_of_the_force_make_no_motion_of_their_own() {
    let frequency_hz = 8.0;
    let saved = load_model(pam_tests::published_weights()).unwrap();
    let sines = Excitation::Sines(vec![[frequency_hz, 200.0, 8.0]]);
    let recording = recorded(&saved.model, &sines, &[], &quiet(2000.0), 2.5e-5);
    let trial = Trial::new(&saved.model, &subject(&saved, recording));
    let smooth = Nuisances { lead_samples: 0.5, ..Nuisances::none() };
    let mut out = Trajectory::default();
    simulate::<f64>(&trial, &Base::of(&saved.model), &[], &[], &smooth, &mut out).unwrap();
    // Whole cycles, after the transient.
    let cycles = 500..1750;
    let measured = &trial.record.measured[0][cycles.clone()];
    let mut apart: Vec<f64> =
        out.channels[0][cycles].iter().zip(measured).map(|(s, m)| s - m).collect();
    let len = apart.len() as f64;
    let per_point = TAU * frequency_hz * trial.record.step_s;
    for harmonic in 0..=15 {
        let wave = |f: fn(f64) -> f64| {
            (0..apart.len()).map(|k| f(f64::from(harmonic) * per_point * k as f64)).collect()
        };
        for wave in [wave(f64::cos), wave(f64::sin)] as [Vec<f64>; 2] {
            let size = wave.iter().map(|w| w * w).sum::<f64>().max(1e-3 * len);
            let part = apart.iter().zip(&wave).map(|(a, w)| a * w).sum::<f64>() / size;
            apart.iter_mut().zip(&wave).for_each(|(a, w)| *a -= part * w);
        }
    }
    let between = root_mean_square(&apart) / standard_deviation(measured);
    assert!(between < 3e-4, "{between}");
}

/// Amplitude and phase (rad) at 2 Hz of the second half of a channel.
fn phasor(r: &Recording, values: &[f64]) -> (f64, f64) {
    let half = r.len() / 2;
    let mean = values[half..].iter().sum::<f64>() / (r.len() - half) as f64;
    let sum = |f: fn(f64) -> f64| -> f64 {
        let each = r.time_s[half..].iter().zip(&values[half..]);
        each.map(|(t, v)| (v - mean) * f(TAU * 2.0 * t)).sum()
    };
    let (c, s) = (sum(f64::cos), sum(f64::sin));
    (c.hypot(s), s.atan2(c))
}

/// A first-order lag divides the amplitude by `√(1 + (f/f_c)²)` and turns the phase by `atan(f/f_c)`; a delay turns it by
/// `2π f τ`. A lag of the actuator does the same to x where the joint is linear.
#[test]
fn lags_and_delays_turn_the_phase() {
    let excitation = Excitation::Sines(vec![[2.0, 130.0, 6.0]]);
    let shift = |model: &JointModel<f64, AnyForce<f64>>, h: Hidden, pressure: bool| {
        let of = |effects: &[Hidden]| {
            let r = recorded(model, &excitation, effects, &quiet(500.0), 2.5e-4);
            let channel = if pressure { &r.pressure_flexor_kpa } else { &r.displacement_mm };
            phasor(&r, channel)
        };
        let ((a, p), (b, q)) = (of(&[]), of(&[h]));
        (b / a, (q - p).rem_euclid(TAU))
    };
    let [joint, spring] = [published(), linear(6000.0)];
    let ratio: f64 = 2.0 / 5.0;
    let lags = [
        ("position_sensor_lag", &joint, false),
        ("pressure_sensor_lag", &joint, true),
        ("actuator_lag", &spring, false),
    ];
    for (id, model, pressure) in lags {
        let (gain, phase) = shift(model, Hidden::new(id, &[("cutoff_hz", 5.0)]), pressure);
        assert!((gain - 1.0 / (1.0 + ratio * ratio).sqrt()).abs() < 2e-3, "{id}: {gain}");
        assert!((phase - ratio.atan()).abs() < 2e-3, "{id}: {phase}");
    }
    let delays = [
        ("position_delay", &joint, false),
        ("pressure_delay", &joint, true),
        ("actuation_delay", &spring, false),
    ];
    for (id, model, pressure) in delays {
        let (gain, phase) = shift(model, Hidden::new(id, &[("delay_ms", 20.0)]), pressure);
        assert!((gain - 1.0).abs() < 2e-3, "{id}: {gain}");
        assert!((phase - TAU * 0.04).abs() < 2e-3, "{id}: {phase}");
    }
}

/// A tenth of the step changes the displacement by less than 0.2 % of an encoder step, with stick–slip by less than 2 %.
#[test]
fn the_step_is_small_enough() {
    let stick = [
        Hidden::new(
            "stribeck_friction",
            &[("coulomb_n", 15.0), ("static_n", 25.0), ("velocity_mm_s", 2.0)],
        ),
        Hidden::new("coulomb_friction", &[("force_n", 10.0)]),
    ];
    let excitation = Excitation::Sines(vec![[2.0, 130.0, 3.0]]);
    for (effects, bound) in [(&[][..], 2e-5), (&stick[..], 2e-4)] {
        let run = |step_s| recorded(&published(), &excitation, effects, &quiet(200.0), step_s);
        let [coarse, fine] = [2.5e-4, 2.5e-5].map(run);
        let apart = coarse.displacement_mm.iter().zip(&fine.displacement_mm);
        let worst = apart.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst < bound, "{worst} mm with {} effects", effects.len());
    }
}

/// Before its onset an effect leaves every bit of the recording as it is.
#[test]
fn an_onset_begins_when_it_says() {
    let excitation = Excitation::Sines(vec![[2.0, 130.0, 3.0]]);
    let run = |effects: &[Hidden]| {
        recorded(&published(), &excitation, effects, &quiet(100.0), 2.5e-4).displacement_mm
    };
    let friction = Hidden::new("coulomb_friction", &[("force_n", 20.0)]).from_s(2.0);
    let (plain, late) = (run(&[]), run(&[friction]));
    let first = (0..plain.len()).find(|&k| plain[k] != late[k]).expect("it acts");
    assert!((200..205).contains(&first), "sample {first}");
}

#[test]
fn noises_have_their_deviation_and_correlation() {
    let rest = held(0.0, 100.0);
    // e^(−2π · 30 Hz · 1 ms) and e^(−1 ms/0.5 s).
    let colours =
        [(Colour::White, 0.0), (Colour::LowPassed(30.0), 0.8282), (Colour::Correlated(0.5), 0.998)];
    for (colour, expected) in colours {
        let sensors = Sensors { pressure: Noise { deviation: 2.0, colour }, ..quiet(1000.0) };
        let noisy = recorded(&linear(6000.0), &rest, &[], &sensors, 1e-3);
        let mean = 45.0 * 6.894_76 + ATMOSPHERE_KPA;
        let noise: Vec<f64> = noisy.pressure_flexor_kpa.iter().map(|p| p - mean).collect();
        let square = noise.iter().map(|v| v * v).sum::<f64>() / noise.len() as f64;
        let next = noise.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / noise.len() as f64;
        // A correlation time of 0.5 s leaves 100 independent values: 7 % error of the deviation.
        assert!((square.sqrt() / 2.0 - 1.0).abs() < 0.2, "{colour:?}: {}", square.sqrt());
        assert!((next / square - expected).abs() < 0.01, "{colour:?}: {}", next / square);
    }
}

/// Every effect of the vocabulary is hidden by the studies, with parameters that it has.
#[test]
fn the_studies_hide_the_whole_vocabulary() {
    for info in &pam_vocabulary::ALL {
        let mut variants = magnitudes::known().filter(|(id, _)| *id == info.id).peekable();
        assert!(variants.peek().is_some(), "no magnitude for `{}`", info.id);
        for name in variants.flat_map(|(_, names)| names) {
            assert!(info.parameters.iter().any(|p| p.name == name), "{}: `{name}`", info.id);
        }
    }
}

#[test]
fn the_design_repeats_and_is_balanced() {
    let cases = design::full();
    assert_eq!(cases, design::full());
    let rows = rows::all();
    let mut ids: Vec<&str> =
        cases.iter().chain(rows.iter().map(|r| &r.case)).map(|c| c.id.as_str()).collect();
    let all = ids.len();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), all);
    let own = |c: &&Case| c.repeats.is_none() && c.factors.source == Source::Plant;
    let nulls: Vec<&Case> = cases.iter().filter(|c| c.kind == Kind::Null).filter(own).collect();
    assert!(nulls.iter().filter(|c| c.factors.judgeable()).count() >= 150);
    for rate in design::RATES_HZ {
        let count = nulls.iter().filter(|c| c.factors.rate_hz == rate).count();
        assert!(count.abs_diff(nulls.len() / design::RATES_HZ.len()) <= 1, "{rate} Hz: {count}");
    }
    for label in magnitudes::labels() {
        let faults = [Fault::drawn(label, Strength::Medium)];
        assert!(cases.iter().any(|c| c.faults == faults), "{label}");
    }
}

/// Limits of Clopper and Pearson: `1 − 0.025^(1/n)` without a hit, and a value of the tables.
#[test]
fn binomial_limits_are_exact() {
    let [low, high] = limits(0, 20);
    assert!(low == 0.0 && (high - (1.0 - 0.025_f64.powf(0.05))).abs() < 1e-9, "{high}");
    let [low, high] = limits(5, 100);
    assert!((low - 0.016_431_9).abs() < 1e-5 && (high - 0.112_834_9).abs() < 1e-5, "{low} {high}");
}
