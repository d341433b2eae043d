//! Identified against commanded stiffness.

use super::{MakeJoint, SETTLE_S};
use crate::error::ControlError;
use crate::execution::{Commands, PulseRecord, PulseShape, perturb};
use crate::identification::{Estimate, Response, cycling_pulses, identify, staircase_pulses};
use crate::motion::{Hold, Motion, MotionSpec, Sine, StiffnessProfile};
use crate::synthesis::{Target, plan};
use serde::Serialize;

/// The published levels of the staircase, N/mm.
pub const STAIRCASE_N_MM: [f64; 6] = [126.0, 136.0, 146.0, 156.0, 166.0, 176.0];
/// The published levels of the cycle, N/mm.
pub const CYCLE_N_MM: [f64; 3] = [140.0, 150.0, 160.0];
/// Cycles at each level (Wang and Realmuto 2026, section V-C).
pub const CYCLES_A_LEVEL: usize = 5;
/// Time that the staircase stays at each level, s.
pub const STAIR_S: f64 = 16.0;

/// A perturbation with what was identified from it.
#[derive(Debug, Clone, Serialize)]
pub struct Identified {
    /// The perturbation.
    #[serde(flatten)]
    pub record: PulseRecord,
    /// Stiffness and damping.
    pub estimate: Estimate,
}

/// Identifies every perturbation.
///
/// # Errors
/// [`ControlError::Insufficient`] for one that holds too little.
pub fn identify_all(
    records: Vec<PulseRecord>,
    mass_kg: f64,
) -> Result<Vec<Identified>, ControlError> {
    records
        .into_iter()
        .map(|record| {
            let estimate = identify(&Response::of_pulse(&record, mass_kg))?;
            Ok(Identified { record, estimate })
        })
        .collect()
}

/// Targets of the staircase at x = 0.
///
/// # Errors
/// Never for finite levels; as [`plan::targets`].
pub fn staircase_targets(levels_n_mm: &[f64]) -> Result<Vec<Target>, ControlError> {
    targets_of(Box::new(Hold { displacement_mm: 0.0 }), None, levels_n_mm, STAIR_S)
}

/// Targets of the cycle: a sine of 1 mm at 0.1 Hz, each level for `cycles` cycles.
///
/// # Errors
/// As [`plan::targets`].
pub fn cycle_targets(levels_n_mm: &[f64], cycles: usize) -> Result<Vec<Target>, ControlError> {
    let sine = Sine { centre_mm: 0.0, amplitude_mm: 1.0, frequency_hz: 0.1 };
    targets_of(Box::new(sine), Some(10.0), levels_n_mm, 10.0 * cycles as f64)
}

/// Targets of a motion whose stiffness stays at each level for `hold_s`.
fn targets_of(
    motion: Box<dyn Motion + Send + Sync>,
    period_s: Option<f64>,
    levels_n_mm: &[f64],
    hold_s: f64,
) -> Result<Vec<Target>, ControlError> {
    let duration_s = hold_s * levels_n_mm.len() as f64;
    let spec = MotionSpec { motion, duration_s, period_s, table: None };
    let steps = StiffnessProfile::Steps { values_n_mm: levels_n_mm.to_vec(), hold_s };
    let mut targets = plan::targets(&spec, Some(&steps), 0.0, 1000.0)?;
    targets.pop();
    Ok(targets)
}

/// The staircase: two pairs of pulses on each level.
///
/// # Errors
/// As [`identify_all`].
pub fn staircase(
    commands: &Commands,
    levels: usize,
    shape: &PulseShape,
    mass_kg: f64,
    seed: u64,
    make: MakeJoint<'_>,
) -> Result<Vec<Identified>, ControlError> {
    let mut joint = make(seed, commands.pressures_kpa(0.0));
    let pulses = staircase_pulses(levels, STAIR_S, 2);
    identify_all(perturb(&mut joint, commands, SETTLE_S, &pulses, shape), mass_kg)
}

/// The cycle: pulses at peak, centre and trough; the direction changes from cycle to cycle.
///
/// # Errors
/// As [`identify_all`].
pub fn cycle(
    commands: &Commands,
    shape: &PulseShape,
    mass_kg: f64,
    seed: u64,
    make: MakeJoint<'_>,
) -> Result<Vec<Identified>, ControlError> {
    let mut joint = make(seed, commands.pressures_kpa(0.0));
    let pulses = cycling_pulses(10.0, CYCLE_N_MM.len(), CYCLES_A_LEVEL);
    identify_all(perturb(&mut joint, commands, SETTLE_S, &pulses, shape), mass_kg)
}
