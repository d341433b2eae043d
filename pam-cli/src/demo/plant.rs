//! A made-up joint for the demo, recorded as a raw log.
//!
//! It is not the model: its spring hardens, it has dry friction that truly sticks, and its sensors
//! quantise, lag and add noise. It shares no force code with the models.

use pam_core::units::{
    ATMOSPHERE_KPA, GEAR_RATIO, KPA_PER_PSI, PULLEY_RADIUS_MM, TORQUE_CONSTANT_MNM_PER_A,
};
use pam_data::formats::raw_log::{Row, to_text};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use std::f64::consts::{PI, TAU};

/// Frames per second of the log.
const RATE_HZ: f64 = 1000.0;
/// Integration steps a frame.
const SUBSTEPS: usize = 10;
/// Time at rest before the excitation, s.
const REST_S: f64 = 3.0;
/// Excitation: frequency (Hz), length (s).
const PROTOCOL: [(f64, f64); 3] = [(0.5, 10.0), (1.0, 6.0), (2.0, 4.0)];
/// Encoder resolution, deg.
const ENCODER_STEP_DEG: f64 = 0.087_890_6;
/// Cutoff of the pressure sensors' low-pass, Hz.
const SENSOR_CUTOFF_HZ: f64 = 3.0;

/// The made-up joint.
#[derive(Debug, Clone)]
pub(super) struct Plant {
    seed: u64,
    pressure_psi: [f64; 2],
    friction_n: f64,
    stiffness_n_mm: f64,
    hardening: f64,
    damping_ns_mm: f64,
    mass_kg: f64,
    deformation: f64,
}

impl Plant {
    pub(super) fn seeded(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let psi = 5.0 * f64::from(rng.random_range(5_u32..=12));
        let stiffness = 127.3 + (175.3 - 127.3) * (psi - 10.0) / 70.0;
        Self {
            seed,
            pressure_psi: [psi, psi],
            friction_n: rng.random_range(25.0..45.0),
            stiffness_n_mm: stiffness * rng.random_range(0.95..1.05),
            hardening: rng.random_range(0.02..0.06),
            damping_ns_mm: rng.random_range(5.0..7.0),
            mass_kg: 260.0,
            deformation: 3.9,
        }
    }

    pub(super) fn log_name(&self) -> String {
        format!("nn_{:02.0}{:02.0}", self.pressure_psi[0], self.pressure_psi[1])
    }

    pub(super) fn describe(&self) -> String {
        format!(
            "{:.0} psi in both muscles, a hardening spring of {:.0} N/mm, {:.0} N of dry friction, \
             lagging pressure sensors",
            self.pressure_psi[0], self.stiffness_n_mm, self.friction_n
        )
    }

    /// Runs the protocol and returns the raw log's text.
    pub(super) fn record(&self) -> String {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed ^ 0x9e37_79b9_7f4a_7c15);
        let normal = |sd: f64| Normal::new(0.0, sd).expect("a positive spread");
        let (current_noise, pressure_noise) = (normal(0.02), normal(0.01));
        let n_per_a = TORQUE_CONSTANT_MNM_PER_A * GEAR_RATIO / PULLEY_RADIUS_MM;
        let dt = 1.0 / (RATE_HZ * SUBSTEPS as f64);
        let lag = 1.0 - (-TAU * SENSOR_CUTOFF_HZ / RATE_HZ).exp();
        let total_s = REST_S + PROTOCOL.iter().map(|p| p.1).sum::<f64>();
        let frames = (total_s * RATE_HZ) as usize;
        let (mut x, mut v) = (0.0, 0.0);
        let mut sensed = self.pressures_psi(x);
        let mut rows = Vec::with_capacity(frames);
        for frame in 0..frames {
            let t = frame as f64 / RATE_HZ - REST_S;
            let current = excitation_a(t);
            for _ in 0..SUBSTEPS {
                (x, v) = self.step(x, v, n_per_a * current, dt);
            }
            for (s, p) in sensed.iter_mut().zip(self.pressures_psi(x)) {
                *s += lag * (p - *s);
            }
            let angle = -(x / PULLEY_RADIUS_MM).to_degrees();
            rows.push(Row {
                angle_deg: (angle / ENCODER_STEP_DEG).round() * ENCODER_STEP_DEG,
                command: 2047.0 + 800.0 * current,
                current_a: -current + current_noise.sample(&mut rng),
                commanded_psi: self.pressure_psi,
                measured_psi: sensed.map(|p| p + pressure_noise.sample(&mut rng)),
                sync: t >= 0.0,
            });
        }
        let note = format!("made by the demo, seed {}", self.seed);
        to_text(&note, RATE_HZ, 0, &rows)
    }

    /// One semi-implicit step (N, mm, s); friction holds the joint still below its threshold.
    fn step(&self, x: f64, v: f64, force_n: f64, dt: f64) -> (f64, f64) {
        let spring = self.stiffness_n_mm * x * (1.0 + self.hardening * x * x);
        // 1 N on 1 kg is 1000 mm/s².
        let gain = 1000.0 * dt / self.mass_kg;
        let free = v + gain * (force_n - spring - self.damping_ns_mm * v);
        let v = free.signum() * (free.abs() - gain * self.friction_n).max(0.0);
        (x + dt * v, v)
    }

    fn pressures_psi(&self, x: f64) -> [f64; 2] {
        let volume = |s: f64| {
            let radius = 5.0 * (1.0 + self.deformation * s / 200.0);
            PI * radius * radius * (200.0 - s)
        };
        let sealed = |psi: f64, s: f64| {
            let absolute = psi * KPA_PER_PSI + ATMOSPHERE_KPA;
            (absolute * volume(0.0) / volume(s) - ATMOSPHERE_KPA) / KPA_PER_PSI
        };
        [sealed(self.pressure_psi[0], x), sealed(self.pressure_psi[1], -x)]
    }
}

/// Motor current along +x, A: 1 A in the first half of each frequency, 1.5 A in the second.
fn excitation_a(t: f64) -> f64 {
    let mut start = 0.0;
    for (frequency, length) in PROTOCOL {
        if (start..start + length).contains(&t) {
            let amplitude = if t - start < 0.5 * length { 1.0 } else { 1.5 };
            return amplitude * (TAU * frequency * (t - start)).sin();
        }
        start += length;
    }
    0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_holds_below_its_threshold_and_not_above() {
        let plant = Plant::seeded(3);
        let (mut x, mut v) = (0.0, 0.0);
        for _ in 0..1000 {
            (x, v) = plant.step(x, v, 0.99 * plant.friction_n, 1e-4);
        }
        assert_eq!((x, v), (0.0, 0.0));
        for _ in 0..1000 {
            (x, v) = plant.step(x, v, 1.2 * plant.friction_n, 1e-4);
        }
        assert!(x > 0.0 && v >= 0.0);
    }

    #[test]
    fn the_same_seed_gives_the_same_log() {
        assert_eq!(Plant::seeded(7).record(), Plant::seeded(7).record());
        assert_ne!(Plant::seeded(7).record(), Plant::seeded(8).record());
    }
}
