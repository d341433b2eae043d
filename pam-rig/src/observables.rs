//! The published numbers of the joint, measured on the rig.
//!
//! The parameters that no datasheet gives (diameter of the braid, dead volume, wall, losses, gearbox
//! friction) are calibrated to these numbers; `docs/rig.md` holds the table, `pam rig observables`
//! computes it.

use crate::error::RigError;
use crate::plant::{Plant, PlantParameters};
use crate::protocol::{Protocol, Run};
use crate::record::record;
use crate::rig::RigParameters;
use crate::sensors::SensorParameters;
use pam_core::units::{ATMOSPHERE_KPA, KPA_PER_PSI};
use serde::Serialize;
use std::f64::consts::TAU;

/// A number that is published and measured.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Observable {
    /// Description, with conditions.
    pub what: String,
    /// Its unit.
    pub unit: &'static str,
    /// Published value.
    pub published: f64,
    /// Source.
    pub source: &'static str,
    /// Value of the rig.
    pub rig: f64,
}

/// Source: the published network's force at the masses of the gas law, and its free simulation.
const NETWORK: &str = "published weights";
const PAPER: &str = "Wang and Realmuto 2026";

fn kpa(psi: f64) -> f64 {
    psi * KPA_PER_PSI + ATMOSPHERE_KPA
}

/// A sealed joint at rest at x = 0.
fn sealed(p: &PlantParameters, psi: [f64; 2]) -> Plant {
    let mut plant = Plant::new(p, Default::default(), &[]);
    plant.fill(psi.map(kpa));
    plant
}

/// Force with which a sealed joint must be dragged along `x = amplitude sin(ω t)`, over the third
/// cycle: pairs of displacement (mm) and force (N), gearbox friction included. The first half of the
/// returned cycle moves up, from the lowest point.
fn dragged_loop(
    p: &PlantParameters,
    psi: [f64; 2],
    amplitude_mm: f64,
    frequency_hz: f64,
) -> Vec<[f64; 2]> {
    const STEPS: usize = 20_000;
    let mut plant = sealed(p, psi);
    let step_s = 1.0 / (frequency_hz * STEPS as f64);
    let mut out = Vec::with_capacity(STEPS);
    for k in 0..=(3 * STEPS + STEPS * 3 / 4) {
        let (sine, cosine) = (TAU * k as f64 / STEPS as f64).sin_cos();
        let v = TAU * frequency_hz * amplitude_mm * cosine;
        let force = plant.drag(amplitude_mm * sine, v, step_s);
        if k >= 2 * STEPS + STEPS * 3 / 4 && out.len() < STEPS {
            out.push([amplitude_mm * sine, force + plant.friction_limit_n(v).copysign(v)]);
        }
    }
    out
}

/// Forces of a loop on its way up and down at a displacement, N.
fn branches_n(cycle: &[[f64; 2]], displacement_mm: f64) -> [f64; 2] {
    let (up, down) = cycle.split_at(cycle.len() / 2);
    [up, down].map(|branch| {
        let near = |a: &&[f64; 2], b: &&[f64; 2]| {
            (a[0] - displacement_mm).abs().total_cmp(&(b[0] - displacement_mm).abs())
        };
        branch.iter().min_by(near).map_or(f64::NAN, |point| point[1])
    })
}

/// Stiffness at x = 0, N/mm: the four-point slope with h = 1 mm (source, section II-E) on the middle
/// of the loop of a 1 Hz motion, as the published network was trained on motions of 0.5 to 2 Hz.
#[must_use]
pub fn stiffness_n_mm(p: &PlantParameters, psi: [f64; 2]) -> f64 {
    let cycle = dragged_loop(p, psi, 2.5, 1.0);
    let middle = |x: f64| branches_n(&cycle, x).iter().sum::<f64>() / 2.0;
    (middle(2.0) + middle(1.0) - middle(-1.0) - middle(-2.0)) / 6.0
}

/// Equivalent damping at x = 0 and ±5 mm/s, kg/s: the loop's half width there over 5 mm/s.
#[must_use]
pub fn damping_kg_s(p: &PlantParameters, psi: [f64; 2]) -> f64 {
    let cycle = dragged_loop(p, psi, 5.0 / TAU, 1.0);
    let [up, down] = branches_n(&cycle, 0.0);
    1e3 * (up - down) / 10.0
}

/// Rest position without friction of a joint sealed at x = 0, mm.
#[must_use]
pub fn equilibrium_mm(p: &PlantParameters, psi: [f64; 2]) -> f64 {
    let plant = sealed(p, psi);
    let masses = [0, 1].map(|i| plant.muscles()[i].air.mass_g);
    let (mut low, mut high) = (-12.0, 12.0);
    while high - low > 1e-9 {
        let middle = 0.5 * (low + high);
        if plant.elastic_restoring_force_n(middle, masses) > 0.0 {
            high = middle;
        } else {
            low = middle;
        }
    }
    0.5 * (low + high)
}

/// Largest displacement from rest in the published excitation at 1.5 A (200 N), mm, for 0.5 and 2 Hz.
///
/// # Errors
/// [`RigError::Parameter`] if the parameters are impossible.
pub fn excursions_mm(p: &PlantParameters, psi: [u8; 2]) -> Result<[f64; 2], RigError> {
    let made = excited(p, psi)?;
    let x: Vec<f64> = made.iter().map(|s| s[0]).collect();
    let half_range = |from: usize, to: usize| {
        let part = || x[from..to].iter().copied();
        0.5 * (part().fold(f64::MIN, f64::max) - part().fold(f64::MAX, f64::min))
    };
    Ok([half_range(30_000, 40_000), half_range(67_000, 70_000)])
}

/// Delays (ms) at 0.5, 1 and 2 Hz of the measured flexor pressure behind the isothermal pressure of the
/// measured displacement: the shift of the largest correlation, as in the source.
///
/// # Errors
/// [`RigError::Parameter`] if the parameters are impossible.
pub fn pressure_delays_ms(p: &PlantParameters, psi: [u8; 2]) -> Result<[f64; 3], RigError> {
    let made = excited(p, psi)?;
    Ok([(20_000, 40_000), (50_000, 60_000), (65_000, 70_000)].map(|(from, to)| {
        let delayed = |delay: usize| {
            let pairs = (from + 200..to).map(|i| (-made[i - delay][0], made[i][1]));
            let n = (to - from - 200) as f64;
            let (a, b) = pairs.clone().fold((0.0, 0.0), |s, v| (s.0 + v.0 / n, s.1 + v.1 / n));
            let (ab, aa) = pairs.fold((0.0, 0.0), |s, v| {
                (s.0 + (v.0 - a) * (v.1 - b), s.1 + (v.0 - a) * (v.0 - a))
            });
            ab / aa.sqrt()
        };
        let best = (0..150).max_by(|&a, &b| delayed(a).total_cmp(&delayed(b)));
        best.unwrap_or(0) as f64
    }))
}

/// Displacement and measured flexor pressure (psi) under the published excitation, from time zero on,
/// without noise and steps.
fn excited(p: &PlantParameters, psi: [u8; 2]) -> Result<Vec<[f64; 2]>, RigError> {
    let mut sensors = SensorParameters::ideal();
    sensors.pressure.cutoff_hz = SensorParameters::default().pressure.cutoff_hz;
    let rig = RigParameters { plant: p.clone(), sensors, ..RigParameters::default() };
    let protocol = Protocol::paper();
    let run = Run { name: "observables".into(), start_psi: psi.map(f64::from) };
    let made = record(&rig, &protocol, &run, 1)?;
    let start = made.rows.len() - 70_000;
    let samples = made.rows.iter().zip(&made.truth.rows).skip(start);
    Ok(samples.map(|(row, truth)| [truth.displacement_mm, row.measured_psi[0]]).collect())
}

/// Deformation coefficient nu that an isothermal cylinder of the datasheet would need to show the
/// chamber's relative change of volume at x = 0.
#[must_use]
pub fn equivalent_deformation(p: &PlantParameters) -> f64 {
    let plant = sealed(p, [45.0, 45.0]);
    let volume = |x: f64| plant.muscles()[0].gas_volume_mm3(x);
    let slope = (volume(0.5) / volume(-0.5)).ln();
    0.5 * (1.0 + p.flexor.braid.length_mm * slope)
}

/// All observables of a joint.
///
/// # Errors
/// [`RigError::Parameter`] if the parameters are impossible.
pub fn observables(p: &PlantParameters) -> Result<Vec<Observable>, RigError> {
    let mut all = Vec::new();
    let mut push = |what: String, unit, published, source, rig| {
        all.push(Observable { what, unit, published, source, rig });
    };
    let even = |psi: f64| [psi, psi];
    for (psi, published) in
        [(10.0, 127.3), (25.0, 144.9), (45.0, 161.2), (60.0, 169.4), (80.0, 175.3)]
    {
        let what = format!("stiffness at x = 0, {:.0} kPa in both muscles, h = 1 mm", kpa(psi));
        push(what, "N/mm", published, NETWORK, stiffness_n_mm(p, even(psi)));
    }
    for (psi, published) in [(10.0, 6051.0), (45.0, 6628.0), (80.0, 7550.0)] {
        let what = format!("equivalent damping at ±5 mm/s, {:.0} kPa", kpa(psi));
        push(what, "kg/s", published, NETWORK, damping_kg_s(p, even(psi)));
    }
    let [slow, fast] = excursions_mm(p, [45, 45])?;
    push("displacement at 200 N, 0.5 Hz, 412 kPa (±)".into(), "mm", 1.13, NETWORK, slow);
    push("displacement at 200 N, 2 Hz, 412 kPa (±)".into(), "mm", 2.17, NETWORK, fast);
    for (psi, published) in
        [([60.0, 30.0], 1.08), ([30.0, 60.0], -1.21), ([45.0, 10.0], 1.29), ([80.0, 10.0], 2.54)]
    {
        let what = format!("rest position at {:.0}/{:.0} kPa", kpa(psi[0]), kpa(psi[1]));
        push(what, "mm", published, NETWORK, equilibrium_mm(p, psi));
    }
    let delays = pressure_delays_ms(p, [30, 60])?;
    for ((frequency, published), rig) in
        [("0.5", 31.0), ("1", 40.0), ("2", 41.0)].into_iter().zip(delays)
    {
        let what = format!("delay of the measured pressure at {frequency} Hz, 308/515 kPa");
        push(what, "ms", published, PAPER, rig);
    }
    push(
        "deformation coefficient nu of an isothermal model".into(),
        "1",
        3.69,
        PAPER,
        equivalent_deformation(p),
    );
    Ok(all)
}
