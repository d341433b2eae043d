//! Segments of driven pressures.

use super::table::Table;
use pam_core::units::{ATMOSPHERE_KPA, KPA_PER_PSI};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// A segment of driven pressures. Pressures are absolute, flexor and extensor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum PressureSegment {
    /// All valves shut.
    Sealed {
        /// Length, s.
        duration_s: f64,
    },
    /// The servo holds both pressures.
    Hold {
        /// Pressures, kPa absolute.
        pressure_kpa: [f64; 2],
        /// Length, s.
        duration_s: f64,
    },
    /// `mean + amplitude sin(2π f t + phase)`.
    Sine {
        /// Means, kPa absolute.
        mean_kpa: [f64; 2],
        /// Amplitudes, kPa; of opposite signs they move the joint.
        amplitude_kpa: [f64; 2],
        /// Frequency, Hz.
        frequency_hz: f64,
        /// Phase at the start, deg.
        #[serde(default)]
        phase_deg: f64,
        /// Length, s.
        duration_s: f64,
    },
    /// A file with the columns `time_s, pressure_flexor_kpa, pressure_extensor_kpa`, held between its
    /// rows.
    Table(Table<2>),
}

impl PressureSegment {
    /// Length, s.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        match self {
            Self::Sealed { duration_s }
            | Self::Hold { duration_s, .. }
            | Self::Sine { duration_s, .. } => *duration_s,
            Self::Table(table) => table.duration_s(),
        }
    }

    /// Targets at a time within the segment, psi gauge; `None` where the muscles are sealed.
    #[must_use]
    pub fn targets_psi(&self, t: f64) -> Option<[f64; 2]> {
        let kpa = match self {
            Self::Sealed { .. } => return None,
            Self::Hold { pressure_kpa, .. } => *pressure_kpa,
            Self::Sine { mean_kpa, amplitude_kpa, frequency_hz, phase_deg, .. } => {
                let wave = (TAU * frequency_hz * t + phase_deg.to_radians()).sin();
                [0, 1].map(|i| mean_kpa[i] + amplitude_kpa[i] * wave)
            }
            Self::Table(table) => table.at(t),
        };
        Some(kpa.map(|p| (p - ATMOSPHERE_KPA) / KPA_PER_PSI))
    }

    /// Pressures at the start of the segment, psi gauge; room pressure for a sealed one.
    #[must_use]
    pub fn start_psi(&self) -> [f64; 2] {
        self.targets_psi(0.0).unwrap_or([0.0; 2])
    }

    /// The first invalid field, with a message.
    pub(super) fn fault(&self) -> Option<(&'static str, String)> {
        let duration = self.duration_s();
        if !(duration.is_finite() && duration > 0.0) {
            return Some(("duration_s", format!("{duration} must be a positive number")));
        }
        let extremes: (&'static str, Vec<f64>) = match self {
            Self::Sealed { .. } => return None,
            Self::Hold { pressure_kpa, .. } => ("pressure_kpa", pressure_kpa.to_vec()),
            Self::Sine { mean_kpa, amplitude_kpa, frequency_hz, phase_deg, .. } => {
                if !(frequency_hz.is_finite() && *frequency_hz > 0.0) {
                    let why = format!("{frequency_hz} must be a positive number");
                    return Some(("frequency_hz", why));
                }
                if !phase_deg.is_finite() {
                    return Some(("phase_deg", format!("{phase_deg} must be finite")));
                }
                let ends = [0, 1]
                    .into_iter()
                    .flat_map(|i| [mean_kpa[i] - amplitude_kpa[i], mean_kpa[i] + amplitude_kpa[i]]);
                ("amplitude_kpa", ends.collect())
            }
            Self::Table(table) => {
                ("file", table.smallest().into_iter().chain(table.largest()).flatten().collect())
            }
        };
        let (field, values) = extremes;
        let outside = values.into_iter().find(|p| !(ATMOSPHERE_KPA..=LARGEST_KPA).contains(p))?;
        Some((
            field,
            format!(
                "{outside:.1} kPa is asked for; absolute pressures lie between {ATMOSPHERE_KPA} kPa \
                 (room) and {LARGEST_KPA} kPa (supply)"
            ),
        ))
    }
}

/// Largest pressure of the supply, kPa absolute.
const LARGEST_KPA: f64 = 720.0;
