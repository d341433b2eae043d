//! Slow changes: of the mean of a residual, and of its size.

use super::{Anomaly, Part};
use crate::noise::{Autoregression, autocovariance};
use crate::residual::{Jump, TimeProfile};
use crate::search::Candidates;
use pam_core::units::significant;
use pam_numerics::statistics::mean;

impl<C: Candidates + ?Sized> Part<'_, C> {
    fn jump(&self, rows: &[f64]) -> Option<Jump> {
        let settings = &self.channel.of.problem.settings.residual;
        TimeProfile::new(self.row_s, self.start_s, rows, settings).jump
    }

    /// A step of the mean.
    pub(super) fn step(&self) -> Option<Anomaly> {
        let (rows, output) = (self.plain(), self.channel.output);
        let settings = self.channel.of.problem.settings;
        let jump = self.jump(rows)?;
        let at = ((jump.time_s - self.start_s) / self.row_s).round() as usize;
        let ratio = step_ratio(rows, at, settings.noise.order);
        let share = at as f64 / rows.len().max(1) as f64;
        let size = (jump.after - jump.before).abs() * (share * (1.0 - share)).max(0.0).sqrt();
        (ratio > settings.verdict.step_ratio && size > self.channel.own).then(|| {
            let text = format!(
                "the {} shifts by {} {} at t = {} s in {}",
                output.name,
                significant(jump.after - jump.before, 3),
                output.unit,
                significant(jump.time_s, 3),
                self.name()
            );
            self.anomaly("step", Some(jump.time_s), text)
        })
    }

    /// A drift of the mean.
    pub(super) fn drift(&self) -> Option<Anomaly> {
        let (settings, output) = (self.channel.of.problem.settings, self.channel.output);
        let (drift, ratio) = drift(self.plain(), settings.noise.order);
        // The root mean square of a straight line of this height.
        let size = drift.abs() / 12_f64.sqrt();
        (ratio > settings.verdict.step_ratio && size > self.channel.own).then(|| {
            let (drift, name) = (significant(drift, 3), self.name());
            let text = format!("the {} drifts by {drift} {} in {name}", output.name, output.unit);
            self.anomaly("drift", None, text)
        })
    }

    /// A change of the size: a part that is as quiet as the noise, beside one that is not.
    pub(super) fn change(&self) -> Option<Anomaly> {
        let jump = self.jump(self.white())?;
        let ratio = self.channel.of.problem.settings.verdict.unlearnable_ratio;
        let verb = if jump.rms_after > ratio * jump.rms_before {
            "begins"
        } else if jump.rms_before > ratio * jump.rms_after {
            "ends"
        } else {
            return None;
        };
        (jump.rms_before.max(jump.rms_after) > ratio).then(|| {
            let (channel, at) = (&self.channel.output.name, significant(jump.time_s, 3));
            let text = format!("an error of the {channel} {verb} at t = {at} s in {}", self.name());
            self.anomaly("change", Some(jump.time_s), text)
        })
    }
}

/// Change of the straight line fitted to a residual from its first row to its last, and the ratio of the slope to its standard error. The error
/// assumes that the residual about the line is stationary.
fn drift(rows: &[f64], order: usize) -> (f64, f64) {
    let n = rows.len() as f64;
    let (middle, centre) = (0.5 * (n - 1.0), mean(rows));
    let at = |k: usize| k as f64 - middle;
    let spread = n * (n * n - 1.0) / 12.0;
    let slope = rows.iter().enumerate().map(|(k, r)| at(k) * r).sum::<f64>() / spread.max(1.0);
    let rest: Vec<f64> = rows.iter().enumerate().map(|(k, r)| r - centre - slope * at(k)).collect();
    let noise = Autoregression::of_autocovariance(&autocovariance(&[&rest], order), n);
    let error = noise.deviation() * (noise.correlated_rows() / spread.max(1.0)).sqrt();
    (slope * n, slope.abs() / error.max(f64::MIN_POSITIVE))
}

/// Ratio of the change of the mean at a row to its standard error, which assumes stationary noise before and after.
fn step_ratio(rows: &[f64], at: usize, order: usize) -> f64 {
    let (before, after) = rows.split_at(at.clamp(1, rows.len() - 1));
    let sides = [before, after].map(|side| {
        let centre = mean(side);
        side.iter().map(|r| r - centre).collect::<Vec<f64>>()
    });
    let gamma = autocovariance(&[&sides[0], &sides[1]], order);
    let noise = Autoregression::of_autocovariance(&gamma, rows.len() as f64);
    let share = 1.0 / before.len() as f64 + 1.0 / after.len() as f64;
    let error = noise.deviation() * (noise.correlated_rows() * share).sqrt();
    (mean(after) - mean(before)).abs() / error.max(f64::MIN_POSITIVE)
}
