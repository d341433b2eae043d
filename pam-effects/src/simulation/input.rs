//! The measured force on a uniform grid, read back at any delay.

use pam_core::Scalar;
use pam_data::Recording;

/// The recorded force (before its low-pass, if that is known) on a grid of half a step.
///
/// A held force lags the samples by half of the time Δ between them, and is weaker than a smooth one through them by
/// Δ²/24 of its second derivative. Where samples are closer than the grid, it holds the force so: a smooth curve through the
/// samples half a sample late, with that term. A lead of half a sample takes the lag away. Values are means over the spacing of the
/// grid, which prevents aliasing of noise, and are corrected for the attenuation of a smooth force: at 10 Hz the amplitude is exact to
/// 10⁻⁵.
///
/// Where samples are further apart, the grid has the steps of the held force themselves, and a lead blends them with the smooth
/// curve: the polynomial of degree seven through the eight nearest samples. 6 Hz at 25 Hz lose 10⁻³ of their amplitude by it, where
/// cubics of four samples lose 7·10⁻².
///
/// A step weighs its three values by Simpson's rule, which aliases a component that alternates from one value to the next to a constant
/// force. The grid contains no such component, so that the impulse of a jump does not depend on where in a step it occurs.
#[derive(Debug, Clone)]
pub struct FineForce {
    /// The held force, mN.
    values_mn: Vec<f64>,
    /// Change of it by a lead of one sample, mN; empty where samples are closer than the grid and a lead is a shift.
    by_lead_mn: Vec<f64>,
    spacing_s: f64,
    sample_s: f64,
}

/// Points of a mean, as shares of the spacing.
const POINTS: [f64; 5] = [-0.4, -0.2, 0.0, 0.2, 0.4];
/// Change of a parabola by their mean, in second differences: half the mean square of the shares.
const ADDED_BY_MEAN: f64 = 0.04;
/// Change of a smooth curve by straight lines between samples Δ apart, in Δ² times its second derivative: the mean of their errors.
const ADDED_BY_LINES: f64 = 1.0 / 12.0;
/// Change of the smooth force by a hold, in the same unit: the mean of t²/2 over ±Δ/2.
const ADDED_BY_HOLD: f64 = 1.0 / 24.0;
/// Share of a step by which a time may miss the end of one.
const ALIGNED: f64 = 1e-3;
/// Samples on either side of an instant through which the polynomial of the smooth curve goes.
const SIDE: usize = 4;

impl FineForce {
    /// The force of a recording at `count` points `spacing_s` apart from its first sample on.
    #[must_use]
    pub fn new(recording: &Recording, spacing_s: f64, count: usize) -> Self {
        let t = &recording.time_s;
        let sample_s = pam_data::recording::median_step_s(t);
        let force_mn = recording.low_passed.force_mn.as_ref().unwrap_or(&recording.force_mn);
        let start_s = t[0] - 0.5 * sample_s;
        if sample_s <= spacing_s {
            let means = means(t, force_mn, start_s, spacing_s, count, |_| spacing_s);
            // The attenuation by the zero-order hold is part of the force that acts; it stays.
            let added =
                ADDED_BY_MEAN + (ADDED_BY_LINES - ADDED_BY_HOLD) * (sample_s / spacing_s).powi(2);
            let values_mn = without_alternation(sharpened(&means, added));
            let by_lead_mn = Vec::new();
            return Self { values_mn, by_lead_mn, spacing_s, sample_s };
        }
        let values_mn = held(t, force_mn, t[0], spacing_s, count);
        // Where samples are at the ends of steps, the means of both sides have the whole impulse.
        let values_mn = if at_ends_of_steps(t, 2.0 * spacing_s) {
            values_mn
        } else {
            without_alternation(values_mn)
        };
        let smooth = joined(t, force_mn, t[0], spacing_s, count);
        let by_lead_mn = smooth.iter().zip(&values_mn).map(|(s, h)| 2.0 * (s - h)).collect();
        Self { values_mn, by_lead_mn, spacing_s, sample_s }
    }

    /// The force at `time_s` after the first sample, mN, by straight lines; outside the record its ends. A lead of half a
    /// sample makes the held force the smooth one.
    #[inline]
    pub fn at<S: Scalar>(&self, time_s: S, lead_samples: f64) -> S {
        // A held force that is late is shifted in either case.
        let [shift, blend] = match self.by_lead_mn.is_empty() {
            true => [lead_samples, 0.0],
            false => [lead_samples.min(0.0), lead_samples.max(0.0)],
        };
        let shifted = time_s + S::constant(shift * self.sample_s);
        let last = self.values_mn.len() - 1;
        let ends = [0.0, last as f64].map(S::constant);
        let position = shifted.scaled(1.0 / self.spacing_s).clamped(ends[0], ends[1]);
        // At a grid point, within rounding, the line before it: the derivative is that towards a positive delay.
        let whole = (position.real() - 1e-9).floor().clamp(0.0, (last - 1) as f64);
        let value = |k: usize| {
            let added = self.by_lead_mn.get(k).map_or(0.0, |by_lead| blend * by_lead);
            self.values_mn[k] + added
        };
        let (a, b) = (value(whole as usize), value(whole as usize + 1));
        S::constant(a) + (position - S::constant(whole)).scaled(b - a)
    }

    /// The forces at the grid points with a lead, mN.
    #[must_use]
    pub fn led(&self, lead_samples: f64) -> Vec<f64> {
        if lead_samples == 0.0 {
            return self.values_mn.clone();
        }
        (0..self.values_mn.len())
            .map(|k| self.at(self.spacing_s * k as f64, lead_samples))
            .collect()
    }

    /// The values of this range of the grid.
    pub(super) fn part(&self, values: std::ops::Range<usize>) -> Self {
        let of = |all: &[f64]| all.get(values.clone()).map_or_else(Vec::new, <[f64]>::to_vec);
        Self {
            values_mn: of(&self.values_mn),
            by_lead_mn: of(&self.by_lead_mn),
            spacing_s: self.spacing_s,
            sample_s: self.sample_s,
        }
    }

    /// The values of a held force, mN.
    #[must_use]
    pub fn values_mn(&self) -> &[f64] {
        &self.values_mn
    }
}

/// Whether all times lie on a grid of steps that begins at the first one.
fn at_ends_of_steps(time_s: &[f64], step_s: f64) -> bool {
    time_s.iter().all(|t| {
        let steps = (t - time_s[0]) / step_s;
        (steps - steps.round()).abs() < ALIGNED
    })
}

/// A series without what alternates from one value to the next, by `1 + δ⁶/64` with the central difference `δ`: at a phase of `θ` per
/// value `1 − sin⁶(θ/2)`, which is zero for alternating values, and 6·10⁻⁸ from one at 10 Hz on a grid of 2 ms.
fn without_alternation(values: Vec<f64>) -> Vec<f64> {
    let sixth = (0..3).fold(values.clone(), |d, _| second_differences(&d));
    values.iter().zip(sixth).map(|(value, sixth)| value + sixth / 64.0).collect()
}

/// Second differences of a series; zero at its ends.
fn second_differences(values: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; values.len()];
    for (out, near) in out.iter_mut().skip(1).zip(values.windows(3)) {
        *out = near[0] - 2.0 * near[1] + near[2];
    }
    out
}

/// Undoes the attenuation by a mean that adds `added` times the second difference to a smooth curve, to second order.
fn sharpened(values: &[f64], added: f64) -> Vec<f64> {
    let bends = second_differences(values);
    values.iter().zip(bends).map(|(value, bend)| value - added * bend).collect()
}

/// Values at `count` times from `start_s` on, `spacing_s` apart, of a smooth curve through samples `sample_s` apart: [`means`],
/// corrected for their attenuation (1.8·10⁻³ of the amplitude at 8 Hz, 1 kHz and 4 ms; 10⁻⁵ is left of it).
pub(super) fn resampled(
    time_s: &[f64],
    values: &[f64],
    sample_s: f64,
    start_s: f64,
    spacing_s: f64,
    count: usize,
) -> Vec<f64> {
    let end_s = time_s[time_s.len() - 1];
    // Narrower windows near the ends keep the mean centred on its time.
    let width_s = |centre_s: f64| {
        let inside_s = (centre_s - time_s[0]).min(end_s - centre_s).max(0.0);
        spacing_s.min(inside_s / POINTS[4])
    };
    let means = means(time_s, values, start_s, spacing_s, count, width_s);
    sharpened(&means, ADDED_BY_MEAN + ADDED_BY_LINES * (sample_s / spacing_s).powi(2))
}

/// Values at `count` times from `start_s` on, `spacing_s` apart: means of five points of the straight
/// lines between samples over a window of `width_s(time)`. A window of one spacing prevents aliasing of noise above the grid's rate. Before
/// the first and after the last sample, the series is constant.
fn means(
    time_s: &[f64],
    values: &[f64],
    start_s: f64,
    spacing_s: f64,
    count: usize,
    width_s: impl Fn(f64) -> f64,
) -> Vec<f64> {
    let last = time_s.len() - 1;
    let mut at = 0;
    let mut out = Vec::with_capacity(count);
    for k in 0..count {
        let centre = start_s + spacing_s * k as f64;
        let width_s = width_s(centre);
        let mut sum = 0.0;
        for share in POINTS {
            let t = centre + share * width_s;
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
    let line = |at: usize, along: f64| values[at] + along * (values[at + 1] - values[at]);
    between(time_s, start_s, spacing_s, count, line)
}

/// As [`interpolated`], on polynomials through the nearest samples, four on either side where there are so many.
fn joined(time_s: &[f64], values: &[f64], start_s: f64, spacing_s: f64, count: usize) -> Vec<f64> {
    let polynomial = |at: usize, along: f64| {
        let t = time_s[at] + along * (time_s[at + 1] - time_s[at]);
        let from = (at + 1).saturating_sub(SIDE);
        let nodes = from..(at + 1 + SIDE).min(time_s.len());
        // Lagrange's form.
        let weight = |k: usize| {
            let others = nodes.clone().filter(|&j| j != k);
            others.map(|j| (t - time_s[j]) / (time_s[k] - time_s[j])).product::<f64>()
        };
        nodes.clone().map(|k| weight(k) * values[k]).sum()
    };
    between(time_s, start_s, spacing_s, count, polynomial)
}

/// Means of the held values over `spacing_s` about `count` times from `start_s` on.
fn held(time_s: &[f64], values: &[f64], start_s: f64, spacing_s: f64, count: usize) -> Vec<f64> {
    let mut at = 0;
    let of = |k: usize| {
        let end = start_s + spacing_s * (k as f64 + 0.5);
        let mut mean = values[at];
        while at + 1 < time_s.len() && time_s[at + 1] < end {
            at += 1;
            let share = ((end - time_s[at]) / spacing_s).min(1.0);
            mean += share * (values[at] - values[at - 1]);
        }
        mean
    };
    (0..count).map(of).collect()
}

/// `value(k, share)` of the interval `k` between samples and the share of it at `count` times from `start_s` on,
/// `spacing_s` apart; outside the record at its ends.
fn between(
    time_s: &[f64],
    start_s: f64,
    spacing_s: f64,
    count: usize,
    value: impl Fn(usize, f64) -> f64,
) -> Vec<f64> {
    let mut at = 0;
    let of = |k: usize| {
        let t = start_s + spacing_s * k as f64;
        while at + 2 < time_s.len() && time_s[at + 1] <= t {
            at += 1;
        }
        let along = (t - time_s[at]) / (time_s[at + 1] - time_s[at]);
        value(at, along.clamp(0.0, 1.0))
    };
    (0..count).map(of).collect()
}
