//! Effects in actuation and sensing: log and truth of a rig whose sensors are ideal but for the effect.

use crate::common::{
    NEWTON_PER_AMPERE, delay_ms, ideal, logged_kpa, logged_mm, phasor, sealed, sine,
};
use pam_rig::Frame;
use std::f64::consts::TAU;

const PSI: [f64; 2] = [30.0, 60.0];

fn run(effects: &[&str]) -> Vec<Frame> {
    sealed(&ideal(effects), PSI, 6.0, |t| sine(1.2, 0.5)(t) + sine(0.3, 2.0)(t))
}

fn commanded_n(frame: &Frame) -> f64 {
    -frame.row.current_a * NEWTON_PER_AMPERE
}

/// Largest difference between what is and what should be.
fn off(frames: &[Frame], made: impl Fn(&Frame) -> f64, expected: impl Fn(&Frame) -> f64) -> f64 {
    frames.iter().map(|f| (made(f) - expected(f)).abs()).fold(0.0, f64::max)
}

#[test]
fn force_gain() {
    let frames = run(&["force_gain:relative=-0.1"]);
    assert!(off(&frames, |f| f.truth.force_n, |f| 0.9 * commanded_n(f)) < 1e-9);
}

#[test]
fn force_saturation() {
    let frames = run(&["force_saturation:force_n=120"]);
    let clipped = |f: &Frame| commanded_n(f).clamp(-120.0, 120.0);
    assert!(off(&frames, |f| f.truth.force_n, clipped) < 1e-9);
    for side in [1.0, -1.0] {
        assert!(frames.iter().filter(|f| side * commanded_n(f) > 121.0).count() > 100);
    }
}

/// The real force is the recorded one of 15 ms ago.
#[test]
fn actuation_delay() {
    for (delay, samples) in [(15, 15), (40, 40)] {
        let frames = run(&[&format!("actuation_delay:delay_ms={delay}")]);
        for k in samples + 1..frames.len() {
            let expected = commanded_n(&frames[k - samples]);
            assert!((frames[k].truth.force_n - expected).abs() < 1e-9, "{k}");
        }
        assert_eq!(frames[samples - 1].truth.force_n, 0.0);
    }
}

/// A first-order low-pass of the force: gain `1/√(1 + (f/f_c)²)`, phase atan(f/f_c), and the command of the start is there at
/// once.
#[test]
fn actuator_lag() {
    for cutoff_hz in [1.5_f64, 6.0] {
        let effect = format!("actuator_lag:cutoff_hz={cutoff_hz}");
        let frames = sealed(&ideal(&[&effect]), PSI, 6.0, sine(1.0, 1.0));
        let truth = || frames[3000..].iter().map(|f| f.truth.force_n);
        let commanded = || frames[3000..].iter().map(commanded_n);
        let phase = (1.0 / cutoff_hz).atan();
        let made_ms = delay_ms(commanded(), truth(), 1.0);
        // Both are means from a sample to the next.
        assert!((made_ms - 1e3 * phase / TAU).abs() < 0.1, "{made_ms} ms");
        let gain = phasor(truth(), 1.0).0 / phasor(commanded(), 1.0).0;
        assert!((gain - phase.cos()).abs() < 1e-4, "{gain}");
        let held = sealed(&ideal(&[&effect]), PSI, 0.1, |_| 0.5);
        assert!((held[0].truth.force_n - commanded_n(&held[0])).abs() < 1e-9);
    }
}

/// A first-order low-pass: phase atan(f/f_c), gain the cosine of the phase.
#[test]
fn pressure_sensor_lag() {
    for cutoff_hz in [1.5_f64, 6.0] {
        let effect = format!("pressure_sensor_lag:cutoff_hz={cutoff_hz}");
        let frames = sealed(&ideal(&[&effect]), PSI, 6.0, sine(1.0, 1.0));
        for i in 0..2 {
            let truth = || frames[3000..].iter().map(|f| f.truth.pressures_kpa[i]);
            let measured = || frames[3000..].iter().map(|f| logged_kpa(f)[i]);
            let phase = (1.0 / cutoff_hz).atan();
            // Half a sample less because it is sampled.
            let expected_ms = 1e3 * phase / TAU - 0.5;
            let made_ms = delay_ms(truth(), measured(), 1.0);
            assert!((made_ms - expected_ms).abs() < 0.5, "{made_ms} of {expected_ms} ms");
            let gain = phasor(measured(), 1.0).0 / phasor(truth(), 1.0).0;
            assert!((gain - phase.cos()).abs() < 5e-3, "{gain}");
        }
    }
}

#[test]
fn pressure_delay() {
    let frames = run(&["pressure_delay:delay_ms=40"]);
    for k in 41..frames.len() {
        for i in 0..2 {
            let expected = frames[k - 40].truth.pressures_kpa[i];
            assert!((logged_kpa(&frames[k])[i] - expected).abs() < 1e-9, "{k}");
        }
    }
}

#[test]
fn pressure_bias() {
    let frames = run(&["pressure_bias:flexor_kpa=8,extensor_kpa=-5"]);
    for (i, bias) in [8.0, -5.0].into_iter().enumerate() {
        assert!(off(&frames, |f| logged_kpa(f)[i], |f| f.truth.pressures_kpa[i] + bias) < 1e-9);
    }
}

/// The factor is that of gauge pressures: room pressure is read as room pressure.
#[test]
fn pressure_gain() {
    let frames = run(&["pressure_gain:flexor_relative=0.05,extensor_relative=-0.03"]);
    let gauge = |kpa: f64| kpa - 101.325;
    for (i, factor) in [1.05, 0.97].into_iter().enumerate() {
        let expected = |f: &Frame| factor * gauge(f.truth.pressures_kpa[i]);
        assert!(off(&frames, |f| gauge(logged_kpa(f)[i]), expected) < 1e-9);
    }
}

#[test]
fn position_offset() {
    let frames = run(&["position_offset:offset_mm=0.2"]);
    assert!(off(&frames, logged_mm, |f| f.truth.displacement_mm + 0.2) < 1e-12);
}

/// A first-order low-pass, as of the pressures.
#[test]
fn position_sensor_lag() {
    for cutoff_hz in [1.5_f64, 6.0] {
        let effect = format!("position_sensor_lag:cutoff_hz={cutoff_hz}");
        let frames = sealed(&ideal(&[&effect]), PSI, 6.0, sine(1.0, 1.0));
        let truth = || frames[3000..].iter().map(|f| f.truth.displacement_mm);
        let measured = || frames[3000..].iter().map(logged_mm);
        let phase = (1.0 / cutoff_hz).atan();
        // Half a sample less because it is sampled.
        let expected_ms = 1e3 * phase / TAU - 0.5;
        let made_ms = delay_ms(truth(), measured(), 1.0);
        assert!((made_ms - expected_ms).abs() < 0.5, "{made_ms} of {expected_ms} ms");
        let gain = phasor(measured(), 1.0).0 / phasor(truth(), 1.0).0;
        assert!((gain - phase.cos()).abs() < 5e-3, "{gain}");
    }
}

#[test]
fn position_delay() {
    let frames = run(&["position_delay:delay_ms=20"]);
    for k in 21..frames.len() {
        let expected = frames[k - 20].truth.displacement_mm;
        assert!((logged_mm(&frames[k]) - expected).abs() < 1e-12, "{k}");
    }
}

#[test]
fn position_gain() {
    let frames = run(&["position_gain:relative=0.05"]);
    assert!(off(&frames, logged_mm, |f| 1.05 * f.truth.displacement_mm) < 1e-12);
}

/// A sensor that lies does not move a sealed joint, and does not touch the other sensors.
#[test]
fn sensors_leave_the_joint_alone() {
    let plain = run(&[]);
    for effect in [
        "pressure_sensor_lag",
        "pressure_delay",
        "pressure_bias",
        "pressure_gain",
        "position_offset",
        "position_gain",
        "position_sensor_lag",
        "position_delay",
        "backlash",
        "encoder_freeze:period_s=1,duration_s=0.2",
        "sensor_gain_jump:time_s=1,relative=0.1",
        "tendon_slip:time_s=1,slip_mm=0.3",
    ] {
        let made = run(&[effect]);
        assert!(made.iter().zip(&plain).all(|(a, b)| a.truth == b.truth), "{effect}: other truth");
        let angles = made.iter().zip(&plain).any(|(a, b)| a.row.angle_deg != b.row.angle_deg);
        let pressures =
            made.iter().zip(&plain).any(|(a, b)| a.row.measured_psi != b.row.measured_psi);
        assert!(angles != pressures, "{effect}: angle {angles}, pressures {pressures}");
        let currents = made.iter().zip(&plain).any(|(a, b)| a.row.current_a != b.row.current_a);
        assert!(!currents, "{effect}: other currents");
    }
}

/// A servo follows what it measures: with sensors that read 10 % too much the air is 10 % too little.
#[test]
fn a_servo_believes_its_sensors() {
    use pam_rig::{Command, PressureCommand, Rig};
    let effect = "pressure_gain:flexor_relative=0.1,extensor_relative=0";
    let mut rig = Rig::new(&ideal(&[effect]), 1, 0.0).unwrap();
    let command = Command { current_a: 0.0, pressure: PressureCommand::Servo([60.0, 60.0]) };
    let last = (0..8000).map(|_| rig.tick(&command)).last().unwrap();
    let gauge = last.truth.pressures_kpa.map(|p| (p - 101.325) / 6.89476);
    assert!((gauge[0] - 60.0 / 1.1).abs() < 1.0 && (gauge[1] - 60.0).abs() < 1.0, "{gauge:?}");
}
