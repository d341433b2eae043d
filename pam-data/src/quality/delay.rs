//! Channels that come later than the displacement.

use super::channel::MeasuredChannel;
use super::settings::QualitySettings;
use super::{QualityFinding, QualityKind};
use crate::plausibility::Severity;
use crate::preprocess::gradient_at_times;
use crate::recording::{Recording, median_step_s};
use pam_numerics::statistics::mean;
use serde::Serialize;

/// Most samples of the correlation; longer recordings are thinned.
const MOST_SAMPLES: usize = 20_000;
/// Shortest step of the correlation, s.
const STEP_S: f64 = 0.004;
/// Correlation at its maximum below which a delay says nothing.
const CLEAR: f64 = 0.7;

/// By how much a channel comes later than it should by the displacement.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Delay {
    /// The column that comes later.
    pub column: &'static str,
    /// Behind what.
    pub behind: &'static str,
    /// The delay, s; negative if it comes earlier.
    pub delay_s: f64,
    /// Size of the correlation at this delay.
    pub correlation: f64,
}

/// Delays of the pressures behind x, and of ẋ behind the derivative of x.
pub(super) fn delays(r: &Recording, s: &QualitySettings) -> Vec<Delay> {
    let step = median_step_s(&r.time_s);
    let every = ((STEP_S / step).round() as usize).max(r.len() / MOST_SAMPLES).max(1);
    let thin = |v: &[f64]| v.iter().copied().step_by(every).collect::<Vec<f64>>();
    let most = (s.longest_delay_s / (step * every as f64)).round() as usize;
    let x = thin(&r.displacement_mm);
    if most < 2 || x.len() < 8 * most {
        return Vec::new();
    }
    let rate = thin(&gradient_at_times(&r.displacement_mm, &r.time_s));
    [
        (MeasuredChannel::PressureFlexor, "displacement_mm", &x),
        (MeasuredChannel::PressureExtensor, "displacement_mm", &x),
        (MeasuredChannel::Velocity, "the derivative of displacement_mm", &rate),
    ]
    .into_iter()
    .filter_map(|(channel, behind, reference)| {
        let (lag, correlation) = best_lag(reference, &thin(&channel.values(r)), most)?;
        let delay_s = lag * step * every as f64;
        (correlation >= CLEAR).then_some(Delay {
            column: channel.column(),
            behind,
            delay_s,
            correlation,
        })
    })
    .collect()
}

/// The lag of `y` behind `x` with the largest size of the correlation, between samples by a parabola.
fn best_lag(x: &[f64], y: &[f64], most: usize) -> Option<(f64, f64)> {
    let centred = |v: &[f64]| {
        let m = mean(v);
        v.iter().map(|v| v - m).collect::<Vec<f64>>()
    };
    let (x, y) = (centred(x), centred(y));
    let most = most as isize;
    let n = x.len() as isize;
    let at = |lag: isize| {
        let (from, to) = (0.max(-lag), n.min(n - lag));
        let (mut xy, mut xx, mut yy) = (0.0, 0.0, 0.0);
        for i in from..to {
            let (a, b) = (x[i as usize], y[(i + lag) as usize]);
            xy += a * b;
            xx += a * a;
            yy += b * b;
        }
        xy / (xx * yy).sqrt()
    };
    let all: Vec<f64> = (-most..=most).map(at).collect();
    let best = (1..all.len() - 1).max_by(|a, b| all[*a].abs().total_cmp(&all[*b].abs()))?;
    let [before, here, after] = [all[best - 1], all[best], all[best + 1]].map(f64::abs);
    let bend = before - 2.0 * here + after;
    let shift = if bend < 0.0 { (0.5 * (before - after) / bend).clamp(-0.5, 0.5) } else { 0.0 };
    here.is_finite().then_some((best as f64 - most as f64 + shift, here))
}

impl Delay {
    pub(super) fn finding(&self, s: &QualitySettings) -> Option<QualityFinding> {
        let is_velocity = self.column == MeasuredChannel::Velocity.column();
        let (late, early) = if is_velocity {
            (s.velocity_delay_s, s.velocity_delay_s)
        } else {
            (s.pressure_delay_s, s.pressure_lead_s)
        };
        if (-early..=late).contains(&self.delay_s) {
            return None;
        }
        let message = format!(
            "{} comes {:.0} ms {} {} (correlation {:.2}): a filter, a slow sensor, or clocks that differ; align the channels \
             before a fit, which would take the delay for friction or heat",
            self.column,
            1e3 * self.delay_s.abs(),
            if self.delay_s > 0.0 { "after" } else { "before" },
            self.behind,
            self.correlation
        );
        Some(QualityFinding::new(QualityKind::Delay, Severity::Warning, self.column, message))
    }
}
