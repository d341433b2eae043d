//! A residual over time.

use crate::settings::ResidualSettings;

/// An instant at which a residual changes for good.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jump {
    /// When, s after the start of the recording.
    pub time_s: f64,
    /// Mean residual before and after, in the channel's unit.
    pub before: f64,
    /// Mean residual after.
    pub after: f64,
    /// Root mean square before and after.
    pub rms_before: f64,
    /// Root mean square after.
    pub rms_after: f64,
}

/// A residual over the time of its recording.
#[derive(Debug, Clone, PartialEq)]
pub struct TimeProfile {
    /// Start of each block, s.
    pub time_s: Vec<f64>,
    /// Root mean square of each block.
    pub rms: Vec<f64>,
    /// The one instant that splits the recording best, if a split says much.
    pub jump: Option<Jump>,
}

impl TimeProfile {
    /// Profile of rows that are `row_s` apart and begin at `start_s`, in blocks.
    pub(crate) fn new(
        row_s: f64,
        start_s: f64,
        residual: &[f64],
        settings: &ResidualSettings,
    ) -> Self {
        let block = ((settings.profile_block_s / row_s * (1.0 + 1e-12)) as usize).max(1);
        let mean_square = |b: &[f64]| b.iter().map(|r| r * r).sum::<f64>() / b.len().max(1) as f64;
        let blocks: Vec<&[f64]> = residual.chunks(block).filter(|b| b.len() * 2 > block).collect();
        let time = |i: usize| start_s + i as f64 * block as f64 * row_s;
        let rms: Vec<f64> = blocks.iter().map(|b| mean_square(b).sqrt()).collect();
        Self {
            time_s: (0..blocks.len()).map(time).collect(),
            jump: jump(residual, row_s, start_s, settings),
            rms,
        }
    }
}

/// The split into two stretches of own mean that lowers the log-variance most.
fn jump(residual: &[f64], row_s: f64, start_s: f64, settings: &ResidualSettings) -> Option<Jump> {
    let n = residual.len();
    let margin =
        ((settings.jump_margin_s / row_s * (1.0 + 1e-12)) as usize).max(settings.jump_margin_rows);
    if n < settings.jump_fewest_margins * margin {
        return None;
    }
    let sums = |f: &dyn Fn(f64) -> f64| -> Vec<f64> {
        let mut total = 0.0;
        std::iter::once(0.0)
            .chain(residual.iter().map(|&r| {
                total += f(r);
                total
            }))
            .collect()
    };
    let (first, second) = (sums(&|r| r), sums(&|r| r * r));
    let variance = |a: usize, b: usize| {
        let len = (b - a) as f64;
        let mean = (first[b] - first[a]) / len;
        ((second[b] - second[a]) / len - mean * mean).max(1e-300)
    };
    let whole = variance(0, n).ln();
    let best = (margin..n - margin)
        .map(|k| {
            let (a, b) = (k as f64 / n as f64, (n - k) as f64 / n as f64);
            // A step of the mean has one variance on both sides; a step of the size has two.
            let mean_step = (a * variance(0, k) + b * variance(k, n)).ln();
            let size_step = a * variance(0, k).ln() + b * variance(k, n).ln();
            (k, whole - mean_step.min(size_step))
        })
        .max_by(|p, q| p.1.total_cmp(&q.1))?;
    let (k, drop) = best;
    if drop < settings.jump_drop {
        return None;
    }
    let mean = |a: usize, b: usize| (first[b] - first[a]) / (b - a) as f64;
    let rms = |a: usize, b: usize| ((second[b] - second[a]) / (b - a) as f64).sqrt();
    Some(Jump {
        time_s: start_s + k as f64 * row_s,
        before: mean(0, k),
        after: mean(k, n),
        rms_before: rms(0, k),
        rms_after: rms(k, n),
    })
}
