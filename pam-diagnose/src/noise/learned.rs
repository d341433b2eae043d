//! Noise from what a flexible model cannot learn.

use super::Noise;
use super::autoregression::{Autoregression, autocovariance};
use super::covariance::Covariances;
use super::unseen::unseen_levels;
use crate::fit::{Hypothesis, Problem, dot};
use crate::residual::flexible::{FeatureRows, FlexibleModel};
use crate::search::Candidates;
use crate::settings::NoiseSettings;

impl Noise {
    /// The noise beside a fitted hypothesis: what a flexible model without names
    /// ([`FlexibleModel`]), learned from the same rows, leaves of its residual.
    ///
    /// The degrees of freedom that the flexible model has used are given back, and the errors that the model is known to make join with
    /// their covariances. Channel by channel, the part that goes with the channels before it is taken out by least squares, and the
    /// rest is an [`Autoregression`] with one correlation for all experiments and a size for each. `None` if the simulation
    /// fails.
    #[must_use]
    pub fn learned<C: Candidates + ?Sized>(
        problem: &Problem<'_, C>,
        hypothesis: &Hypothesis,
        prior: &NoisePrior,
    ) -> Option<Self> {
        let rows = FeatureRows::gather(problem, hypothesis)?;
        let (experiments, settings) = (&problem.experiments, problem.settings);
        let models = rows.models(&settings.verdict)?;
        let mut noise = Self::of_rows((&rows, &models), experiments, prior, &settings.noise)?;
        if problem.blocks() < settings.rejection.fewest_blocks {
            let levels = unseen_levels(&rows, experiments, prior, settings);
            noise.unseen_levels = levels.unwrap_or_default();
        }
        Some(noise)
    }

    /// The noise of rows with their flexible models, each range of them of an experiment of the system; `None` without rows.
    pub(super) fn of_rows(
        (rows, models): (&FeatureRows, &[FlexibleModel]),
        experiments: &[usize],
        prior: &NoisePrior,
        settings: &NoiseSettings,
    ) -> Option<Self> {
        let left = rows.left(models);
        let n = rows.len() as f64;
        let count = left.len();
        let mut shared: Vec<Vec<f64>> = Vec::new();
        // What each channel has of its own, the multiples of the channels that it is, and the factor of its covariances.
        let mut own: Vec<(Vec<f64>, Vec<f64>, f64)> = Vec::new();
        let (mut channels, mut levels, mut freedoms) = (Vec::new(), Vec::new(), Vec::new());
        let mut relative = vec![Vec::new(); 1 + experiments.iter().max().copied()?];
        let known = &prior.discrepancy.covariances;
        for (c, (mut left, model)) in left.into_iter().zip(models).enumerate() {
            // A steady offset or a drift of one recording is no noise.
            rows.experiments.iter().for_each(|r| detrend(&mut left[r.clone()]));
            let mut rest = winsorised(left, settings.largest_deviations);
            // At least a row for every row that the flexible model may have used up.
            let used = model.used_rows + c as f64 + 2.0 * rows.experiments.len() as f64;
            let freedom = (n - used).max(settings.least_freedom * n);
            // Scales the sample variance to the given standard deviation or, without one, corrects it for the degrees of freedom
            // that the flexible model has used.
            let whole = dot(&rest, &rest);
            let given = prior.given.get(c).copied().flatten().filter(|_| whole > 0.0);
            let factor = given.map_or(n / freedom, |d| d * d * n / whole);
            freedoms.push(if given.is_some() { f64::INFINITY } else { freedom });
            // Gram–Schmidt on the sum of noise and discrepancy: the parts that the preceding channels do not predict are uncorrelated.
            let mut weights = vec![0.0; count];
            weights[c] = 1.0;
            for (other, of_other, factor) in &own {
                let both = |rows: &[f64], weights: &[f64]| {
                    let known = known.of_sums(weights, of_other).first().copied();
                    factor * dot(rows, other) / n + known.unwrap_or(0.0)
                };
                let size = both(other, of_other);
                let share = if size > 0.0 { both(&rest, &weights) / size } else { 0.0 };
                rest.iter_mut().zip(other).for_each(|(r, o)| *r -= share * o);
                weights.iter_mut().zip(of_other).for_each(|(w, o)| *w -= share * o);
            }
            shared.push(weights[..c].iter().map(|w| -w).collect());
            let series: Vec<&[f64]> = rows.experiments.iter().map(|r| &rest[r.clone()]).collect();
            let shortest = series.iter().map(|s| s.len()).min()?;
            let order = settings.order.min(shortest / settings.rows_per_order);
            let mut gamma = autocovariance(&series, order);
            gamma.iter_mut().for_each(|g| *g *= factor);
            let variance = gamma[0];
            let known = known.of_sum(&weights);
            gamma.iter_mut().zip(&known).for_each(|(g, known)| *g += known);
            let share = 1.0 - variance / gamma[0].max(f64::MIN_POSITIVE);
            let level = prior.discrepancy.levels.get(c).copied().unwrap_or(1.0);
            levels.push(share.clamp(0.0, 1.0).min(level));
            let learned = Autoregression::of_autocovariance(&gamma, n);
            let deviation = learned.deviation().max(prior.least[c]);
            let learned = learned.scaled_to(deviation);
            for (&e, own) in experiments.iter().zip(&series) {
                relative[e].push(relative_size(own, variance, factor, &learned, settings));
            }
            channels.push(learned);
            own.push((rest, weights, factor));
        }
        let mut discrepancy = known.deviations();
        discrepancy.resize(count, 0.0);
        let discrepancy_levels = levels;
        Some(Self {
            channels,
            shared,
            relative,
            discrepancy,
            discrepancy_levels,
            freedom: freedoms,
            unseen_levels: Vec::new(),
        })
    }
}

/// Knowledge of the noise before it is learned.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NoisePrior {
    /// No channel has a smaller standard deviation.
    pub least: Vec<f64>,
    /// The errors that the model itself makes.
    pub discrepancy: Discrepancy,
    /// Standard deviations that are known of the noise of each channel, beside the discrepancy; only its correlation is
    /// learned then. Empty, or none for a channel, where the size is learned as well.
    pub given: Vec<Option<f64>>,
}

impl NoisePrior {
    /// Channels with at least this noise.
    #[must_use]
    pub fn at_least(least: Vec<f64>) -> Self {
        Self { least, ..Self::default() }
    }
}

/// The errors that a model itself makes: its discrepancy (Kennedy and O'Hagan 2001).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Discrepancy {
    /// Their covariances; empty without any.
    pub covariances: Covariances,
    /// For each channel the mean square of the whitened residual that recordings without a fault have beside it. An autoregression of a
    /// few rows cannot tell a slow error from the noise that it joins, so that this may be far less than 1. Empty where no such
    /// recordings are known: then it is taken to be 1.
    pub levels: Vec<f64>,
}

impl Discrepancy {
    /// Adds errors of other recordings, with the levels that those have.
    pub fn add(&mut self, other: &Self) {
        self.covariances.add(&other.covariances, 1.0);
        self.levels.clone_from(&other.levels);
    }
}

/// The errors of all channels that go with the motion.
pub(crate) struct MotionErrors {
    /// Root mean square of the whole residual of each channel.
    pub(crate) rms: Vec<f64>,
    /// Covariances of the part of the residual that the flexible model predicts.
    pub(crate) covariances: Covariances,
}

impl MotionErrors {
    /// The means over recordings; `None` without any.
    pub(crate) fn means(recordings: &[Self]) -> Option<Self> {
        let share = 1.0 / recordings.len() as f64;
        let mut covariances = Covariances::default();
        let mut squares = vec![0.0; recordings.first()?.rms.len()];
        for own in recordings {
            covariances.add(&own.covariances, share);
            squares.iter_mut().zip(&own.rms).for_each(|(s, rms)| *s += share * rms * rms);
        }
        Some(Self { rms: squares.into_iter().map(f64::sqrt).collect(), covariances })
    }
}

impl<C: Candidates + ?Sized> Problem<'_, C> {
    /// The errors of a fitted hypothesis that go with the motion; `None` if it cannot be simulated.
    pub(crate) fn motion_errors(&self, hypothesis: &Hypothesis) -> Option<MotionErrors> {
        let rows = FeatureRows::gather(self, hypothesis)?;
        let left = rows.left(&rows.models(&self.settings.verdict)?);
        let learned = |(residual, left): (&Vec<f64>, Vec<f64>)| -> Vec<f64> {
            residual.iter().zip(&left).map(|(r, l)| r - l).collect()
        };
        let learned: Vec<Vec<f64>> = rows.residuals.iter().zip(left).map(learned).collect();
        let series: Vec<Vec<&[f64]>> = learned
            .iter()
            .map(|channel| rows.experiments.iter().map(|r| &channel[r.clone()]).collect())
            .collect();
        let covariances = Covariances::of_rows(&series, self.settings.noise.order);
        let rms = rows.residuals.iter().map(|r| pam_numerics::statistics::root_mean_square(r));
        Some(MotionErrors { rms: rms.collect(), covariances })
    }
}

/// Takes the straight line out of rows that fits them best.
fn detrend(rows: &mut [f64]) {
    let n = rows.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let mean = rows.iter().sum::<f64>() / n.max(1.0);
    let at = |k: usize| k as f64 - middle;
    let spread: f64 = (0..rows.len()).map(|k| at(k) * at(k)).sum();
    let slope = rows.iter().enumerate().map(|(k, r)| at(k) * r).sum::<f64>() / spread.max(1.0);
    rows.iter_mut().enumerate().for_each(|(k, r)| *r -= mean + slope * at(k));
}

/// Limits the size of outliers to a multiple of the standard deviation that the median of the sizes stands for.
fn winsorised(mut rows: Vec<f64>, largest: f64) -> Vec<f64> {
    let sizes: Vec<f64> = rows.iter().map(|r| r.abs()).collect();
    let most = largest * pam_numerics::statistics::median(&sizes) / 0.6745;
    if most > 0.0 {
        rows.iter_mut().for_each(|r| *r = r.clamp(-most, most));
    }
    rows
}

/// The size of one experiment's noise over the common one: its variance, drawn towards the common one by as many
/// observations as [`relative_observations`](NoiseSettings::relative_observations).
fn relative_size(
    own: &[f64],
    variance: f64,
    factor: f64,
    noise: &Autoregression,
    settings: &NoiseSettings,
) -> f64 {
    if variance <= 0.0 {
        return 1.0;
    }
    let observations = own.len() as f64 / noise.correlated_rows();
    let ratio = factor * dot(own, own) / own.len().max(1) as f64 / variance;
    let prior = settings.relative_observations;
    ((observations * ratio + prior) / (observations + prior)).sqrt()
}
