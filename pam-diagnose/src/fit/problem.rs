//! Trials with the rows that count.

use super::hypothesis::{Common, Hypothesis, Local};
use super::likelihood::{CHANNELS, ChannelErrors, Floors};
use pam_effects::simulation::{Base, Diverged, Trajectory, Trial, simulate};
use rayon::prelude::*;
use std::ops::Range;

/// How far uncertain numbers may be from their measured values (standard deviations).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerances {
    /// Relative, of the model's mass and deformation coefficient.
    pub model: f64,
    /// Lead of the recorded force before a held one, in its samples.
    pub lead_samples: f64,
    /// Displacement at the start, mm.
    pub start_mm: f64,
    /// Velocity at the start, mm/s.
    pub start_mm_s: f64,
    /// Relative, of the sealed masses.
    pub air: f64,
    /// Offset of the first pressure samples, kPa.
    pub offset_kpa: f64,
}

impl Default for Tolerances {
    fn default() -> Self {
        Self {
            model: 2e-3,
            lead_samples: 0.3,
            start_mm: 0.02,
            start_mm_s: 1.0,
            air: 2e-3,
            offset_kpa: 0.5,
        }
    }
}

impl Tolerances {
    /// Those of what recordings share, in order.
    pub(crate) fn common(&self) -> [f64; Common::LEN] {
        [self.model, self.model, self.lead_samples]
    }

    /// Those of one recording's own numbers, in order.
    pub(crate) fn local(&self) -> [f64; Local::LEN] {
        [self.start_mm, self.start_mm_s, self.air, self.air, self.offset_kpa, self.offset_kpa]
    }
}

/// Trials and the rows of each that take part.
#[derive(Debug, Clone)]
pub struct Problem<'a> {
    /// The trials.
    pub trials: Vec<&'a Trial>,
    /// Grid points of each trial that count, a whole number of rows.
    pub windows: Vec<Range<usize>>,
    /// The base model's numbers.
    pub base: Base<f64>,
    /// Where errors count as explained.
    pub floors: Floors,
    /// How far uncertain numbers may go.
    pub tolerances: Tolerances,
    /// Whether the steady offset of a pressure, up to twice its tolerance, is no error. Trials that only
    /// judge have no fitted offset, and their predictions start from one noisy sample.
    pub forgive_offsets: bool,
}

/// Grid points that are averaged into one row.
pub(crate) const POINTS_PER_ROW: usize = 5;

/// Length of a block of rows for clustered errors and for the bootstrap, s.
pub(crate) const BLOCK_S: f64 = 2.0;

impl<'a> Problem<'a> {
    /// All trials, from `burn_in_s` on.
    #[must_use]
    pub fn new(
        trials: impl IntoIterator<Item = &'a Trial>,
        base: Base<f64>,
        burn_in_s: f64,
        floors: Floors,
    ) -> Self {
        let trials: Vec<_> = trials.into_iter().collect();
        let windows = trials
            .iter()
            .map(|t| {
                let from = ((burn_in_s / t.record.step_s) as usize).min(t.record.points() / 2);
                whole_rows(from..t.record.points())
            })
            .collect();
        Self {
            trials,
            windows,
            base,
            floors,
            tolerances: Tolerances::default(),
            forgive_offsets: false,
        }
    }

    /// The same trials with other windows, each cut to whole rows.
    #[must_use]
    pub fn with_windows(&self, window: impl Fn(usize, &Trial) -> Range<usize>) -> Self {
        let mut other = self.clone();
        for (i, (w, t)) in other.windows.iter_mut().zip(&self.trials).enumerate() {
            *w = whole_rows(window(i, t));
        }
        other
    }

    /// Rows of a trial.
    pub(crate) fn rows(&self, trial: usize) -> usize {
        self.windows[trial].len() / POINTS_PER_ROW
    }

    /// Rows in a block.
    pub(crate) fn rows_per_block(&self, trial: usize) -> usize {
        let row_s = self.trials[trial].record.step_s * POINTS_PER_ROW as f64;
        ((BLOCK_S / row_s).round() as usize).max(1)
    }

    /// Number of trials.
    #[must_use]
    pub fn len(&self) -> usize {
        self.trials.len()
    }

    /// Whether there are no trials.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.trials.is_empty()
    }

    /// The simulated channels of a trial.
    ///
    /// # Errors
    /// [`Diverged`].
    pub fn simulate(
        &self,
        hypothesis: &Hypothesis<'_>,
        trial: usize,
        out: &mut Trajectory<f64>,
    ) -> Result<(), Diverged> {
        simulate(
            self.trials[trial],
            &self.base,
            &hypothesis.effects,
            &hypothesis.values,
            &hypothesis.nuisances(trial),
            out,
        )?;
        let offsets = hypothesis.locals[trial].offset_kpa;
        for (channel, offset) in out.channels[2..].iter_mut().zip(offsets) {
            if offset != 0.0 {
                channel.iter_mut().for_each(|p| *p += offset);
            }
        }
        Ok(())
    }

    /// Residuals (measured minus simulated, row means) of the fitted channels of a trial.
    ///
    /// # Errors
    /// [`Diverged`].
    pub fn residuals(
        &self,
        hypothesis: &Hypothesis<'_>,
        trial: usize,
    ) -> Result<[Vec<f64>; 3], Diverged> {
        let mut out = Trajectory::default();
        self.simulate(hypothesis, trial, &mut out)?;
        let (t, window) = (self.trials[trial], self.windows[trial].clone());
        Ok(CHANNELS.map(|c| row_means(&t.record.measured[c], &out.channels[c], window.clone())))
    }

    /// Errors of all trials together.
    ///
    /// # Errors
    /// [`Diverged`] of the first trial that diverges.
    pub fn errors(&self, hypothesis: &Hypothesis<'_>) -> Result<ChannelErrors, Diverged> {
        let each: Result<Vec<ChannelErrors>, Diverged> = (0..self.len())
            .into_par_iter()
            .map(|i| {
                let mut residuals = self.residuals(hypothesis, i)?;
                if self.forgive_offsets {
                    let most = 2.0 * self.tolerances.offset_kpa;
                    for r in &mut residuals[1..] {
                        let mean = r.iter().sum::<f64>() / r.len().max(1) as f64;
                        r.iter_mut().for_each(|v| *v -= mean.clamp(-most, most));
                    }
                }
                let rows = residuals[0].len();
                Ok(ChannelErrors { sums: residuals.map(|r| r.iter().map(|v| v * v).sum()), rows })
            })
            .collect();
        Ok(each?.iter().fold(ChannelErrors::default(), |sum, e| sum.and(e)))
    }
}

fn whole_rows(range: Range<usize>) -> Range<usize> {
    let rows = range.len() / POINTS_PER_ROW;
    range.start..range.start + rows * POINTS_PER_ROW
}

/// Means of `measured − simulated` over each row of a window.
pub(crate) fn row_means(measured: &[f64], simulated: &[f64], window: Range<usize>) -> Vec<f64> {
    let pairs = measured[window.clone()].chunks_exact(POINTS_PER_ROW);
    pairs
        .zip(simulated[window].chunks_exact(POINTS_PER_ROW))
        .map(|(m, s)| {
            let sum: f64 = m.iter().zip(s).map(|(m, s)| m - s).sum();
            sum / POINTS_PER_ROW as f64
        })
        .collect()
}
