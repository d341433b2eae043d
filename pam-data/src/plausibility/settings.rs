//! The numbers of the checks.

use crate::models::SavedModel;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Thresholds and prior spreads of [`check`](super::check).
///
/// A reading of the columns (kPa absolute, bar, gauge, degrees, swapped…) is weighed by log odds against the
/// reading that the format states. The spreads say how far sound data of a faulty joint may lie from the model:
/// what a diagnosis is there to find must not be refused as a wrong unit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlausibilitySettings {
    /// Log odds from which another reading is reported. Default: ln 10, "strong" (Jeffreys 1961).
    pub warning_log_odds: f64,
    /// Log odds from which another reading is certain. Default: ln 100, "decisive" (Jeffreys 1961).
    pub error_log_odds: f64,
    /// Standard deviation of the common log ratio between the measured and the isothermal change of pressure over
    /// displacement in slow motion, for a joint without a fault in the gas. Default: 0.06; the published run has -0.01 at
    /// 0.1 Hz, models' coefficients agree with it to some per cent.
    pub gas_spread: f64,
    /// Addition to it in fast motion, by air that warms. Default: 0.18, the virtual rig at 0.5 to 2 Hz; ln 1.4 = 0.34 is the
    /// adiabatic limit.
    pub warming_spread: f64,
    /// Time in which the air takes the temperature of the wall, s. Default: 0.8, conduction in a still cylinder of 5 mm
    /// radius at 412 kPa (Carslaw and Jaeger 1959, section 7.6).
    pub warming_time_s: f64,
    /// The same for a joint with a fault: polytropic air (ln 1.4 = 0.34), coefficients off by tens of per cent.
    pub faulty_gas_spread: f64,
    /// Prior probability of such a fault.
    pub faulty_gas_share: f64,
    /// Standard deviation of the log ratio of one chamber around the common one. Default: 0.03, a sensor bias of
    /// 10 kPa at 330 kPa.
    pub chamber_spread: f64,
    /// Lowest absolute pressure of a muscle, kPa. Default: 105, just above the atmosphere: below it a muscle is
    /// limp.
    pub lowest_kpa: f64,
    /// Highest absolute pressure of a muscle, kPa. Default: 1000, above the 8 bar gauge of the largest fluidic
    /// muscles' data sheets.
    pub highest_kpa: f64,
    /// Recordings, spread over the set, whose force and masses are asked about gauge pressures. Default: 5; more cost
    /// time and add nothing, since the answer is bounded.
    pub asked_recordings: usize,
    /// Log odds against gauge pressures where absolute ones are stated, before the data are seen.
    pub gauge_prior: f64,
    /// Log odds against any other unit, scale or sign.
    pub unit_prior: f64,
    /// Range of the factor between measured and modelled change of pressure over displacement that may be a fault to be
    /// diagnosed; outside it the geometry is wrong. Default: 0.63 to 2.1; polytropic air (an exponent up to 2) raises
    /// the factor, and only gains and coefficients off by tens of per cent lower it.
    pub geometry_factors: [f64; 2],
    /// Largest factor between given masses and `P V / C` that is a fault to be diagnosed.
    pub mass_factor: f64,
    /// Largest factor between measured and modelled force that is a fault to be diagnosed.
    pub force_factor: f64,
    /// Largest factor between velocity and derivative of the displacement that is a fault to be diagnosed.
    pub velocity_factor: f64,
    /// Smallest share of variance (R²) that a relation must explain before its slope counts.
    pub least_r2: f64,
    /// Longest total delay of a sensor, s, that may be a fault to be diagnosed. Where the measured phase allows that such a delay has
    /// reversed the sign of the motion, pressures and displacement do not reveal a wrong sign. Default: 0.2 s.
    pub longest_delay_s: f64,
    /// Largest phase between pressures and displacement, rad, at which they reveal a wrong sign at any frequency. Default: 30 degrees;
    /// swapped columns have a phase of 0.
    pub largest_phase_rad: f64,
    /// Averaging time of the samples before regressions, s. Default: 20 ms, which keeps the amplitude of motion up
    /// to 8 Hz within 5 %.
    pub block_s: f64,
    /// Longest sampling step that is taken for seconds, s. Default: 0.2 s; joints are sampled at 10 Hz and above.
    pub longest_step_s: f64,
    /// Shortest sampling step of a joint, s. Default: 20 µs, 50 kHz.
    pub shortest_step_s: f64,
}

impl PlausibilitySettings {
    /// The settings for a model: the force of a data sheet that was never fitted to recordings of the joint may be off
    /// by a factor of 30, and tells nothing but prefixes of units.
    #[must_use]
    pub fn for_model(saved: &SavedModel) -> Self {
        let settings = Self::default();
        let unknown = !saved.info.trained && saved.info.rig.is_some();
        let force_factor = if unknown { 30.0 } else { settings.force_factor };
        Self { force_factor, ..settings }
    }
}

impl Default for PlausibilitySettings {
    fn default() -> Self {
        Self {
            warning_log_odds: 10_f64.ln(),
            error_log_odds: 100_f64.ln(),
            gas_spread: 0.06,
            warming_spread: 0.18,
            warming_time_s: 0.8,
            faulty_gas_spread: 0.3,
            faulty_gas_share: 0.1,
            chamber_spread: 0.03,
            lowest_kpa: 105.0,
            highest_kpa: 1000.0,
            asked_recordings: 5,
            gauge_prior: -1.5,
            unit_prior: -5.0,
            geometry_factors: [0.63, 2.1],
            mass_factor: 1.6,
            force_factor: 3.0,
            velocity_factor: 1.5,
            least_r2: 0.7,
            longest_delay_s: 0.2,
            largest_phase_rad: PI / 6.0,
            block_s: 0.02,
            longest_step_s: 0.2,
            shortest_step_s: 2e-5,
        }
    }
}
