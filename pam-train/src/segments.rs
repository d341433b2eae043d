//! Stretches of a recording with one excitation frequency.
//!
//! The frequency is read from the measured force: cycles run from one rising zero crossing to the
//! next (about the force's mean, with a dead band against noise), and neighbouring cycles of similar
//! period form a segment.

use std::ops::Range;

/// Periods that differ by less than this factor belong together.
const SAME_PERIOD: f64 = 1.25;
/// More runs of different period than this, and the force is not periodic.
const MOST_SEGMENTS: usize = 12;

/// A stretch of one excitation frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct Segment {
    /// Samples of the recording.
    pub range: Range<usize>,
    /// Excitation frequency, Hz; `None` where the force is not periodic.
    pub frequency_hz: Option<f64>,
    /// Number of full cycles.
    pub cycles: usize,
}

impl Segment {
    /// The frequency in words.
    #[must_use]
    pub fn label(&self) -> String {
        match self.frequency_hz {
            Some(f) => format!("{} Hz", round_significant(f, 3)),
            None => "not periodic".into(),
        }
    }
}

fn round_significant(value: f64, digits: i32) -> f64 {
    let scale = 10.0_f64.powi(digits - 1 - value.abs().log10().floor() as i32);
    (value * scale).round() / scale
}

/// A run of cycles: samples of its first and last crossing and its number of cycles.
#[derive(Debug, Clone, Copy)]
struct CycleRun {
    from: usize,
    to: usize,
    cycles: usize,
}

impl CycleRun {
    fn period(&self, time_s: &[f64]) -> f64 {
        (time_s[self.to] - time_s[self.from]) / self.cycles as f64
    }
}

/// Splits a recording into segments of one excitation frequency. The segments cover all samples.
#[must_use]
pub fn frequency_segments(time_s: &[f64], force: &[f64]) -> Vec<Segment> {
    let n = time_s.len();
    let crossings = rising_crossings(force);
    let runs = merge_strays(group_cycles(&crossings, time_s), time_s);
    if runs.is_empty() || runs.len() > MOST_SEGMENTS {
        return vec![Segment { range: 0..n, frequency_hz: None, cycles: 0 }];
    }
    let last = runs.len() - 1;
    runs.iter()
        .enumerate()
        .map(|(i, run)| Segment {
            range: if i == 0 { 0 } else { run.from }..if i == last { n } else { runs[i + 1].from },
            frequency_hz: Some(1.0 / run.period(time_s)),
            cycles: run.cycles,
        })
        .collect()
}

/// Samples at which the force rises through its mean and goes on past the dead band.
fn rising_crossings(force: &[f64]) -> Vec<usize> {
    let n = force.len() as f64;
    let mean = force.iter().sum::<f64>() / n;
    let rms = (force.iter().map(|f| (f - mean).powi(2)).sum::<f64>() / n).sqrt();
    let band = 0.3 * rms;
    let mut crossings = Vec::new();
    let (mut was_low, mut candidate) = (false, 0);
    for (i, f) in force.iter().map(|f| f - mean).enumerate() {
        if f < -band {
            was_low = true;
        }
        if f <= 0.0 {
            candidate = i + 1;
        }
        if was_low && f > band {
            crossings.push(candidate);
            was_low = false;
        }
    }
    crossings
}

fn group_cycles(crossings: &[usize], time_s: &[f64]) -> Vec<CycleRun> {
    let mut runs: Vec<CycleRun> = Vec::new();
    for pair in crossings.windows(2) {
        let cycle = CycleRun { from: pair[0], to: pair[1], cycles: 1 };
        match runs.last_mut() {
            Some(run) if similar(run.period(time_s), cycle.period(time_s)) => {
                run.to = cycle.to;
                run.cycles += 1;
            }
            _ => runs.push(cycle),
        }
    }
    runs
}

fn similar(a: f64, b: f64) -> bool {
    let ratio = a / b;
    ratio < SAME_PERIOD && ratio > 1.0 / SAME_PERIOD
}

/// A single cycle beside longer runs is a change of frequency under way: it is not counted, and its
/// time goes to the segment before. Neighbours that have become alike are joined. Several single cycles
/// and nothing else are no periodic force: nothing is left.
fn merge_strays(mut runs: Vec<CycleRun>, time_s: &[f64]) -> Vec<CycleRun> {
    if runs.len() > 1 {
        runs.retain(|run| run.cycles > 1);
    }
    let mut joined: Vec<CycleRun> = Vec::new();
    for run in runs {
        match joined.last_mut() {
            Some(last) if similar(last.period(time_s), run.period(time_s)) => {
                last.cycles += run.cycles;
                last.to = run.to;
            }
            _ => joined.push(run),
        }
    }
    joined
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A fast sweep has no two cycles alike: it must not be given the frequency of one of them.
    #[test]
    fn a_sweep_without_two_like_cycles_is_not_periodic() {
        let time: Vec<f64> = (0..4000).map(|k| f64::from(k) * 1e-3).collect();
        // Each period is two thirds of the one before.
        let phase = |t: f64| (1.0 - t / 4.0).ln() / (2.0_f64 / 3.0).ln();
        let force: Vec<f64> = time[..3700].iter().map(|&t| (TAU * phase(t)).sin()).collect();
        assert!(rising_crossings(&force).len() >= 4);
        let segments = frequency_segments(&time[..3700], &force);
        assert_eq!(segments, [Segment { range: 0..3700, frequency_hz: None, cycles: 0 }]);
    }
}
