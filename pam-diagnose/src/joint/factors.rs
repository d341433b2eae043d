//! Factors that the residual of the joint may depend on.

use crate::settings::ResidualSettings;
use pam_core::units::MN_PER_N;
use pam_effects::simulation::Trial;
use std::ops::Range;

/// Names and units of the factors.
pub(super) const NAMES: [(&str, &str); 7] = [
    ("position", "mm"),
    ("velocity", "mm/s"),
    ("direction of motion", "–"),
    ("force", "N"),
    ("phase in the cycle", "rad"),
    ("amplitude of the motion", "mm"),
    ("time since sealing", "s"),
];

/// The factors at the rows of a window.
pub(super) fn factors(
    t: &Trial,
    window: Range<usize>,
    points_per_row: usize,
    settings: &ResidualSettings,
) -> Vec<Vec<f64>> {
    let at: Vec<usize> = window.step_by(points_per_row).map(|k| k + points_per_row / 2).collect();
    let (x, v) = (&t.record.measured[0], &t.record.measured[1]);
    let speed = (v.iter().map(|v| v * v).sum::<f64>() / v.len() as f64).sqrt();
    let pick = |values: &[f64]| at.iter().map(|&k| values[k.min(values.len() - 1)]).collect();
    // The phase by displacement and velocity in units of their own variation about a running middle.
    let span = (settings.cycle_window_s / t.record.step_s) as usize;
    let running = |values: &[f64], k: usize, f: fn(f64, f64) -> f64, from: f64| {
        let (a, b) = (k.saturating_sub(span), (k + span).min(values.len() - 1));
        values[a..=b].iter().step_by(settings.cycle_stride).copied().fold(from, f)
    };
    let mut phase = Vec::with_capacity(at.len());
    let mut amplitude = Vec::with_capacity(at.len());
    for &k in &at {
        let k = k.min(x.len() - 1);
        let low = running(x, k, f64::min, f64::INFINITY);
        let high = running(x, k, f64::max, f64::NEG_INFINITY);
        let fast = running(v, k, |a, b| a.max(b.abs()), 1e-9);
        let half = (0.5 * (high - low)).max(1e-9);
        phase.push((v[k] / fast).atan2((x[k] - 0.5 * (high + low)) / half));
        amplitude.push(half);
    }
    vec![
        pick(x),
        pick(v),
        at.iter()
            .map(|&k| (v[k.min(v.len() - 1)] / (settings.direction_width * speed)).tanh())
            .collect(),
        at.iter().map(|&k| t.record.force_mn(k.min(x.len() - 1)) / MN_PER_N).collect(),
        phase,
        amplitude,
        at.iter().map(|&k| k as f64 * t.record.step_s).collect(),
    ]
}
