//! Commands of the learned model against those of the equilibrium-point model: does stiffness depend on velocity?

use super::MakeJoint;
use super::stiffness::{CYCLE_N_MM, CYCLES_A_LEVEL, Identified, cycle, cycle_targets};
use crate::error::ControlError;
use crate::execution::{Commands, PulseShape};
use crate::identification::{Response, identify};
use crate::synthesis::Target;
use pam_core::parallel;
use pam_core::units::MN_PER_N;
use pam_core::{ForceInput, ForceModel, JointModel, SealedMasses};
use pam_numerics::statistics::{PairedTTest, mean, paired_t_test, standard_deviation};
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
    pub test: Option<PairedTTest>,
    /// The pairs, N/mm.
    pub pairs: Vec<[f64; 2]>,
    /// Stiffness of the learned force under these commands.
    pub expected: Option<Expected>,
    /// K at rest and at speed that the same cycle gives on [the learned joint itself](super::on_model), N/mm:
    /// how much of a difference lies in the commands and in what a pulse measures.
    pub on_model_n_mm: Option<[f64; 2]>,
}

impl ComparisonRow {
    /// K at speed less K at rest, N/mm.
    #[must_use]
    pub fn change_n_mm(&self) -> f64 {
        self.at_speed_n_mm[0] - self.at_rest_n_mm[0]
    }
}

/// Stiffness of the learned force under commands, N/mm: what of a difference between rest and speed is the
/// place, since the joint rests at the ends and moves at the centre, and what is the velocity.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Expected {
    /// At peak and trough, at rest.
    pub ends_n_mm: f64,
    /// At the centre, as if at rest.
    pub centre_n_mm: f64,
    /// At the centre, moving either way.
    pub centre_moving_n_mm: f64,
}

/// Displacement over which [`expected`] takes its slope, mm: about as far as a pulse moves the joint.
const SLOPE_MM: f64 = 0.5;

/// Stiffness of a force under commands, for each nominal stiffness: the slope over ±0.5 mm at the air that the
/// commanded pressures hold.
#[must_use]
pub fn expected<F: ForceModel<f64>>(
    model: &JointModel<f64, F>,
    targets: &[Target],
    commands: &Commands,
) -> Vec<Option<Expected>> {
    let mut work = vec![0.0; model.force.work_len()];
    let mut slope = |x: f64, v: f64, masses: SealedMasses| {
        let mut force = |x: f64| {
            let input = ForceInput {
                mass_flexor_g: masses.flexor_g,
                mass_extensor_g: masses.extensor_g,
                displacement_mm: x,
                velocity_mm_s: v,
            };
            model.force.restoring_force_mn(&input, &mut work)
        };
        (force(x + SLOPE_MM) - force(x - SLOPE_MM)) / (2.0 * SLOPE_MM * MN_PER_N)
    };
    CYCLE_N_MM
        .iter()
        .map(|&nominal| {
            let of_level = || {
                let rows = targets.iter().zip(&commands.pressures_kpa);
                rows.filter(|(t, _)| (t.stiffness_n_mm - nominal).abs() < 0.5)
            };
            let largest =
                |f: fn(&Target) -> f64| of_level().map(|(t, _)| f(t).abs()).fold(0.0_f64, f64::max);
            let (x_max, v_max) = (largest(|t| t.displacement_mm), largest(|t| t.velocity_mm_s));
            let (mut ends, mut centre, mut moving) = (Vec::new(), Vec::new(), Vec::new());
            for (t, &pressures) in of_level() {
                let masses = model.gas_law_masses(t.displacement_mm, pressures);
                if t.displacement_mm.abs() > 0.999 * x_max {
                    ends.push(slope(t.displacement_mm, 0.0, masses));
                } else if t.velocity_mm_s.abs() > 0.999 * v_max {
                    centre.push(slope(t.displacement_mm, 0.0, masses));
                    moving.push(slope(t.displacement_mm, t.velocity_mm_s, masses));
                }
            }
            (!ends.is_empty() && !centre.is_empty()).then(|| Expected {
                ends_n_mm: mean(&ends),
                centre_n_mm: mean(&centre),
                centre_moving_n_mm: mean(&moving),
            })
        })
        .collect()
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
/// of peak and trough, and the centre of the same cycles.
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
    let runs: Vec<Vec<Identified>> =
        parallel::map(repeats, |k| cycle(commands, shape, mass_kg, seed + k as u64, make))
            .into_iter()
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
            let values: Vec<f64> = pairs.iter().map(|p: &[f64; 2]| p[i]).collect();
            [mean(&values), standard_deviation(&values)]
        };
        let (at_rest_n_mm, at_speed_n_mm) = (column(0), column(1));
        let difference = (at_rest_n_mm[0] - at_speed_n_mm[0]).abs();
        rows.push(ComparisonRow {
            nominal_n_mm: nominal,
            at_rest_n_mm,
            at_speed_n_mm,
            delta_percent: 100.0 * difference / THEORETICAL_RANGE_N_MM,
            test: paired_t_test(
                &pairs.iter().map(|[rest, speed]| speed - rest).collect::<Vec<_>>(),
            ),
            pairs,
            expected: None,
            on_model_n_mm: None,
        });
    }
    Ok((rows, runs.into_iter().flatten().collect()))
}

/// Adds to rows the stiffness of the learned model under their commands: [`expected`], and the same cycle on the
/// model itself.
///
/// # Errors
/// As [`rows`].
pub fn explain<F>(
    rows: &mut [ComparisonRow],
    model: &JointModel<f64, F>,
    targets: &[Target],
    commands: &Commands,
    shape: &PulseShape,
) -> Result<(), ControlError>
where
    F: ForceModel<f64> + Clone + Send + Sync + 'static,
{
    let mass_kg = model.physical().mass_kg;
    let (twin, _) = self::rows(commands, shape, mass_kg, 1, 0, &super::on_model(model))?;
    for ((row, twin), expected) in rows.iter_mut().zip(twin).zip(expected(model, targets, commands))
    {
        row.expected = expected;
        row.on_model_n_mm =
            (!twin.pairs.is_empty()).then(|| [twin.at_rest_n_mm[0], twin.at_speed_n_mm[0]]);
    }
    Ok(())
}

/// The targets of the comparison.
///
/// # Errors
/// As [`cycle_targets`].
pub fn targets() -> Result<Vec<Target>, ControlError> {
    cycle_targets(&CYCLE_N_MM, CYCLES_A_LEVEL)
}
