//! What the tests of the rig share: rigs without history, excitations, and what is read off them.

#![allow(dead_code, reason = "each test takes what it needs")]

use pam_rig::plant::{DryFriction, HeatExchange, LossParameters, PlantParameters};
use pam_rig::sensors::SensorParameters;
use pam_rig::{Command, Frame, PressureCommand, Rig, RigParameters};
use std::f64::consts::TAU;

/// Time between samples of an ideal clock, s.
pub(crate) const SAMPLE_S: f64 = 1e-3;
/// Reflected mass of the default joint, kg.
pub(crate) const MASS_KG: f64 = 315.0;
/// Force of 1 A at the tendon, N: 25.5 mN·m/A through a gear of 36 on a pulley of 6.875 mm.
pub(crate) const NEWTON_PER_AMPERE: f64 = 25.5 * 36.0 / 6.875;
/// Radius of the pulley, mm.
pub(crate) const PULLEY_MM: f64 = 6.875;

/// Absolute pressure of a gauge pressure in psi.
pub(crate) fn kpa(psi: f64) -> f64 {
    psi * 6.89476 + 101.325
}

/// The default rig with ideal sensors and some effects.
pub(crate) fn ideal(effects: &[&str]) -> RigParameters {
    RigParameters {
        sensors: SensorParameters::ideal(),
        effects: effects.iter().map(|e| e.parse().unwrap()).collect(),
        ..RigParameters::default()
    }
}

/// A joint that is only springs and a mass: no dry friction, no losses in the muscles, isothermal air.
pub(crate) fn springs() -> PlantParameters {
    let mut plant = PlantParameters {
        friction: no_friction(),
        heat: HeatExchange::Isothermal,
        ..PlantParameters::default()
    };
    plant.flexor.losses = no_losses();
    plant.extensor.losses = no_losses();
    plant
}

pub(crate) fn no_friction() -> DryFriction {
    DryFriction { coulomb_n: 0.0, static_n: 0.0, ..DryFriction::default() }
}

pub(crate) fn no_losses() -> LossParameters {
    LossParameters {
        dry_n: 0.0,
        dry_n_per_kpa: 0.0,
        viscous_ns_m: 0.0,
        viscous_ns_m_per_kpa: 0.0,
        ..LossParameters::default()
    }
}

/// [`ideal`] with the joint of [`springs`].
pub(crate) fn plain(effects: &[&str]) -> RigParameters {
    RigParameters { plant: springs(), ..ideal(effects) }
}

/// Samples of a sealed joint, filled at x = 0 and t = 0, under a current over time.
pub(crate) fn sealed(
    parameters: &RigParameters,
    psi: [f64; 2],
    duration_s: f64,
    current_a: impl Fn(f64) -> f64,
) -> Vec<Frame> {
    let mut rig = Rig::new(parameters, 1, 0.0).unwrap();
    rig.fill(psi.map(kpa));
    let samples = (duration_s / SAMPLE_S).round() as usize;
    (0..samples)
        .map(|k| {
            let current_a = current_a(k as f64 * SAMPLE_S);
            rig.tick(&Command { current_a, pressure: PressureCommand::Sealed })
        })
        .collect()
}

/// A sine current.
pub(crate) fn sine(amplitude_a: f64, frequency_hz: f64) -> impl Fn(f64) -> f64 {
    move |t| amplitude_a * (TAU * frequency_hz * t).sin()
}

/// Displacement that a log says, mm.
pub(crate) fn logged_mm(frame: &Frame) -> f64 {
    -frame.row.angle_deg.to_radians() * PULLEY_MM
}

/// Absolute pressures that a log says, kPa.
pub(crate) fn logged_kpa(frame: &Frame) -> [f64; 2] {
    frame.row.measured_psi.map(kpa)
}

/// The force that acts beside the motor, the tendons and the dry friction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Unknown {
    pub(crate) time_s: f64,
    pub(crate) displacement_mm: f64,
    pub(crate) velocity_mm_s: f64,
    /// Sum of the tendons along +x, N.
    pub(crate) muscles_n: f64,
    /// Along +x, N.
    pub(crate) force_n: f64,
}

/// Newton's second law solved for what is not in the truth, at every sample but the ends.
pub(crate) fn unknown_force(frames: &[Frame], mass_kg: f64) -> Vec<Unknown> {
    let at = |k: usize| &frames[k].truth;
    (1..frames.len() - 1)
        .map(|k| {
            let [flexor, extensor] = at(k).tensions_n;
            let acceleration = (at(k + 1).velocity_mm_s - at(k - 1).velocity_mm_s) / 2e-3;
            // Forces of the motor and of friction are means from their sample to the next.
            let known = 0.5 * (at(k).force_n + at(k - 1).force_n)
                + 0.5 * (at(k).friction_n + at(k - 1).friction_n)
                + (flexor - extensor);
            Unknown {
                time_s: k as f64 * SAMPLE_S,
                displacement_mm: at(k).displacement_mm,
                velocity_mm_s: at(k).velocity_mm_s,
                muscles_n: flexor - extensor,
                force_n: 1e-3 * mass_kg * acceleration - known,
            }
        })
        .collect()
}

/// Amplitude and phase (rad, of the sine) at a frequency, over whole cycles of samples.
pub(crate) fn phasor(values: impl Iterator<Item = f64>, frequency_hz: f64) -> (f64, f64) {
    let values: Vec<f64> = values.collect();
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let (mut sine, mut cosine) = (0.0, 0.0);
    for (k, value) in values.iter().enumerate() {
        let phase = TAU * frequency_hz * k as f64 * SAMPLE_S;
        sine += (value - mean) * phase.sin();
        cosine += (value - mean) * phase.cos();
    }
    (2.0 / n * sine.hypot(cosine), cosine.atan2(sine))
}

/// By how much the second series runs behind the first at a frequency, ms.
pub(crate) fn delay_ms(
    first: impl Iterator<Item = f64>,
    second: impl Iterator<Item = f64>,
    frequency_hz: f64,
) -> f64 {
    let turn = phasor(first, frequency_hz).1 - phasor(second, frequency_hz).1;
    // Between −π and π.
    1e3 * turn.sin().atan2(turn.cos()) / (TAU * frequency_hz)
}

/// Slope and intercept of a straight line through points.
pub(crate) fn line(points: &[(f64, f64)]) -> (f64, f64) {
    let n = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |s, p| (s.0 + p.0 / n, s.1 + p.1 / n));
    let (xy, xx) = points
        .iter()
        .fold((0.0, 0.0), |s, p| (s.0 + (p.0 - x) * (p.1 - y), s.1 + (p.0 - x) * (p.0 - x)));
    (xy / xx, y - x * xy / xx)
}

/// Largest of some numbers.
pub(crate) fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::MIN, f64::max)
}
