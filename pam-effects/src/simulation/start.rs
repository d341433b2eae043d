//! The velocity with which a simulation of a recording starts.
//!
//! Its measured value is one sample of a gradient: with steps of 10 µm at 2 kHz it is off by up to 20 mm/s, from which a joint
//! rings for half a second. Where it is that noisy, the slope of the first displacements takes its place.
//!
//! The noise is read from third differences of the velocity, in which motion up to a twentieth of the sampling rate is small: of the
//! gradient `(xₖ₊₁ − xₖ₋₁)/2h` of a displacement with white noise σ they have the variance `7 σ²/h²`, of its means over n samples,
//! `(xₖ₊ₙ − xₖ)/nh`, `70 σ²/(nh)²`. Below 200 Hz they are motion, and only the steps of the sensor count as noise.

use super::record::ResampledRecord;
use pam_data::Recording;
use pam_data::recording::median_step_s;
use pam_numerics::least_squares;
use pam_numerics::statistics::{root_mean_square, third_differences};

/// Variance of the first gradient of a recording, `(x₁ − x₀)/h`, relative to that of third differences.
const FIRST_GRADIENT: f64 = 2.0 / 7.0;
/// That of any other gradient.
const GRADIENT: f64 = 1.0 / 14.0;
/// That of a mean.
const MEAN: f64 = 2.0 / 70.0;

/// Noise of the measured velocity that is left alone, mm/s.
const QUIET_MM_S: f64 = 1.0;
/// Longest time over which the displacement is fitted, s: a third of a period of 8 Hz, of which a cubic leaves little.
const LONGEST_S: f64 = 0.04;
/// Fewest samples of a cubic.
const FEWEST: usize = 8;

/// A velocity at the first sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StartVelocity {
    /// Its value, mm/s.
    pub mm_s: f64,
    /// Standard deviation of its noise, mm/s.
    pub deviation_mm_s: f64,
}

impl StartVelocity {
    /// The measured velocity of a recording, or where that is noisy the slope of its displacement; `resolution` is the step of
    /// the velocity, 0 where it has none.
    ///
    /// The slope of a cubic at the first of n samples in a time T has noise of `σ √(1200/n)/T` (Savitzky and Golay 1964, for many
    /// samples). The cubic is as long as it takes to come down to 1 mm/s, at most 40 ms.
    #[must_use]
    pub fn of(recording: &Recording, resolution: f64) -> Self {
        let step_s = median_step_s(&recording.time_s);
        let noise = noise(&recording.velocity_mm_s, step_s, FIRST_GRADIENT);
        // The steps of the gradient are half as high as those of the first one. Slow motion seldom crosses one.
        let of_steps = 2.0 * resolution / 6_f64.sqrt();
        let deviation_mm_s = noise.hypot(of_steps);
        let measured = Self { mm_s: recording.velocity_mm_s[0], deviation_mm_s };
        // The noise of the displacement, if the velocity is its gradient.
        let noise_mm = deviation_mm_s * step_s / 2_f64.sqrt();
        let slope_noise = |n: usize| noise_mm * (1200.0 / n as f64).sqrt() / (n as f64 * step_s);
        let most = ((LONGEST_S / step_s + 1e-6) as usize).min(recording.len());
        let len = (FEWEST..=most).find(|&n| slope_noise(n) <= QUIET_MM_S).unwrap_or(most);
        if len < FEWEST || deviation_mm_s <= QUIET_MM_S.max(slope_noise(len)) {
            return measured;
        }
        let (start_s, start_mm) = (recording.time_s[0], recording.displacement_mm[0]);
        let samples = recording.time_s.iter().zip(&recording.displacement_mm).take(len);
        let rows = samples.map(|(t, x)| {
            let since_s = t - start_s;
            ([1.0, since_s, since_s.powi(2), since_s.powi(3)], x - start_mm)
        });
        least_squares(rows, 0.0)
            .map_or(measured, |[_, mm_s, ..]| Self { mm_s, deviation_mm_s: slope_noise(len) })
    }

    /// The measured velocity at a grid point of a recording.
    pub(super) fn at(record: &ResampledRecord, point: usize) -> Self {
        let velocity = &record.measured[1];
        let share = if record.sample_s < record.step_s { MEAN } else { GRADIENT };
        Self { mm_s: velocity[point], deviation_mm_s: noise(velocity, record.step_s, share) }
    }
}

/// Whether differences between samples at this distance show noise: a fast motion changes little from one to the next.
pub(super) fn show_noise(step_s: f64) -> bool {
    FEWEST as f64 * step_s <= LONGEST_S * (1.0 + 1e-6)
}

/// Standard deviation of the noise of velocities, of which the variance is such a part of that of third differences; 0 where these do not
/// show noise.
fn noise(velocity_mm_s: &[f64], step_s: f64, part: f64) -> f64 {
    let differences = third_differences(velocity_mm_s);
    if !show_noise(step_s) || differences.is_empty() {
        return 0.0;
    }
    part.sqrt() * root_mean_square(&differences)
}
