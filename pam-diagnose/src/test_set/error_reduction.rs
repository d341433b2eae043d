//! The error on the test set before and after the named causes.

use super::TestSet;
use crate::fit::{Hypothesis, Problem};
use crate::search::Candidates;
use pam_core::parallel;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};

/// One channel before and after, over all test recordings.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChannelReduction {
    /// Key of the channel.
    #[serde(skip)]
    pub key: String,
    /// Name of the channel with its unit.
    #[serde(skip)]
    pub label: String,
    /// Root-mean-square error before, in the channel's unit.
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
pub struct OverallReduction {
    /// `1 − √(Σ_c MSE_c,after/s_c² / Σ_c MSE_c,before/s_c²)`, with the variation `s_c` of each fitted channel.
    pub error_reduction: f64,
    /// 95 % interval.
    pub ci95: [f64; 2],
}

/// One recording, or one frequency of excitation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GroupReduction {
    /// Its name.
    pub name: String,
    /// Root-mean-square error of each channel before.
    pub rmse_before: Vec<f64>,
    /// After.
    pub rmse_after: Vec<f64>,
}

/// Errors before and after, with 95 % intervals by block bootstrap.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ErrorReduction {
    /// Each channel.
    #[serde(flatten, serialize_with = "by_key")]
    pub channels: Vec<ChannelReduction>,
    /// All channels.
    pub overall: OverallReduction,
    /// By frequency of excitation.
    pub by_frequency: Vec<GroupReduction>,
    /// By recording, that is by operating point.
    pub by_recording: Vec<GroupReduction>,
}

fn by_key<S: Serializer>(channels: &[ChannelReduction], to: S) -> Result<S::Ok, S::Error> {
    let mut map = to.serialize_map(Some(channels.len()))?;
    for channel in channels {
        map.serialize_entry(&channel.key, channel)?;
    }
    map.end()
}

/// Sums over one block of an experiment, channel by channel.
#[derive(Debug, Clone)]
struct Block {
    points: f64,
    before: Vec<f64>,
    after: Vec<f64>,
    total: Vec<f64>,
}

/// One excitation of an experiment, in blocks.
type Stratum = (String, Vec<Block>);

impl Block {
    fn zeros(channels: usize) -> Self {
        let zeros = vec![0.0; channels];
        Self { points: 0.0, before: zeros.clone(), after: zeros.clone(), total: zeros }
    }

    fn add(&mut self, other: &Self) {
        self.points += other.points;
        for c in 0..self.before.len() {
            self.before[c] += other.before[c];
            self.after[c] += other.after[c];
            self.total[c] += other.total[c];
        }
    }

    fn of<'b>(channels: usize, blocks: impl IntoIterator<Item = &'b Self>) -> Self {
        blocks.into_iter().fold(Self::zeros(channels), |mut sum, b| {
            sum.add(b);
            sum
        })
    }

    fn rmse(&self, sums: &[f64]) -> Vec<f64> {
        sums.iter().map(|s| (s / self.points.max(1.0)).sqrt()).collect()
    }

    /// The reduction over the fitted channels: a derivative of another channel is not counted twice.
    fn reduction(&self, fitted: &[usize]) -> f64 {
        let sum =
            |of: &[f64]| -> f64 { fitted.iter().map(|&c| of[c] / self.total[c].max(1e-300)).sum() };
        1.0 - (sum(&self.after) / sum(&self.before).max(1e-300)).sqrt()
    }

    fn group(&self, name: String) -> GroupReduction {
        let (rmse_before, rmse_after) = (self.rmse(&self.before), self.rmse(&self.after));
        GroupReduction { name, rmse_before, rmse_after }
    }
}

impl<C: Candidates + ?Sized> TestSet<'_, C> {
    /// The error reduction from one hypothesis to another, both with the nuisances of the test recordings at the prior mean. An experiment on
    /// which one of them cannot be simulated is left out.
    ///
    /// The bootstrap draws blocks with replacement, which keeps the correlation of errors inside them, and draws them
    /// separately for each excitation and recording: which excitation was run is not random. A short stretch of
    /// one excitation is divided into three blocks at least.
    #[must_use]
    pub fn error_reduction(
        &self,
        before: &Hypothesis,
        after: &Hypothesis,
        seed: u64,
    ) -> ErrorReduction {
        let problem = &self.problem;
        let outputs = problem.system.outputs();
        let channels = outputs.len();
        let fitted: Vec<usize> = (0..channels).filter(|&c| outputs[c].fitted).collect();
        let [before, after] =
            [before, after].map(|h| h.without_locals(problem.system, problem.len()));
        let experiments: Vec<(usize, Vec<Stratum>)> = parallel::map(problem.len(), |i| {
            let old = problem.simulate(&before, i).ok()?;
            let new = problem.simulate(&after, i).ok()?;
            Some((i, strata(problem, i, &old, &new)))
        })
        .into_iter()
        .flatten()
        .collect();
        let all: Vec<&Stratum> = experiments.iter().flat_map(|t| &t.1).collect();
        let whole = Block::of(channels, all.iter().flat_map(|s| &s.1));
        let resamples = problem.settings.intervals.resamples;
        let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x9e37_79b9_7f4a_7c15);
        let mut reductions: Vec<Vec<f64>> = (0..resamples)
            .map(|_| {
                let mut sum = Block::zeros(channels);
                for (_, blocks) in &all {
                    for _ in 0..blocks.len() {
                        sum.add(&blocks[random.random_range(0..blocks.len())]);
                    }
                }
                let (old, new) = (sum.rmse(&sum.before), sum.rmse(&sum.after));
                let mut out: Vec<f64> = old.iter().zip(&new).map(|(a, b)| a - b).collect();
                out.push(sum.reduction(&fitted));
                out
            })
            .collect();
        let mut interval = |k: usize| {
            reductions.sort_by(|a, b| a[k].total_cmp(&b[k]));
            let at = |share: f64| reductions[(share * (resamples - 1) as f64).round() as usize][k];
            [at(0.025), at(0.975)]
        };
        let (old, new) = (whole.rmse(&whole.before), whole.rmse(&whole.after));
        let r2 = |sum: f64, total: f64| if total > 0.0 { 1.0 - sum / total } else { f64::NAN };
        let reduction = |(c, o): (usize, &crate::search::OutputInfo)| ChannelReduction {
            key: o.key.clone(),
            label: format!("{} ({})", o.name, o.unit),
            rmse_before: old[c],
            rmse_after: new[c],
            r2_before: r2(whole.before[c], whole.total[c]),
            r2_after: r2(whole.after[c], whole.total[c]),
            ci95: interval(c),
        };
        let by_channel = outputs.iter().enumerate().map(reduction).collect();
        let overall = OverallReduction {
            error_reduction: whole.reduction(&fitted),
            ci95: interval(channels),
        };
        let mut frequencies: Vec<(String, Block)> = Vec::new();
        for (name, blocks) in &all {
            let sum = Block::of(channels, blocks);
            match frequencies.iter_mut().find(|f| f.0 == *name) {
                Some(known) => known.1.add(&sum),
                None => frequencies.push((name.clone(), sum)),
            }
        }
        let name = |i: usize| problem.system.name(problem.experiments[i]).to_owned();
        ErrorReduction {
            channels: by_channel,
            overall,
            by_frequency: frequencies.into_iter().map(|(name, b)| b.group(name)).collect(),
            by_recording: experiments
                .iter()
                .map(|(i, s)| Block::of(channels, s.iter().flat_map(|s| &s.1)).group(name(*i)))
                .collect(),
        }
    }
}

/// The excitations of an experiment, each in blocks.
fn strata<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    place: usize,
    old: &[Vec<f64>],
    new: &[Vec<f64>],
) -> Vec<Stratum> {
    let (e, window) = (problem.experiments[place], problem.windows[place].clone());
    let measured: Vec<&[f64]> = (0..old.len()).map(|c| problem.system.measured(e, c)).collect();
    let mean = |y: &&[f64]| y[window.clone()].iter().sum::<f64>() / window.len().max(1) as f64;
    let means: Vec<f64> = measured.iter().map(mean).collect();
    let sum = |points: std::ops::Range<usize>| {
        let mut block = Block { points: points.len() as f64, ..Block::zeros(means.len()) };
        for (c, mean) in means.iter().enumerate() {
            for k in points.clone() {
                let y = measured[c][k];
                block.before[c] += (y - old[c][k]).powi(2);
                block.after[c] += (y - new[c][k]).powi(2);
                block.total[c] += (y - mean).powi(2);
            }
        }
        block
    };
    let settings = &problem.settings.intervals;
    let points_per_row = problem.system.points_per_row();
    let longest = problem.rows_per_block(place) * points_per_row;
    let step_s = problem.row_s(place) / points_per_row as f64;
    let shortest = (settings.shortest_block_s / step_s.max(1e-300) * (1.0 + 1e-12)) as usize;
    let shortest = shortest.clamp(1, longest);
    problem
        .system
        .strata(e, window)
        .into_iter()
        .map(|(name, range)| {
            let (from, to) = (range.start, range.end);
            let len = ((to - from) / settings.stratum_blocks).clamp(shortest, longest);
            let blocks = (from..to).step_by(len).map(|at| sum(at..(at + len).min(to))).collect();
            (name, blocks)
        })
        .collect()
}
