//! The measured force on a uniform grid, read back at any delay.

use pam_core::Scalar;
use pam_data::Recording;

/// The recorded force (before its low-pass, if that is known) as straight lines between the middles of its
/// holds (which follows a held force to second order), on a grid of half a step.
///
/// Values are means over the grid's spacing, which keeps noise above its rate from folding back, with the second difference
/// that the mean takes from a smooth force given back: 10 Hz keep their amplitude to 10⁻⁵.
#[derive(Debug, Clone)]
pub struct FineForce {
    values_mn: Vec<f64>,
    spacing_s: f64,
}

/// Points of a mean, as shares of the spacing.
const POINTS: [f64; 5] = [-0.4, -0.2, 0.0, 0.2, 0.4];
/// What their mean adds to a parabola, in second differences: half the mean square of the shares.
const TAKEN: f64 = 0.04;

impl FineForce {
    /// The force of a recording at `count` points `spacing_s` apart from its first sample on, each the mean
    /// over its own spacing.
    #[must_use]
    pub fn new(recording: &Recording, spacing_s: f64, count: usize) -> Self {
        let t = &recording.time_s;
        let hold = 0.5 * pam_data::recording::median_step_s(t);
        let force_mn = recording.low_passed.force_mn.as_ref().unwrap_or(&recording.force_mn);
        let means = resampled(t, force_mn, t[0] - hold, spacing_s, count);
        let last = means.len() - 1;
        let value = |k: usize| {
            let (before, after) = (means[k.saturating_sub(1)], means[(k + 1).min(last)]);
            means[k] - TAKEN * (before - 2.0 * means[k] + after)
        };
        Self { values_mn: (0..=last).map(value).collect(), spacing_s }
    }

    /// The force at `time_s` after the first sample, mN, by straight lines; outside the record its ends.
    #[inline]
    pub fn at<S: Scalar>(&self, time_s: S) -> S {
        let position = time_s.scaled(1.0 / self.spacing_s);
        let last = self.values_mn.len() - 1;
        let whole = position.real().floor().clamp(0.0, (last - 1) as f64);
        let (a, b) = (self.values_mn[whole as usize], self.values_mn[whole as usize + 1]);
        let share = (position - S::constant(whole)).clamped(S::zero(), S::constant(1.0));
        S::constant(a) + share.scaled(b - a)
    }

    /// The values, mN.
    #[must_use]
    pub fn values_mn(&self) -> &[f64] {
        &self.values_mn
    }
}

/// Values at `count` times from `start_s` on, `spacing_s` apart: means of five points of the straight
/// lines between samples over one spacing, which keeps noise above the grid's rate from folding back.
pub(super) fn resampled(
    time_s: &[f64],
    values: &[f64],
    start_s: f64,
    spacing_s: f64,
    count: usize,
) -> Vec<f64> {
    let last = time_s.len() - 1;
    let mut at = 0;
    let mut out = Vec::with_capacity(count);
    for k in 0..count {
        let centre = start_s + spacing_s * k as f64;
        let mut sum = 0.0;
        for share in POINTS {
            let t = centre + share * spacing_s;
            while at + 2 <= last && time_s[at + 1] <= t {
                at += 1;
            }
            while at > 0 && time_s[at] > t {
                at -= 1;
            }
            let width = time_s[at + 1] - time_s[at];
            let along = ((t - time_s[at]) / width).clamp(0.0, 1.0);
            sum += values[at] + along * (values[at + 1] - values[at]);
        }
        out.push(sum / POINTS.len() as f64);
    }
    out
}

/// Values at `count` times from `start_s` on, `spacing_s` apart, on the straight lines between samples: the samples
/// themselves where the times are theirs.
pub(super) fn interpolated(
    time_s: &[f64],
    values: &[f64],
    start_s: f64,
    spacing_s: f64,
    count: usize,
) -> Vec<f64> {
    let mut at = 0;
    let value = |k: usize| {
        let t = start_s + spacing_s * k as f64;
        while at + 2 < time_s.len() && time_s[at + 1] <= t {
            at += 1;
        }
        let along = ((t - time_s[at]) / (time_s[at + 1] - time_s[at])).clamp(0.0, 1.0);
        values[at] + along * (values[at + 1] - values[at])
    };
    (0..count).map(value).collect()
}
