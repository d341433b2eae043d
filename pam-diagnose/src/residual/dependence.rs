//! With what a residual goes.

use crate::fit::{Hypothesis, Problem};
use serde::Serialize;

/// What a residual is tested against.
pub const FACTORS: [&str; 8] = [
    "position",
    "velocity",
    "direction of motion",
    "force",
    "phase in the cycle",
    "amplitude of the motion",
    "time since sealing",
    "recording",
];

/// The share of a residual's variance that one factor explains.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Dependence {
    /// One of [`FACTORS`].
    pub factor: &'static str,
    /// Correlation ratio η², 0 to 1: variance of the means in twelve groups of equal size over the whole
    /// variance, less what unrelated groups would show.
    pub share: f64,
    /// Middle of each group (in the factor's unit) and mean residual there.
    pub groups: Vec<[f64; 2]>,
}

/// Groups of equal size.
const GROUPS: usize = 12;
/// Residuals are correlated over about half a second: so many rows are one observation.
const ROWS_PER_OBSERVATION: f64 = 25.0;

/// Values of every factor at the rows of a trial.
pub(super) fn factors(problem: &Problem<'_>, trial: usize) -> [Vec<f64>; 8] {
    let t = problem.trials[trial];
    let window = problem.windows[trial].clone();
    let at: Vec<usize> = window.step_by(crate::fit::POINTS_PER_ROW).map(|k| k + 2).collect();
    let (x, v) = (&t.record.measured[0], &t.record.measured[1]);
    let force = t.record.force.values_mn();
    let speed = (v.iter().map(|v| v * v).sum::<f64>() / v.len() as f64).sqrt();
    let pick = |values: &[f64]| at.iter().map(|&k| values[k.min(values.len() - 1)]).collect();
    // The phase by displacement and velocity in units of their own variation about a running middle.
    let span = (1.0 / t.record.step_s) as usize;
    let running = |values: &[f64], k: usize, f: fn(f64, f64) -> f64, from: f64| {
        let (a, b) = (k.saturating_sub(span), (k + span).min(values.len() - 1));
        values[a..=b].iter().step_by(8).copied().fold(from, f)
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
    [
        pick(x),
        pick(v),
        at.iter().map(|&k| (v[k.min(v.len() - 1)] / (0.1 * speed)).tanh()).collect(),
        at.iter().map(|&k| force[(2 * k).min(force.len() - 1)]).collect(),
        phase,
        amplitude,
        at.iter().map(|&k| k as f64 * t.record.step_s).collect(),
        vec![trial as f64; at.len()],
    ]
}

/// Tests a residual against every factor, strongest first.
pub(super) fn dependences(
    problem: &Problem<'_>,
    residuals: &[[Vec<f64>; 3]],
    channel: usize,
) -> Vec<Dependence> {
    let mut columns: [Vec<f64>; 8] = Default::default();
    let mut values = Vec::new();
    for (trial, r) in residuals.iter().enumerate() {
        for (column, mut more) in columns.iter_mut().zip(factors(problem, trial)) {
            more.truncate(r[channel].len());
            column.extend(more);
        }
        values.extend_from_slice(&r[channel]);
    }
    let mut all: Vec<Dependence> = FACTORS
        .iter()
        .zip(&columns)
        .map(|(factor, column)| {
            let (share, groups) = correlation_ratio(column, &values, ROWS_PER_OBSERVATION);
            Dependence { factor, share, groups }
        })
        .collect();
    all.sort_by(|a, b| b.share.total_cmp(&a.share));
    all
}

/// η² of `values` in groups of `factor`, less what unrelated groups would show if so many rows are one
/// independent observation; middle and mean of each group.
pub(crate) fn correlation_ratio(
    factor: &[f64],
    values: &[f64],
    rows_per_observation: f64,
) -> (f64, Vec<[f64; 2]>) {
    let n = values.len();
    let mean = values.iter().sum::<f64>() / n.max(1) as f64;
    let total: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&a, &b| factor[a].total_cmp(&factor[b]));
    let mut distinct: Vec<f64> = order.iter().map(|&i| factor[i]).collect();
    distinct.dedup();
    let cuts: Vec<&[usize]> = if distinct.len() <= GROUPS {
        order.chunk_by(|&a, &b| factor[a] == factor[b]).collect()
    } else {
        order.chunks(n.div_ceil(GROUPS).max(1)).collect()
    };
    let mut between = 0.0;
    let groups = cuts
        .iter()
        .map(|group| {
            let size = group.len() as f64;
            let middle = group.iter().map(|&i| factor[i]).sum::<f64>() / size;
            let height = group.iter().map(|&i| values[i]).sum::<f64>() / size;
            between += size * (height - mean).powi(2);
            [middle, height]
        })
        .collect();
    let observations = (n as f64 / rows_per_observation).max(2.0);
    let by_chance = ((cuts.len() as f64 - 1.0) / observations).min(1.0);
    let share = if total > 0.0 { between / total } else { 0.0 };
    (((share - by_chance) / (1.0 - by_chance).max(1e-9)).max(0.0), groups)
}

/// Residuals of every trial at a hypothesis; a trial that diverges has none.
pub(super) fn all_residuals(
    problem: &Problem<'_>,
    hypothesis: &Hypothesis<'_>,
) -> Vec<[Vec<f64>; 3]> {
    (0..problem.len()).map(|i| problem.residuals(hypothesis, i).unwrap_or_default()).collect()
}
