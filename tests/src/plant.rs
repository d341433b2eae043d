//! A plant made of a hybrid model, with an effect that is hidden in what its sensors write.
//!
//! It knows nothing of the diagnosis: equations are written out here once more, marched by x, with the network itself and exact sticking.

use pam_core::units::ATMOSPHERE_KPA;
use pam_core::{AnyForce, ForceInput, ForceModel, JointModel, SealedMasses};
use pam_data::preprocess::refilter;
use pam_data::recording::{Recording, SealedReading};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::path::Path;

const SUBSTEPS: usize = 5;
const RATE_HZ: f64 = 1000.0;
/// Encoder step, mm.
const ENCODER_MM: f64 = 0.010_546;

/// A hidden effect: id and parameters by the names of `effects.md`. Also ids that are not on the list:
/// `periodic_disturbance`, `chamber_crosstalk`, `tendon_slip` (the encoder's zero jumps), `sensor_gain_jump` (of
/// the flexor's), `encoder_freeze`, `valve_glitch`; and `smooth_command`, a motor that follows the command between
/// samples, where it else holds.
pub type Hidden = (String, BTreeMap<String, f64>);

/// An effect from its id and parameters.
#[must_use]
pub fn hidden(id: &str, parameters: &[(&str, f64)]) -> Hidden {
    (id.to_owned(), parameters.iter().map(|(k, v)| ((*k).to_owned(), *v)).collect())
}

/// What the motor does: frequency (Hz), amplitude (N), duration (s), one after another.
pub type Excitation = Vec<(f64, f64, f64)>;

/// The published excitation with its times multiplied.
#[must_use]
pub fn excitation(share: f64) -> Excitation {
    [(0.5, 20.0), (1.0, 10.0), (2.0, 5.0)]
        .iter()
        .flat_map(|&(f, t)| [133.5, 200.3].map(|a| (f, a, t * share)))
        .collect()
}

/// Noise of the sensors (standard deviations).
#[derive(Debug, Clone, Copy)]
pub struct Noise {
    /// Displacement, mm, before the encoder's steps.
    pub displacement_mm: f64,
    /// Pressure, kPa.
    pub pressure_kpa: f64,
    /// Recorded force, N.
    pub force_n: f64,
}

impl Default for Noise {
    fn default() -> Self {
        Self { displacement_mm: 0.002, pressure_kpa: 0.4, force_n: 0.5 }
    }
}

struct Effects<'a>(&'a [Hidden]);

impl Effects<'_> {
    fn get(&self, id: &str, name: &str) -> Option<f64> {
        let found = self.0.iter().find(|h| h.0 == id)?;
        Some(found.1.get(name).copied().unwrap_or(0.0))
    }
    fn or(&self, id: &str, name: &str, otherwise: f64) -> f64 {
        self.get(id, name).unwrap_or(otherwise)
    }
}

/// Records a run at gauge pressures (psi) with effects hidden in it.
///
/// # Panics
/// If the recording cannot be filtered.
#[must_use]
pub fn record(
    model: &JointModel<f64, AnyForce<f64>>,
    name: &str,
    psi: [f64; 2],
    excitation: &Excitation,
    effects: &[Hidden],
    noise: Noise,
    seed: u64,
) -> Recording {
    let e = Effects(effects);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = move || {
        let (a, b): (f64, f64) = (random.random_range(1e-12..1.0), random.random());
        (-2.0 * a.ln()).sqrt() * (TAU * b).cos()
    };
    let p = model.physical();
    let nu = p.deformation * (1.0 + e.or("geometry_coefficient", "relative", 0.0));
    let exponent = e.or("polytropic_gas", "exponent", 1.0);
    let slack = e.get("tendon_slack", "displacement_mm");
    let volume = |x: f64, flexor: bool, nu: f64| {
        let x = match slack {
            Some(d) if flexor => x.min(d),
            Some(d) => x.max(-d),
            None => x,
        };
        let (l, s) = if flexor { (200.0 - x, 1.0) } else { (200.0 + x, -1.0) };
        let r = 5.0 * (1.0 + s * nu * x / 200.0);
        PI * r * r * l
    };
    let kpa = psi.map(|p| p * 6.894_76 + ATMOSPHERE_KPA);
    let c = p.gas_coefficient;
    let mut masses = [kpa[0] * volume(0.0, true, nu) / c, kpa[1] * volume(0.0, false, nu) / c];
    let mut work = vec![0.0; model.force.work_len()];
    let mut force_at = |x: f64, v: f64, m: [f64; 2]| {
        let input = ForceInput {
            displacement_mm: x,
            velocity_mm_s: v,
            mass_flexor_g: m[0],
            mass_extensor_g: m[1],
        };
        model.force.restoring_force_mn(&input, &mut work)
    };
    // Rest: where the restoring force and a steady load balance.
    let load = e.or("constant_load", "force_n", 0.0) * 1e3;
    let (mut low, mut high) = (-8.0, 8.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if force_at(middle, 0.0, masses) > load { high = middle } else { low = middle }
    }
    let rest = 0.5 * (low + high);
    masses = [kpa[0] * volume(rest, true, nu) / c, kpa[1] * volume(rest, false, nu) / c];
    let sealed_volume = [volume(rest, true, nu), volume(rest, false, nu)];

    let length: f64 = excitation.iter().map(|s| s.2).sum();
    let samples = (length * RATE_HZ) as usize;
    let commanded = |t: f64| {
        let mut from = 0.0;
        for &(f, a, d) in excitation {
            if t < from + d {
                return 1e3 * a * (TAU * f * (t - from)).sin();
            }
            from += d;
        }
        0.0
    };
    let mass = p.mass_kg + e.or("added_inertia", "mass_kg", 0.0);
    let dt = 1.0 / (RATE_HZ * SUBSTEPS as f64);
    let (mut x, mut v) = (rest, 0.0_f64);
    let (mut damper, mut loop_z) = (rest, 0.0_f64);
    let mut shown = rest;
    let mut lag = kpa;
    let mut frozen = rest;
    let mut glitched = false;
    let mut recording = Recording::empty(Path::new(name));
    let mut history: Vec<[f64; 2]> = Vec::new();
    let bias = ["flexor_kpa", "extensor_kpa"].map(|n| e.or("pressure_bias", n, 0.0));
    let gain = ["flexor_relative", "extensor_relative"].map(|n| e.or("pressure_gain", n, 0.0));
    let offset = e.or("position_offset", "offset_mm", 0.0);
    let mut sealed = [0.0; 3];
    // A hundred samples at rest, then the excitation.
    for k in -100..samples as i64 {
        let t = k as f64 / RATE_HZ;
        let pressures = [0, 1].map(|i| {
            let v = volume(x, i == 0, nu);
            c * masses[i] / sealed_volume[i] * (sealed_volume[i] / v).powf(exponent)
        });
        // Sensors.
        let half = 0.5 * e.or("backlash", "gap_mm", 0.0);
        shown = shown.clamp(x - half, x + half);
        let mut seen_x = shown * (1.0 + e.or("position_gain", "relative", 0.0)) + offset;
        if e.get("tendon_slip", "time_s").is_some_and(|at| t > at) {
            seen_x += e.or("tendon_slip", "slip_mm", 0.0);
        }
        if let Some(period) = e.get("encoder_freeze", "period_s") {
            if t > period && t % period < e.or("encoder_freeze", "duration_s", 0.0) {
                seen_x = frozen;
            }
            frozen = seen_x;
        }
        if e.get("valve_glitch", "time_s").is_some_and(|at| t > at) && !glitched {
            masses[0] += 1e-3 * e.or("valve_glitch", "mass_mg", 0.0);
            glitched = true;
        }
        let mut seen_p = pressures;
        if let Some(cutoff) = e.get("pressure_sensor_lag", "cutoff_hz") {
            let share = 1.0 - (-TAU * cutoff / RATE_HZ).exp();
            for i in 0..2 {
                lag[i] += share * (seen_p[i] - lag[i]);
            }
            seen_p = lag;
        }
        history.push(seen_p);
        if let Some(ms) = e.get("pressure_delay", "delay_ms") {
            let back = (ms.round() as usize).min(history.len() - 1);
            seen_p = history[history.len() - 1 - back];
        }
        for i in 0..2 {
            let mut relative = gain[i];
            if i == 0 && e.get("sensor_gain_jump", "time_s").is_some_and(|at| t > at) {
                relative += e.or("sensor_gain_jump", "relative", 0.0);
            }
            seen_p[i] += relative * (seen_p[i] - ATMOSPHERE_KPA) + bias[i];
            seen_p[i] += noise.pressure_kpa * normal();
        }
        seen_x += noise.displacement_mm * normal();
        seen_x = (seen_x / ENCODER_MM).round() * ENCODER_MM;
        if k < 0 {
            sealed[0] += seen_x / 100.0;
            sealed[1] += seen_p[0] / 100.0;
            sealed[2] += seen_p[1] / 100.0;
            continue;
        }
        recording.time_s.push(t);
        recording.displacement_mm.push(seen_x);
        recording.pressure_flexor_kpa.push(seen_p[0]);
        recording.pressure_extensor_kpa.push(seen_p[1]);
        recording.force_mn.push(commanded(t) + 1e3 * noise.force_n * normal());
        let smooth = e.0.iter().any(|h| h.0 == "smooth_command");
        let limit = 1e3 * e.or("force_saturation", "force_n", 1e9);
        for substep in 0..SUBSTEPS {
            // The command is held for a sample, or the motor is at the middle of the substep with it.
            let at = if smooth { t + (substep as f64 + 0.5) * dt } else { t };
            let delayed = at - 1e-3 * e.or("actuation_delay", "delay_ms", 0.0);
            let mut drive = if delayed < 0.0 { 0.0 } else { commanded(delayed) };
            drive *= 1.0 + e.or("force_gain", "relative", 0.0);
            drive = drive.clamp(-limit, limit);
            if let Some(n) = e.get("periodic_disturbance", "force_n") {
                let frequency = e.or("periodic_disturbance", "frequency_hz", 1.3);
                drive += 1e3 * n * (TAU * frequency * t).sin();
            }
            x += 0.5 * dt * v;
            let f = force_at(x, v, masses);
            let mut restoring = f
                * (1.0 + e.or("stiffness_scale", "relative", 0.0))
                * (1.0 + e.or("stiffness_drift", "relative_per_min", 0.0) * t / 60.0);
            if let Some(d) = slack
                && x.abs() > d
            {
                let edge = d.copysign(x);
                let loss = e.or("tendon_slack", "stiffness_loss", 0.0);
                restoring -= loss * (force_at(x, 0.0, masses) - force_at(edge, 0.0, masses));
            }
            let mut total = drive + load - restoring;
            total -= e.or("viscous_damping", "coefficient_ns_m", 0.0) * v;
            if let Some(n) = e.get("cogging", "force_n") {
                total -= 1e3 * n * (TAU * x / e.or("cogging", "pitch_mm", 1.0)).sin();
            }
            if let Some(n) = e.get("hysteresis", "force_n") {
                // Bouc–Wen with exponent two; saturates after about the slip distance.
                let slip = e.or("hysteresis", "slip_mm", 1.0);
                let pull = if v * loop_z > 0.0 { loop_z * loop_z } else { 0.0 };
                loop_z += dt * v / slip * (1.0 - pull);
                total -= 1e3 * n * loop_z;
            }
            if let Some(s) = e.get("creep", "stiffness_n_mm") {
                damper += dt / e.or("creep", "time_constant_s", 1.0) * (x - damper);
                total -= 1e3 * s * (x - damper);
            }
            // Dry friction, implicit: exact sticking.
            let mut dry = 1e3 * e.or("coulomb_friction", "force_n", 0.0);
            if let Some(slow) = e.get("stribeck_friction", "static_n") {
                let fast = e.or("stribeck_friction", "coulomb_n", 0.0);
                let ratio = v / e.or("stribeck_friction", "velocity_mm_s", 1.0);
                dry += 1e3 * (fast + (slow - fast) * (-ratio * ratio).exp());
            }
            let free = v + dt * total / mass;
            let hold = dt * dry / mass;
            v = if free.abs() <= hold { 0.0 } else { free - hold.copysign(free) };
            x += 0.5 * dt * v;
            for i in 0..2 {
                let rate = e.or("leak", ["flexor_rate_per_s", "extensor_rate_per_s"][i], 0.0);
                masses[i] -= dt * rate * masses[i] * (1.0 - ATMOSPHERE_KPA / pressures[i]);
            }
            if let Some(rate) = e.get("chamber_crosstalk", "rate_per_s") {
                let flow = dt * rate * masses[0] * (pressures[0] - pressures[1]) / pressures[0];
                masses[0] -= flow;
                masses[1] += flow;
            }
        }
    }
    recording.velocity_mm_s = vec![0.0; recording.time_s.len()];
    recording.sealed = Some(SealedReading {
        displacement_mm: sealed[0],
        pressure_flexor_kpa: sealed[1],
        pressure_extensor_kpa: sealed[2],
    });
    refilter(recording, 20.0).expect("long enough to filter")
}

/// The masses by the model's gas law at the sealed reading.
#[must_use]
pub fn masses(model: &JointModel<f64, AnyForce<f64>>, recording: &Recording) -> SealedMasses {
    let rest = recording.reading_at_rest();
    model.gas_law_masses(
        rest.displacement_mm,
        [rest.pressure_flexor_kpa, rest.pressure_extensor_kpa],
    )
}
