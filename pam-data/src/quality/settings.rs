//! The thresholds of the checks.

use serde::{Deserialize, Serialize};

/// From what size on something is reported. Sound recordings of the published and the virtual rig have no error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct QualitySettings {
    /// RMS deviation of the time steps over the median step. Default: 0.05; a filter that takes the steps as equal then
    /// errs by some per cent at a tenth of the sampling rate.
    pub jitter_share: f64,
    /// Lowest sampling rate, Hz. Default: 20, ten samples a period of the published motion's 2 Hz.
    pub lowest_rate_hz: f64,
    /// Share of the samples at an end of the range while the joint moves. Default: 0.01.
    pub clipped_share: f64,
    /// Fewest steps of the resolution in the range of a channel. Default: 50; rounding is then uniform noise of less than
    /// 1 % of the range (Widrow 1956).
    pub fewest_levels: f64,
    /// Change of the level from the first to the last tenth over the range. Default: 0.3.
    pub drift_share: f64,
    /// Standard deviation of the noise over that of the channel. Default: 0.1, a tenth of the channel's variance being 1 %.
    pub noise_share: f64,
    /// Delay of a pressure behind the displacement, s. Default: 0.05: sensors' tubes and filters stay below it.
    pub pressure_delay_s: f64,
    /// Lead of a pressure before the displacement, s. Default: 0.1: air that warms leads by up to 0.06 s at 0.5 Hz.
    pub pressure_lead_s: f64,
    /// Difference between velocity and displacement, s. Default: 0.02, the lag of a first-order low-pass of 8 Hz.
    pub velocity_delay_s: f64,
    /// Largest delay that is looked for, s. Default: 0.3.
    pub longest_delay_s: f64,
    /// Share of the acceleration that position and velocity leave open, below which the mass is not told from the
    /// stiffness. Default: 0.05.
    pub open_acceleration: f64,
    /// Fewest reversals of the motion for friction and hysteresis. Default: 4, two periods.
    pub fewest_reversals: usize,
}

impl Default for QualitySettings {
    fn default() -> Self {
        Self {
            jitter_share: 0.05,
            lowest_rate_hz: 20.0,
            clipped_share: 0.01,
            fewest_levels: 50.0,
            drift_share: 0.3,
            noise_share: 0.1,
            pressure_delay_s: 0.05,
            pressure_lead_s: 0.1,
            velocity_delay_s: 0.02,
            longest_delay_s: 0.3,
            open_acceleration: 0.05,
            fewest_reversals: 4,
        }
    }
}
