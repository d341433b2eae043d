use pam_rig::sensors::{PressureParameters, PressureSensor};
use std::f64::consts::TAU;

/// A first-order low-pass of cutoff f_c delays a sine of frequency f by atan(f/f_c) / (2π f).
#[test]
fn the_low_pass_has_the_phase_of_first_order() {
    let ideal = PressureParameters { step_psi: 0.0, noise_psi: 0.0, ..Default::default() };
    for frequency in [0.5, 1.0, 2.0] {
        let mut sensor = PressureSensor::new(ideal, 1e-3);
        let (mut sine, mut cosine) = (0.0, 0.0);
        for k in 0..8000 {
            let phase = TAU * frequency * f64::from(k) * 1e-3;
            let (_, out) = sensor.read_psi(phase.sin(), 0.0);
            if k >= 4000 {
                sine += out * phase.sin();
                cosine += out * phase.cos();
            }
        }
        let delay_s = (-cosine).atan2(sine) / (TAU * frequency);
        let expected_s = (frequency / 3.0).atan() / (TAU * frequency);
        assert!((delay_s - expected_s).abs() < 1e-3, "{frequency} Hz: {delay_s} {expected_s}");
    }
}
