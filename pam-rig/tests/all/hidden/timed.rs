//! Effects that begin, grow or end while the rig runs, read off truth and log.

use crate::common::{
    MASS_KG, ideal, largest, logged_kpa, logged_mm, plain, sealed, sine, unknown_force,
};
use pam_rig::{Effect, Frame};

const PSI: [f64; 2] = [45.0, 45.0];

fn run(effect: &str) -> Vec<Frame> {
    sealed(&plain(&[effect]), PSI, 4.0, sine(1.5, 1.0))
}

/// The samples between two times.
fn between(frames: &[Frame], from_s: f64, to_s: f64) -> &[Frame] {
    &frames[(1e3 * from_s) as usize..(1e3 * to_s) as usize]
}

/// Dry friction is in the set-up of the plant, which changes at its times.
#[test]
fn friction_comes_and_goes() {
    let frames = run("coulomb_friction:force_n=25,onset_s=1.5,end_s=3");
    let most =
        |from, to| largest(between(&frames, from, to).iter().map(|f| f.truth.friction_n.abs()));
    assert!(most(0.0, 1.5) < 1e-9 && most(3.0, 4.0) < 1e-9);
    assert!((most(1.6, 2.9) - 25.0).abs() < 1e-9, "{} N", most(1.6, 2.9));
    // Half of it in the middle of a ramp.
    let growing = run("coulomb_friction:force_n=24,onset_s=2,ramp_s=2");
    let sliding = |f: &&Frame| f.truth.velocity_mm_s.abs() > 5.0;
    for (k, f) in growing.iter().enumerate().filter(|(_, f)| sliding(f)) {
        let expected = 24.0 * ((k as f64 * 1e-3 - 2.0) / 2.0 + 0.5).clamp(0.0, 1.0);
        assert!((f.truth.friction_n.abs() - expected).abs() < 0.02, "{k} ms");
    }
}

/// A force with memory begins at rest with it: a damper's end is where the joint is.
#[test]
fn memory_begins_with_the_effect() {
    let frames = run("creep:stiffness_n_mm=20,time_constant_s=1000,onset_s=1.75");
    let start = frames[1750].truth.displacement_mm;
    for u in unknown_force(&frames, MASS_KG) {
        let spring = if u.time_s < 1.75 { 0.0 } else { -20.0 * (u.displacement_mm - start) };
        // The step of the force lies within one sample, and the damper hardly creeps in 2 s.
        let near = (u.time_s - 1.75).abs() < 2e-3;
        assert!(near || (u.force_n - spring).abs() < 0.1 + 0.01 * spring.abs(), "{u:?} {spring}");
    }
}

/// What the sensors show changes at the time, and a leak takes no air before it.
#[test]
fn sensors_and_air() {
    let frames = run("position_offset:offset_mm=0.3,end_s=2");
    let off = |f: &Frame| logged_mm(f) - f.truth.displacement_mm;
    assert!(between(&frames, 0.0, 1.99).iter().all(|f| (off(f) - 0.3).abs() < 1e-9));
    assert!(between(&frames, 2.01, 4.0).iter().all(|f| off(f).abs() < 1e-9));
    let frames = run("pressure_gain:flexor_relative=0.1,onset_s=2,ramp_s=1");
    let gain = |f: &Frame| (logged_kpa(f)[0] - 101.325) / (f.truth.pressures_kpa[0] - 101.325);
    for (time_s, expected) in [(1.4, 1.0), (2.0, 1.05), (2.6, 1.1)] {
        assert!((gain(&frames[(1e3 * time_s) as usize]) - expected).abs() < 1e-3, "{time_s} s");
    }
    let frames = run("leak:flexor_rate_per_s=0.05,onset_s=2");
    let mass = |k: usize| frames[k].truth.masses_g[0];
    assert!((mass(1999) / mass(0) - 1.0).abs() < 1e-12 && mass(3999) < 0.96 * mass(0));
}

/// Times stand in text and tables like parameters, and are checked like them.
#[test]
fn times_are_written_like_parameters() {
    let effect: Effect = "coulomb_friction:force_n=25,onset_s=35,ramp_s=2.5".parse().unwrap();
    assert_eq!(effect.to_string(), "coulomb_friction:force_n=25,onset_s=35,ramp_s=2.5");
    let json = serde_json::to_string(&effect).unwrap();
    assert_eq!(serde_json::from_str::<Effect>(&json).unwrap(), effect);
    // Without parameters of its own it takes its typical values.
    let typical: Effect = "coulomb_friction:end_s=35".parse().unwrap();
    assert_eq!(typical.values(), [20.0]);
    let message = |text: &str| text.parse::<Effect>().unwrap_err().to_string();
    assert!(message("coulomb_friction:force_n=1,ramp_s=2").contains("`onset_s` is missing"));
    assert!(message("coulomb_friction:force_n=1,onset_s=-2").contains("outside 0"));
    assert!(message("coulomb_friction:force_n=1,onset=2").contains("force_n, onset_s"));
    // A phenomenon whose own parameter has such a name keeps it.
    assert!("tendon_slip:time_s=1,slip_mm=0.4,end_s=2".parse::<Effect>().is_ok());
    let rig = ideal(&["coulomb_friction:force_n=25,onset_s=35"]);
    assert!(rig.to_toml().contains("onset_s = 35"));
}
