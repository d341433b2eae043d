//! Priors of the state from which predictions start.

use crate::data::OpenPart;
use crate::noise::noise_deviation;
use crate::settings::FitSettings;
use pam_effects::simulation::{ResampledRecord, Trial};

/// Standard deviations of the noise from one grid point to the next that the first sample of a sensor may be off by:
/// noise that is correlated shows a part of itself only from point to point.
const SAMPLE_DEVIATIONS: f64 = 3.0;

/// Prior standard deviations of the errors of the first samples of a recording: those of the settings combined with the sensor noise of
/// the noisiest recording and, for the pressures, of the noisier one.
#[derive(Debug, Clone, Copy)]
pub(super) struct StartDeviations {
    /// Displacement, mm.
    pub(super) mm: f64,
    /// Velocity, mm/s.
    pub(super) mm_s: f64,
    /// Pressures, kPa.
    pub(super) pressure_kpa: f64,
}

impl StartDeviations {
    /// Those of the open parts of trials.
    pub(super) fn of(trials: &[&Trial], open: &[OpenPart], fit: &FitSettings) -> Self {
        let records = || open.iter().map(|part| (&trials[part.experiment].record, part.end_s));
        let noise_of = |channel: usize| {
            let points = |(record, end_s): (&ResampledRecord, f64)| {
                record.measured[channel][..record.points_within(end_s)].to_vec()
            };
            SAMPLE_DEVIATIONS * noise_deviation(&records().map(points).collect::<Vec<_>>(), 0.0)
        };
        let largest = |of: &dyn Fn(&ResampledRecord) -> f64| {
            records().map(|(record, _)| of(record)).fold(0.0, f64::max)
        };
        let steps_mm = largest(&|record| record.resolution[0]) / 12_f64.sqrt();
        let shows_noise = records().all(|(record, _)| record.shows_noise());
        let noisy_mm = if shows_noise { noise_of(0) } else { 0.0 };
        let noisy_mm_s = largest(&|record| record.start_velocity.deviation_mm_s);
        Self {
            mm: fit.start_deviation_mm.hypot(noisy_mm.max(steps_mm)),
            mm_s: fit.start_deviation_mm_s.hypot(noisy_mm_s),
            pressure_kpa: fit.offset_deviation_kpa.hypot(noise_of(2).max(noise_of(3))),
        }
    }
}
