//! Effects combine.

use crate::common::{MASS_KG, ideal, logged_mm, plain, sealed, sine, unknown_force};
use pam_rig::Frame;
use pam_rig::effects::ALL;

/// An effect in a strength that shows within half a second.
fn loud(id: &str) -> String {
    let parameters = match id {
        "tendon_slack" => ":displacement_mm=0.3,stiffness_loss=0.4",
        "force_saturation" => ":force_n=120",
        "tendon_slip" => ":time_s=0.1,slip_mm=0.4",
        "sensor_gain_jump" => ":time_s=0.1,relative=0.06",
        "encoder_freeze" => ":period_s=0.1,duration_s=0.05",
        "valve_glitch" => ":time_s=0.1,mass_mg=6",
        _ => "",
    };
    format!("{id}{parameters}")
}

/// Every pair runs, and each of the two makes a difference beside the other.
#[test]
fn every_pair_of_effects_shows_both() {
    let run = |effects: &[&str]| sealed(&ideal(effects), [30.0, 60.0], 0.5, sine(1.5, 2.0));
    let effects: Vec<String> = ALL.iter().map(|e| loud(e.info.id)).collect();
    let alone: Vec<Vec<Frame>> = effects.iter().map(|e| run(&[e])).collect();
    let nothing = run(&[]);
    for (a, first) in effects.iter().enumerate() {
        assert!(alone[a] != nothing, "{first} does nothing");
        for (b, second) in effects.iter().enumerate().skip(a + 1) {
            let both = run(&[first, second]);
            assert!(both != alone[a], "{second} does nothing beside {first}");
            assert!(both != alone[b], "{first} does nothing beside {second}");
            let finite = both.iter().all(|f| {
                f.truth.displacement_mm.is_finite()
                    && f.truth.pressures_kpa.iter().all(|p| p.is_finite() && *p > 0.0)
            });
            assert!(finite, "{first} with {second}");
        }
    }
}

/// Forces add, and a leak beside them takes its air as if it were alone.
#[test]
fn each_keeps_its_meaning() {
    let effects = [
        "constant_load:force_n=20",
        "viscous_damping:coefficient_ns_m=3000",
        "leak:flexor_rate_per_s=0.05",
    ];
    let frames = sealed(&plain(&effects), [45.0, 45.0], 3.0, sine(1.0, 1.0));
    let points: Vec<_> =
        unknown_force(&frames, MASS_KG)[1..].iter().map(|u| (u.velocity_mm_s, u.force_n)).collect();
    let (slope, intercept) = crate::common::line(&points);
    assert!((slope + 3.0).abs() < 0.02 && (intercept - 20.0).abs() < 0.02, "{slope} {intercept}");
    let share = |f: &Frame| 1.0 - 101.325 / f.truth.pressures_kpa[0];
    let fed: f64 = frames.windows(2).map(|w| 0.5e-3 * (share(&w[0]) + share(&w[1]))).sum();
    let lost = (frames[2999].truth.masses_g[0] / frames[0].truth.masses_g[0]).ln();
    assert!((lost / (-0.05 * fed) - 1.0).abs() < 1e-5);
}

/// Sensor effects act in the order in which they are listed.
#[test]
fn order_is_that_of_the_list() {
    let run = |effects: &[&str]| sealed(&ideal(effects), [30.0, 60.0], 1.0, sine(1.0, 1.0));
    let (gain, offset) = ("position_gain:relative=0.5", "position_offset:offset_mm=0.2");
    for f in run(&[gain, offset]) {
        assert!((logged_mm(&f) - (1.5 * f.truth.displacement_mm + 0.2)).abs() < 1e-12);
    }
    for f in run(&[offset, gain]) {
        assert!((logged_mm(&f) - 1.5 * (f.truth.displacement_mm + 0.2)).abs() < 1e-12);
    }
}

/// Dry frictions add up to one that holds their sum.
#[test]
fn dry_frictions_add() {
    let effects = [
        "coulomb_friction:force_n=15",
        "stribeck_friction:coulomb_n=5,static_n=10,velocity_mm_s=1",
    ];
    let rests = |newton: f64| {
        let current = move |_| newton / crate::common::NEWTON_PER_AMPERE;
        let frames = sealed(&plain(&effects), [45.0, 45.0], 0.5, current);
        frames.iter().all(|f| f.truth.displacement_mm == 0.0)
    };
    assert!(rests(24.9) && !rests(25.1));
}
