//! Data of a single muscle.

use pam_core::units::{ATMOSPHERE_KPA, KPA_PER_PSI};
use pam_data::{DataError, MuscleSurfaces};
use pam_rig::plant::{HeatExchange, Muscle, MuscleParameters, VolumeLaw};
use std::f64::consts::TAU;
use std::path::Path;

/// A measured tension.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MuscleSample {
    /// Gauge pressure, kPa.
    pub gauge_kpa: f64,
    /// Contraction over L0.
    pub contraction: f64,
    /// Its rate, 1/s; zero for quasi-static data.
    pub rate_per_s: f64,
    /// Sign of the rate; also known of quasi-static data with a loading and an unloading branch.
    pub direction: f64,
    /// Tension, N.
    pub force_n: f64,
}

/// Gauge pressures of the published experiments, psi.
const PSI: [f64; 2] = [10.0, 80.0];

/// The measured surfaces of a single muscle, on a grid of air mass (0 to 0.2 g) and stretch
/// (± `reach_mm`): where the muscle pulls, at the pressures of the published experiments. Beyond them the
/// surfaces are extrapolations of their polynomials.
#[must_use]
pub fn of_surfaces(surfaces: &MuscleSurfaces, reach_mm: f64, length_mm: f64) -> Vec<MuscleSample> {
    let (low, high) = (PSI[0] * KPA_PER_PSI, PSI[1] * KPA_PER_PSI);
    let mut samples = Vec::new();
    for loading in [true, false] {
        for i in 0..=80 {
            for j in 0..=40 {
                let mass_g = 0.2 * f64::from(i) / 80.0;
                let stretch_mm = reach_mm * (f64::from(j) / 20.0 - 1.0);
                let (pressure, force_n) = surfaces.pressure_and_force(loading, mass_g, stretch_mm);
                let gauge_kpa = pressure - ATMOSPHERE_KPA;
                if (low..=high).contains(&gauge_kpa) && force_n >= 0.0 {
                    samples.push(MuscleSample {
                        gauge_kpa,
                        contraction: -stretch_mm / length_mm,
                        rate_per_s: 0.0,
                        // Loading stretches.
                        direction: if loading { -1.0 } else { 1.0 },
                        force_n,
                    });
                }
            }
        }
    }
    samples
}

/// A muscle of the virtual rig, sealed at pressures from 10 to 80 psi and moved sinusoidally by ±
/// `reach_mm` at 0.1, 0.5 and 2 Hz; the second cycle of each. Slack muscles take part with no tension.
#[must_use]
pub fn of_rig(reach_mm: f64, length_mm: f64) -> Vec<MuscleSample> {
    const STEPS: usize = 4000;
    let parameters = MuscleParameters::default();
    let mut samples = Vec::new();
    for psi in (1..=8).map(|k| 10.0 * f64::from(k)) {
        for frequency_hz in [0.1, 0.5, 2.0] {
            let kpa = psi * KPA_PER_PSI + ATMOSPHERE_KPA;
            let law = VolumeLaw::default();
            let mut muscle = Muscle::new(&parameters, law, HeatExchange::default(), kpa);
            let step_s = 1.0 / (frequency_hz * STEPS as f64);
            let omega = TAU * frequency_hz;
            for k in 1..=2 * STEPS {
                let t = k as f64 * step_s;
                let (x, v) = (reach_mm * (omega * t).sin(), reach_mm * omega * (omega * t).cos());
                muscle.follow(x, v, step_s);
                muscle.air.relax(step_s);
                if k > STEPS && k % 20 == 0 {
                    samples.push(MuscleSample {
                        gauge_kpa: muscle.gauge_kpa(),
                        contraction: x / length_mm,
                        rate_per_s: v / length_mm,
                        direction: v.signum(),
                        force_n: muscle.tension_n(v),
                    });
                }
            }
        }
    }
    samples
}

/// An isometric force map: a CSV of gauge pressures (`p_Pa`) and tensions at lengths that the names of the
/// columns give (`F_N_at_L250mm`, …). Zero is slack and takes part.
///
/// # Errors
/// [`DataError`] naming the line.
pub fn of_map(path: impl AsRef<Path>, length_mm: f64) -> Result<Vec<MuscleSample>, DataError> {
    of_map_at(path.as_ref(), length_mm)
}

/// One instance, whatever the path is given as.
fn of_map_at(path: &Path, length_mm: f64) -> Result<Vec<MuscleSample>, DataError> {
    let place = |line: usize, message: String| DataError::line(path, line as u64, message);
    let text = pam_data::read_limit::read_text(path)?;
    let mut lines = text.lines().enumerate();
    let (_, head) = lines.next().ok_or_else(|| place(1, "the file is empty".into()))?;
    let names: Vec<&str> = head.split(',').map(str::trim).collect();
    if names.first() != Some(&"p_Pa") {
        return Err(place(1, "the first column must be `p_Pa`".into()));
    }
    let lengths: Vec<f64> = names[1..]
        .iter()
        .map(|name| {
            let digits = name.strip_prefix("F_N_at_L").and_then(|n| n.strip_suffix("mm"));
            digits.and_then(|n| n.parse().ok()).ok_or_else(|| {
                place(1, format!("column `{name}` is not called like `F_N_at_L250mm`"))
            })
        })
        .collect::<Result<_, _>>()?;
    let mut samples = Vec::new();
    for (k, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
        let values: Vec<f64> = line
            .split(',')
            .map(|cell| {
                let cell = cell.trim();
                let number = cell.parse().ok().filter(|v: &f64| v.is_finite());
                number.ok_or_else(|| place(k + 1, format!("`{cell}` is no finite number")))
            })
            .collect::<Result<_, _>>()?;
        if values.len() != names.len() {
            let (own, all) = (values.len(), names.len());
            return Err(place(k + 1, format!("{own} values for {all} columns")));
        }
        samples.extend(lengths.iter().zip(&values[1..]).map(|(length, force)| MuscleSample {
            gauge_kpa: 1e-3 * values[0],
            contraction: 1.0 - length / length_mm,
            rate_per_s: 0.0,
            direction: 0.0,
            force_n: *force,
        }));
    }
    Ok(samples)
}
