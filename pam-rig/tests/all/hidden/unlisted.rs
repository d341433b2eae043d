//! Phenomena beyond the vocabulary.

use crate::common::{
    MASS_KG, ideal, kpa, logged_kpa, logged_mm, phasor, plain, sealed, sine, unknown_force,
};
use pam_rig::plant::DryFriction;
use pam_rig::{Command, Frame, PressureCommand, Rig};
use std::f64::consts::TAU;

const PSI: [f64; 2] = [30.0, 60.0];

fn run(effect: &str) -> Vec<Frame> {
    sealed(&ideal(&[effect]), PSI, 3.0, sine(1.0, 1.0))
}

/// The time of a sample, s.
fn timed(frames: &[Frame]) -> impl Iterator<Item = (f64, &Frame)> {
    frames.iter().enumerate().map(|(k, f)| (k as f64 * 1e-3, f))
}

#[test]
fn periodic_disturbance() {
    let frames = sealed(
        &plain(&["periodic_disturbance:force_n=12,frequency_hz=1.25"]),
        PSI,
        8.0,
        sine(1.0, 1.0),
    );
    // Eight whole cycles from 1 s on; the first entry belongs to 1 ms.
    let forces = unknown_force(&frames, MASS_KG);
    let (amplitude, phase) = phasor(forces[999..7399].iter().map(|u| u.force_n), 1.25);
    let expected = TAU * 1.25;
    let late = (phase - expected).sin().atan2((phase - expected).cos());
    assert!((amplitude - 12.0).abs() < 0.05, "{amplitude} N");
    assert!(late.abs() < 0.02, "{late} rad");
}

/// The difference of the pressures of a joint that is held falls with twice the rate; no air is lost.
#[test]
fn chamber_crosstalk() {
    let mut parameters = plain(&["chamber_crosstalk:rate_per_s=0.1"]);
    parameters.plant.friction = DryFriction::coulomb(1e4);
    let frames = sealed(&parameters, PSI, 3.0, |_| 0.0);
    let difference = |f: &Frame| f.truth.pressures_kpa[1] - f.truth.pressures_kpa[0];
    let total = |f: &Frame| f.truth.masses_g[0] + f.truth.masses_g[1];
    for (t, frame) in timed(&frames) {
        let expected = difference(&frames[0]) * (-0.2 * t).exp();
        assert!((difference(frame) / expected - 1.0).abs() < 1e-4, "{t} s");
        assert!((total(frame) / total(&frames[0]) - 1.0).abs() < 1e-12);
    }
    // Only sealed chambers exchange air.
    let mut rig = Rig::new(&parameters, 1, 0.0).unwrap();
    rig.fill(PSI.map(kpa));
    let hold = Command { current_a: 0.0, pressure: PressureCommand::Servo(PSI) };
    let masses: Vec<_> = (0..1000).map(|_| rig.tick(&hold).truth.masses_g).collect();
    assert_eq!(masses[0], masses[999]);
}

#[test]
fn tendon_slip() {
    for (t, frame) in timed(&run("tendon_slip:time_s=1.5,slip_mm=0.4")) {
        let slip = if t < 1.4999 { 0.0 } else { 0.4 };
        let off = logged_mm(frame) - frame.truth.displacement_mm - slip;
        assert!((1.4999..1.5001).contains(&t) || off.abs() < 1e-12, "{off} mm at {t} s");
    }
}

#[test]
fn sensor_gain_jump() {
    for (t, frame) in timed(&run("sensor_gain_jump:time_s=1.5,relative=0.06")) {
        let gauge = frame.truth.pressures_kpa.map(|p| p - 101.325);
        let factor = if t < 1.4999 { 1.0 } else { 1.06 };
        let [flexor, extensor] = logged_kpa(frame).map(|p| p - 101.325);
        let off = flexor - factor * gauge[0];
        assert!((1.4999..1.5001).contains(&t) || off.abs() < 1e-9, "{off} kPa at {t} s");
        assert!((extensor - gauge[1]).abs() < 1e-9);
    }
}

/// After each full second the encoder stands still for 0.2 s and then tells the truth again.
#[test]
fn encoder_freeze() {
    let frames = run("encoder_freeze:period_s=1,duration_s=0.2");
    for (k, frame) in frames.iter().enumerate() {
        let (period, within) = (k / 1000, k % 1000);
        if [0, 1, 199, 200].contains(&within) {
            continue;
        }
        if period > 0 && within < 200 {
            let before = frames[1000 * period - 1].truth.displacement_mm;
            // The edge falls on a sample whose time carries rounding.
            let edge = frames[1000 * period].truth.displacement_mm;
            let seen = logged_mm(frame);
            assert!((seen - before).abs() < 1e-12 || (seen - edge).abs() < 1e-12, "{k}");
        } else {
            assert!((logged_mm(frame) - frame.truth.displacement_mm).abs() < 1e-12, "{k}");
        }
    }
}

/// 6 mg enter the flexor within 20 ms, nothing before, nothing after, nothing the extensor.
#[test]
fn valve_glitch() {
    let frames = run("valve_glitch:time_s=1.5,mass_mg=6");
    let mg = |k: usize| frames[k].truth.masses_g.map(|m| 1e3 * m);
    let start = mg(0);
    for k in 0..frames.len() {
        let entered = mg(k)[0] - start[0];
        let expected = 6.0 * ((k as f64 - 1500.0) / 20.0).clamp(0.0, 1.0);
        assert!((entered - expected).abs() < 1e-6, "{entered} mg at {k}");
        assert_eq!(mg(k)[1], start[1]);
    }
}
