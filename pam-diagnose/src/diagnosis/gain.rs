//! What naming gains, on recordings that took no part in it.

use super::sets::random;
use crate::fit::{BLOCK_S, Hypothesis, Problem};
use pam_data::Channel;
use pam_effects::simulation::Trajectory;
use pam_train::frequency_segments;
use rayon::prelude::*;
use serde::Serialize;

/// One channel before and after, over all held-out recordings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ChannelGain {
    /// Root mean square error before, in the channel's unit.
    pub rmse_before: f64,
    /// After.
    pub rmse_after: f64,
    /// Coefficient of determination before.
    pub r2_before: f64,
    /// After.
    pub r2_after: f64,
    /// 95 % interval of the reduction `rmse_before − rmse_after`.
    pub ci95: [f64; 2],
}

/// All channels together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct OverallGain {
    /// `1 − √(Σ_c MSE_c,after/s_c² / Σ_c MSE_c,before/s_c²)`, with `s_c` the variation of x, P_f, P_e.
    pub error_reduction: f64,
    /// 95 % interval.
    pub ci95: [f64; 2],
}

/// One recording, or one frequency of excitation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GroupGain {
    /// What it is.
    pub name: String,
    /// Root mean square errors of x, v, P_f, P_e before.
    pub rmse_before: [f64; 4],
    /// After.
    pub rmse_after: [f64; 4],
}

/// Errors before and after, with 95 % intervals by block bootstrap.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Gain {
    /// Displacement, mm.
    pub x: ChannelGain,
    /// Velocity, mm/s.
    pub v: ChannelGain,
    /// Flexor pressure, kPa.
    pub pf: ChannelGain,
    /// Extensor pressure, kPa.
    pub pe: ChannelGain,
    /// All channels.
    pub overall: OverallGain,
    /// By frequency of excitation.
    pub by_frequency: Vec<GroupGain>,
    /// By recording, that is by operating point.
    pub by_recording: Vec<GroupGain>,
}

/// Resamplings of the bootstrap.
const RESAMPLES: usize = 1000;

/// Sums over one block of a trial.
#[derive(Debug, Clone, Copy, Default)]
struct Block {
    points: f64,
    before: [f64; 4],
    after: [f64; 4],
    total: [f64; 4],
}

/// Fewest blocks of one frequency of one trial, and the shortest that a block may be for that, s.
const FEWEST: usize = 3;
const SHORTEST_BLOCK_S: f64 = 0.5;

/// One frequency of excitation in a trial, in blocks.
type Stratum = (String, Vec<Block>);

impl Block {
    fn add(&mut self, other: &Self) {
        self.points += other.points;
        for c in 0..4 {
            self.before[c] += other.before[c];
            self.after[c] += other.after[c];
            self.total[c] += other.total[c];
        }
    }

    fn of<'b>(blocks: impl IntoIterator<Item = &'b Self>) -> Self {
        blocks.into_iter().fold(Self::default(), |mut sum, b| {
            sum.add(b);
            sum
        })
    }

    fn rmse(&self, sums: [f64; 4]) -> [f64; 4] {
        sums.map(|s| (s / self.points.max(1.0)).sqrt())
    }

    fn reduction(&self) -> f64 {
        // The velocity is the displacement's derivative and is not counted twice.
        let sum = |of: &[f64; 4]| -> f64 {
            [0, 2, 3].iter().map(|&c| of[c] / self.total[c].max(1e-300)).sum()
        };
        1.0 - (sum(&self.after) / sum(&self.before).max(1e-300)).sqrt()
    }
}

impl Gain {
    /// The gain from one hypothesis to another on the rows of a problem. Both are simulated from the
    /// measured starts. A trial on which one of them diverges is left out.
    ///
    /// The bootstrap draws blocks of two seconds with replacement, which keeps the correlation of errors
    /// inside them, and draws them frequency by frequency and trial by trial: which excitation was run is no
    /// chance. A short stretch of one frequency is parted into three blocks at least.
    #[must_use]
    pub fn measure(
        problem: &Problem<'_>,
        before: &Hypothesis<'_>,
        after: &Hypothesis<'_>,
        seed: u64,
    ) -> Self {
        let trials: Vec<(usize, Vec<Stratum>)> = (0..problem.len())
            .into_par_iter()
            .filter_map(|i| {
                let (mut old, mut new) = (Trajectory::default(), Trajectory::default());
                problem.simulate(before, i, &mut old).ok()?;
                problem.simulate(after, i, &mut new).ok()?;
                Some((i, strata(problem, i, &old, &new)))
            })
            .collect();
        let all: Vec<&Stratum> = trials.iter().flat_map(|t| &t.1).collect();
        let whole = Block::of(all.iter().flat_map(|s| &s.1));
        let mut draw = random(seed);
        let mut reductions: Vec<[f64; 5]> = (0..RESAMPLES)
            .map(|_| {
                let mut sum = Block::default();
                for (_, blocks) in &all {
                    for _ in 0..blocks.len() {
                        sum.add(&blocks[draw(blocks.len())]);
                    }
                }
                let (old, new) = (sum.rmse(sum.before), sum.rmse(sum.after));
                let mut out = [0.0; 5];
                (0..4).for_each(|c| out[c] = old[c] - new[c]);
                out[4] = sum.reduction();
                out
            })
            .collect();
        let mut interval = |k: usize| {
            reductions.sort_by(|a, b| a[k].total_cmp(&b[k]));
            let at = |share: f64| reductions[(share * (RESAMPLES - 1) as f64).round() as usize][k];
            [at(0.025), at(0.975)]
        };
        let (old, new) = (whole.rmse(whole.before), whole.rmse(whole.after));
        let r2 = |sum: f64, total: f64| if total > 0.0 { 1.0 - sum / total } else { f64::NAN };
        let mut channel = |c: usize| ChannelGain {
            rmse_before: old[c],
            rmse_after: new[c],
            r2_before: r2(whole.before[c], whole.total[c]),
            r2_after: r2(whole.after[c], whole.total[c]),
            ci95: interval(c),
        };
        let (x, v, pf, pe) = (channel(0), channel(1), channel(2), channel(3));
        let overall = OverallGain { error_reduction: whole.reduction(), ci95: interval(4) };
        let group = |name: String, sum: &Block| GroupGain {
            name,
            rmse_before: sum.rmse(sum.before),
            rmse_after: sum.rmse(sum.after),
        };
        let by_recording = trials
            .iter()
            .map(|(i, strata)| {
                let sum = Block::of(strata.iter().flat_map(|s| &s.1));
                group(problem.trials[*i].record.source.name.clone(), &sum)
            })
            .collect();
        let mut frequencies: Vec<(String, Block)> = Vec::new();
        for (name, blocks) in &all {
            let sum = Block::of(blocks);
            match frequencies.iter_mut().find(|f| f.0 == *name) {
                Some(known) => known.1.add(&sum),
                None => frequencies.push((name.clone(), sum)),
            }
        }
        let by_frequency = frequencies.into_iter().map(|(name, b)| group(name, &b)).collect();
        Self { x, v, pf, pe, overall, by_frequency, by_recording }
    }

    /// A channel's gain.
    #[must_use]
    pub fn channel(&self, channel: Channel) -> &ChannelGain {
        match channel {
            Channel::X => &self.x,
            Channel::V => &self.v,
            Channel::Pf => &self.pf,
            Channel::Pe => &self.pe,
        }
    }
}

/// The frequencies of excitation of a trial, each in blocks.
fn strata(
    problem: &Problem<'_>,
    trial: usize,
    old: &Trajectory<f64>,
    new: &Trajectory<f64>,
) -> Vec<Stratum> {
    let t = problem.trials[trial];
    let window = problem.windows[trial].clone();
    let means = [0, 1, 2, 3].map(|c| {
        t.record.measured[c][window.clone()].iter().sum::<f64>() / window.len().max(1) as f64
    });
    let sum = |points: std::ops::Range<usize>| {
        let mut block = Block { points: points.len() as f64, ..Block::default() };
        for (c, mean) in means.iter().enumerate() {
            for k in points.clone() {
                let y = t.record.measured[c][k];
                block.before[c] += (y - old.channels[c][k]).powi(2);
                block.after[c] += (y - new.channels[c][k]).powi(2);
                block.total[c] += (y - mean).powi(2);
            }
        }
        block
    };
    let times: Vec<f64> = window.clone().map(|k| k as f64 * t.record.step_s).collect();
    let force: Vec<f64> = window.clone().map(|k| t.record.force.values_mn()[2 * k]).collect();
    let points = |time_s: f64| ((time_s / t.record.step_s) as usize).max(1);
    frequency_segments(&times, &force)
        .into_iter()
        .map(|s| {
            let (from, to) = (window.start + s.range.start, window.start + s.range.end);
            let len = ((to - from) / FEWEST).clamp(points(SHORTEST_BLOCK_S), points(BLOCK_S));
            let blocks = (from..to).step_by(len).map(|at| sum(at..(at + len).min(to))).collect();
            (s.label(), blocks)
        })
        .collect()
}
