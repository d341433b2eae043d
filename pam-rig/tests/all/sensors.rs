//! What the sensors make of the truth.

mod encoder;
mod pressure;

use crate::common::{
    NEWTON_PER_AMPERE, PULLEY_MM, delay_ms, ideal, kpa, logged_kpa, logged_mm, phasor, sealed, sine,
};
use pam_core::NamedChoice;
use pam_rig::sensors::{Part, SensorParameters};
use pam_rig::{Frame, Protocol, RigParameters, record};
use std::f64::consts::{PI, TAU};

/// An ideal rig with one part as it really is.
fn real(change: impl Fn(&mut SensorParameters, &SensorParameters)) -> RigParameters {
    let mut parameters = ideal(&[]);
    change(&mut parameters.sensors, &SensorParameters::default());
    parameters
}

fn excited(parameters: &RigParameters) -> Vec<Frame> {
    sealed(parameters, [30.0, 60.0], 6.0, |t| sine(1.0, 0.5)(t) + sine(0.5, 3.0)(t))
}

#[test]
fn ideal_sensors_tell_the_truth() {
    for frame in excited(&ideal(&[])) {
        assert!((logged_mm(&frame) - frame.truth.displacement_mm).abs() < 1e-12);
        for (measured, truth) in logged_kpa(&frame).into_iter().zip(frame.truth.pressures_kpa) {
            assert!((measured / truth - 1.0).abs() < 1e-13);
        }
        assert!((-frame.row.current_a * NEWTON_PER_AMPERE - frame.truth.force_n).abs() < 1e-10);
    }
}

/// Every part that is not ideal shows, and only in its own columns.
#[test]
fn each_part_touches_its_own_columns() {
    let columns = |f: &Frame| {
        let r = &f.row;
        [vec![r.angle_deg], vec![r.command], vec![r.current_a], r.measured_psi.to_vec()]
    };
    let reference = excited(&ideal(&[]));
    for &(name, part, _) in Part::ALL {
        // All but this part ideal.
        let others = Part::ALL.iter().filter(|(_, p, _)| *p != part);
        let sensors =
            others.fold(SensorParameters::default(), |sensors, (_, p, _)| sensors.with_ideal(*p));
        let made = excited(&RigParameters { sensors, ..ideal(&[]) });
        let differ = |column: usize| {
            made.iter().zip(&reference).any(|(a, b)| columns(a)[column] != columns(b)[column])
        };
        let expected = match part {
            Part::Encoder => [true, false, false, false],
            Part::PressureLag | Part::PressureNoise => [false, false, false, true],
            Part::Current => [false, false, true, false],
            // The current itself has steps, and the clock shifts everything.
            Part::Motor => [true, true, true, true],
            Part::Clock => [true, false, false, true],
        };
        assert_eq!([0, 1, 2, 3].map(differ), expected, "{name}");
    }
}

/// 4096 positions a turn; the encoder counts against x.
#[test]
fn the_encoder_has_its_steps() {
    let parameters = real(|s, default| s.encoder = default.encoder);
    let step_mm = 0.087_890_625_f64.to_radians() * PULLEY_MM;
    let frames = excited(&parameters);
    for frame in &frames {
        assert_eq!((frame.row.angle_deg / 0.087_890_625).fract(), 0.0);
        let off = logged_mm(frame) - frame.truth.displacement_mm;
        assert!(off.abs() <= 0.5 * step_mm + 1e-12);
    }
    let mut angles: Vec<f64> = frames.iter().map(|f| f.row.angle_deg).collect();
    angles.sort_by(f64::total_cmp);
    angles.dedup();
    assert!(angles.windows(2).all(|w| w[1] - w[0] == 0.087_890_625), "steps are left out");
    assert!(angles.len() > 100);
}

/// The read-out moment scatters by 5 µs: 5e-6 of the velocity.
#[test]
fn jitter_is_a_scatter_of_the_moment() {
    let parameters = real(|s, default| s.clock.jitter_us = default.clock.jitter_us);
    let late_us: Vec<f64> = excited(&parameters)
        .iter()
        .filter(|f| f.truth.velocity_mm_s.abs() > 1.0)
        .map(|f| 1e6 * (logged_mm(f) - f.truth.displacement_mm) / f.truth.velocity_mm_s)
        .collect();
    let n = late_us.len() as f64;
    assert!(n > 2000.0);
    let mean = late_us.iter().sum::<f64>() / n;
    let spread = (late_us.iter().map(|t| (t - mean).powi(2)).sum::<f64>() / n).sqrt();
    assert!(mean.abs() < 0.4 && (spread - 5.0).abs() < 0.4, "{mean} ± {spread} µs");
}

/// A first-order low-pass of 3 Hz runs behind by atan(f/3)/(2π f), and takes the cosine of that phase.
#[test]
fn measured_pressures_lag_like_a_first_order_low_pass() {
    let parameters = real(|s, default| s.pressure.cutoff_hz = default.pressure.cutoff_hz);
    for frequency_hz in [0.5, 1.0, 2.0] {
        let frames = sealed(&parameters, [30.0, 60.0], 8.0, sine(1.0, frequency_hz));
        let settled = &frames[4000..];
        for i in 0..2 {
            let truth = || settled.iter().map(|f| f.truth.pressures_kpa[i]);
            let measured = || settled.iter().map(|f| logged_kpa(f)[i]);
            let phase = (frequency_hz / 3.0_f64).atan();
            let expected_ms = 1e3 * phase / (TAU * frequency_hz);
            let made_ms = delay_ms(truth(), measured(), frequency_hz);
            // Sampled each millisecond, the filter gains half a sample.
            assert!((made_ms - expected_ms + 0.5).abs() < 0.4, "{made_ms} of {expected_ms} ms");
            let gain = phasor(measured(), frequency_hz).0 / phasor(truth(), frequency_hz).0;
            assert!((gain - phase.cos()).abs() < 2e-3, "{gain}");
        }
    }
}

/// 16384 counts over 187.5 psi, and a small noise, before the low-pass.
#[test]
fn pressure_sensors_have_steps_and_noise() {
    let step = 150.0 / (0.8 * 16384.0);
    let quiet = real(|s, default| {
        s.pressure = default.pressure;
        (s.pressure.cutoff_hz, s.pressure.noise_psi) = (0.0, 0.0);
    });
    for frame in excited(&quiet) {
        for (measured, truth) in frame.row.measured_psi.into_iter().zip(frame.truth.pressures_kpa) {
            let counts = measured / step;
            assert!((counts - counts.round()).abs() < 1e-8);
            assert!((measured - (truth - 101.325) / 6.89476).abs() <= 0.5 * step + 1e-9);
        }
    }
    let noisy = real(|s, default| {
        s.pressure.noise_psi = default.pressure.noise_psi;
    });
    let frames = excited(&noisy);
    let off = |i: usize| {
        frames
            .iter()
            .map(move |f| f.row.measured_psi[i] - (f.truth.pressures_kpa[i] - 101.325) / 6.89476)
    };
    let n = frames.len() as f64;
    for i in 0..2 {
        let spread = (off(i).map(|d| d * d).sum::<f64>() / n).sqrt();
        assert!((spread / 0.008 - 1.0).abs() < 0.05, "{spread} psi");
    }
    let common = off(0).zip(off(1)).map(|(a, b)| a * b).sum::<f64>() / n;
    assert!(common.abs() < 0.06 * 0.008 * 0.008, "both sensors share their noise: {common}");
}

#[test]
fn the_current_sensor_has_steps_and_noise() {
    let parameters = real(|s, default| s.current = default.current);
    let frames = excited(&parameters);
    let off: Vec<f64> =
        frames.iter().map(|f| f.row.current_a + f.truth.force_n / NEWTON_PER_AMPERE).collect();
    for frame in &frames {
        assert_eq!((frame.row.current_a * 1024.0).fract(), 0.0);
    }
    let n = off.len() as f64;
    let mean = off.iter().sum::<f64>() / n;
    let spread = (off.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / n).sqrt();
    assert!(mean.abs() < 2e-3, "{mean} A");
    assert!((spread / 0.04 - 1.0).abs() < 0.05, "{spread} A");
}

/// The command has 12 bits for ±3 A around 2047 counts; the force is that of the counts.
#[test]
fn the_motor_follows_its_counts() {
    for frame in excited(&RigParameters::default()) {
        assert!((frame.row.command - frame.row.command.round()).abs() < 1e-9);
        let current_a = (frame.row.command - 2047.0) * 3.0 / 2047.0;
        assert!((frame.truth.force_n - current_a * 25.5 * 36.0 / 6.875).abs() < 1e-9);
    }
}

/// A current along +x moves the joint to +x, where the flexor loses pressure.
#[test]
fn signs_are_those_of_the_published_log() {
    let frames = sealed(&RigParameters::default(), [45.0, 45.0], 1.0, |_| 1.0);
    let last = &frames[999];
    assert!(last.truth.displacement_mm > 0.3 && last.row.angle_deg < -2.0);
    assert!(last.row.current_a < -0.8 && last.row.command > 2047.0);
    let [flexor, extensor] = last.truth.pressures_kpa;
    assert!(flexor < kpa(45.0) && extensor > kpa(45.0));
}

/// The whole rig at 30/60 psi: the source finds the measured pressure 31, 40 and 41 ms behind that of
/// isothermal air in the volume of the measured displacement (at 0.5, 1 and 2 Hz).
#[test]
fn the_whole_rig_shows_the_published_delay() {
    let text = "name = \"short\"\nconditions = [[30, 60]]\n".to_owned()
        + &[0.5, 1.0, 2.0]
            .map(|hz| {
                format!(
                    "[[current]]\nkind = \"sine\"\namplitude_a = 1.5\nfrequency_hz = {hz:?}\n\
                 duration_s = 12.0\n"
                )
            })
            .concat();
    let protocol = Protocol::parse(&text, "short.toml").unwrap();
    let run = &protocol.runs().unwrap()[0];
    let recorded = record(&RigParameters::default(), &protocol, run, 5).unwrap();
    let excited = &recorded.rows[recorded.rows.len() - 36_000..];
    for (i, frequency_hz) in [0.5, 1.0, 2.0].into_iter().enumerate() {
        let settled = &excited[12_000 * i + 4000..12_000 * (i + 1)];
        for (muscle, side) in [(0, 1.0), (1, -1.0)] {
            // The published geometry: V = π r² (L − c), r = r0 + 3.69 (r0/L) c.
            let isothermal = settled.iter().map(|row| {
                let c = -side * row.angle_deg.to_radians() * PULLEY_MM;
                let r = 5.0 + 3.69 * (5.0 / 200.0) * c;
                1.0 / (PI * r * r * (200.0 - c))
            });
            let measured = settled.iter().map(|row| row.measured_psi[muscle]);
            let delay = delay_ms(isothermal, measured, frequency_hz);
            assert!((20.0..45.0).contains(&delay), "{frequency_hz} Hz: {delay} ms");
        }
    }
}
