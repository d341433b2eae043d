//! The learned model's commands beside the equilibrium-point model's: does stiffness depend on velocity?

use super::MakeJoint;
use super::stiffness::{CYCLE_N_MM, CYCLES_A_LEVEL, Identified, cycle, cycle_targets};
use crate::error::ControlError;
use crate::execution::{Commands, PulseShape};
use crate::identification::{Response, identify};
use crate::statistics::{PairedTest, mean_and_deviation, paired_t_test};
use rayon::prelude::*;
use serde::Serialize;

/// The range by which Δ is divided, N/mm (Wang and Realmuto 2026, equation of Δ).
pub const THEORETICAL_RANGE_N_MM: f64 = 176.0 - 126.0;

/// One row of the table.
#[derive(Debug, Clone, Serialize)]
pub struct ComparisonRow {
    /// Nominal stiffness, N/mm.
    pub nominal_n_mm: f64,
    /// Mean and standard deviation at rest (peak and trough), N/mm.
    pub at_rest_n_mm: [f64; 2],
    /// Mean and standard deviation at the largest velocity (centre), N/mm.
    pub at_speed_n_mm: [f64; 2],
    /// `|K(0) − K(max)|` over the theoretical range, %.
    pub delta_percent: f64,
    /// Paired test of K at rest against K at speed; none if there are too few pairs.
    pub test: Option<PairedTest>,
    /// The pairs, N/mm.
    pub pairs: Vec<[f64; 2]>,
}

/// The published table: nominal, K at rest, K at speed, Δ %, p; the learned model before the
/// equilibrium-point model.
pub const PUBLISHED: [[[f64; 5]; 3]; 2] = [
    [
        [140.0, 139.54, 140.07, 1.06, 0.6036],
        [150.0, 146.96, 145.83, 2.26, 0.1075],
        [160.0, 152.39, 153.36, 1.94, 0.2585],
    ],
    [
        [140.0, 140.66, 136.64, 8.04, 3.9e-12],
        [150.0, 146.98, 143.09, 7.78, 1.9e-13],
        [160.0, 151.39, 147.46, 7.86, 9.3e-14],
    ],
];

/// Runs the cycle `repeats` times with commands and makes the table's rows.
///
/// At each place the pushes of both directions, from two cycles in a row, give one stiffness, from
/// [half the difference](Response::half_difference) of their responses: averaging the stiffnesses of single
/// pushes instead would favour large ones, since a response is inverse to its stiffness. A pair is the mean
/// of peak and trough beside the centre of the same cycles.
///
/// # Errors
/// As [`cycle`].
pub fn rows(
    commands: &Commands,
    shape: &PulseShape,
    mass_kg: f64,
    repeats: usize,
    seed: u64,
    make: MakeJoint<'_>,
) -> Result<(Vec<ComparisonRow>, Vec<Identified>), ControlError> {
    let runs: Vec<Vec<Identified>> = (0..repeats)
        .into_par_iter()
        .map(|k| cycle(commands, shape, mass_kg, seed + k as u64, make))
        .collect::<Result<_, _>>()?;
    let mut rows = Vec::new();
    for nominal in CYCLE_N_MM {
        let mut pairs = Vec::new();
        for run in &runs {
            // Two cycles in a row hold a pulse of each direction at each place.
            for first in (0..CYCLES_A_LEVEL - 1).step_by(2) {
                let at = |place: &str| -> Option<f64> {
                    let of = |direction: f64| {
                        run.iter().find(|i| {
                            let pulse = &i.record.pulse;
                            let within = (pulse.time_s / 10.0) as usize % CYCLES_A_LEVEL;
                            pulse.place == place
                                && pulse.direction == direction
                                && (i.record.commanded_n_mm - nominal).abs() < 0.5
                                && (first..first + 2).contains(&within)
                        })
                    };
                    let [push, opposite] =
                        [of(1.0)?, of(-1.0)?].map(|i| Response::of_pulse(&i.record, mass_kg));
                    let both = Response::half_difference(&push, &opposite);
                    identify(&both).ok().map(|e| e.stiffness_n_mm)
                };
                if let (Some(peak), Some(trough), Some(centre)) =
                    (at("peak"), at("trough"), at("centre"))
                {
                    pairs.push([0.5 * (peak + trough), centre]);
                }
            }
        }
        let column = |i: usize| {
            let (mean, deviation) =
                mean_and_deviation(&pairs.iter().map(|p| p[i]).collect::<Vec<_>>());
            [mean, deviation]
        };
        let (at_rest_n_mm, at_speed_n_mm) = (column(0), column(1));
        let difference = (at_rest_n_mm[0] - at_speed_n_mm[0]).abs();
        rows.push(ComparisonRow {
            nominal_n_mm: nominal,
            at_rest_n_mm,
            at_speed_n_mm,
            delta_percent: 100.0 * difference / THEORETICAL_RANGE_N_MM,
            test: paired_t_test(&pairs).ok(),
            pairs,
        });
    }
    Ok((rows, runs.into_iter().flatten().collect()))
}

/// The targets of the comparison.
///
/// # Errors
/// As [`cycle_targets`].
pub fn targets() -> Result<Vec<crate::synthesis::Target>, ControlError> {
    cycle_targets(&CYCLE_N_MM, CYCLES_A_LEVEL)
}
