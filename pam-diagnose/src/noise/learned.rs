//! Noise from what a flexible model cannot learn.

use super::Noise;
use super::autoregression::{Autoregression, autocovariance};
use crate::fit::{Hypothesis, Problem, dot};
use crate::residual::flexible::{FeatureRows, left_of_itself};
use crate::search::Candidates;
use crate::settings::NoiseSettings;

impl Noise {
    /// The noise beside a fitted hypothesis: what a flexible model without names
    /// ([`FlexibleModel`](crate::residual::FlexibleModel)), learned from the same rows, leaves of its residual.
    ///
    /// Channel by channel, the part that goes with the channels before it is taken out by least squares, and the rest is an
    /// [`Autoregression`] with one correlation for all experiments and a size for each. The degrees of freedom that the
    /// flexible model has used are given back, and the errors that the model is known to make join. `None` if the simulation
    /// fails.
    #[must_use]
    pub fn learned<C: Candidates + ?Sized>(
        problem: &Problem<'_, C>,
        hypothesis: &Hypothesis,
        prior: &NoisePrior,
    ) -> Option<Self> {
        let settings = &problem.settings.noise;
        let rows = FeatureRows::gather(problem, hypothesis)?;
        let left = left_of_itself(&rows, &problem.settings.verdict)?;
        let n = rows.len() as f64;
        let mut shared: Vec<Vec<f64>> = Vec::new();
        let mut own: Vec<Vec<f64>> = Vec::new();
        let (mut channels, mut discrepancy, mut freedoms) = (Vec::new(), Vec::new(), Vec::new());
        let mut relative = vec![Vec::new(); 1 + problem.experiments.iter().max().copied()?];
        for (c, (left, used_rows)) in left.into_iter().enumerate() {
            // A steady offset or a drift of one recording is no noise.
            let mut left = left;
            rows.experiments.iter().for_each(|r| detrend(&mut left[r.clone()]));
            let left = winsorised(left, settings.largest_deviations);
            // Gram–Schmidt: what is left of the channels before is not correlated among each other.
            let whole = dot(&left, &left);
            let mut rest = left;
            let mut by_own = vec![0.0; c];
            for (d, other) in own.iter().enumerate() {
                let size = dot(other, other);
                by_own[d] = if size > 0.0 { dot(&rest, other) / size } else { 0.0 };
                rest.iter_mut().zip(other).for_each(|(r, o)| *r -= by_own[d] * o);
            }
            shared.push(in_channels(&by_own, &shared));
            // At least a row for every row that the flexible model may have used up.
            let used = used_rows + c as f64 + 2.0 * rows.experiments.len() as f64;
            let freedom = (n - used).max(settings.least_freedom * n);
            let series: Vec<&[f64]> = rows.experiments.iter().map(|r| &rest[r.clone()]).collect();
            let shortest = series.iter().map(|s| s.len()).min()?;
            let order = settings.order.min(shortest / settings.rows_per_order);
            let mut gamma = autocovariance(&series, order);
            // A size that is given, or what the data show with the degrees of freedom that the flexible model has used.
            let given = prior.given.get(c).copied().flatten().filter(|_| gamma[0] > 0.0);
            let own_share = dot(&rest, &rest) / whole.max(f64::MIN_POSITIVE);
            let factor = given.map_or(n / freedom, |d| own_share * d * d / gamma[0]);
            gamma.iter_mut().for_each(|g| *g *= factor);
            let variance = gamma[0];
            let known = prior.discrepancy.get(c).map_or(&[][..], Vec::as_slice);
            gamma.iter_mut().zip(known).for_each(|(g, known)| *g += known);
            freedoms.push(if given.is_some() { f64::INFINITY } else { freedom });
            discrepancy.push(known.first().map_or(0.0, |variance| variance.max(0.0).sqrt()));
            let learned = Autoregression::of_autocovariance(&gamma, n);
            let deviation = learned.deviation().max(prior.least[c]);
            let learned = learned.scaled_to(deviation);
            for (&e, own) in problem.experiments.iter().zip(&series) {
                relative[e].push(relative_size(own, variance, factor, &learned, settings));
            }
            channels.push(learned);
            own.push(rest);
        }
        Some(Self { channels, shared, relative, discrepancy, freedom: freedoms })
    }
}

/// Knowledge of the noise before it is learned.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NoisePrior {
    /// No channel has a smaller standard deviation.
    pub least: Vec<f64>,
    /// Autocovariances of the errors that the model itself makes in each channel, at the lags 0, 1, …: its discrepancy
    /// (Kennedy and O'Hagan 2001). Empty without any.
    pub discrepancy: Vec<Vec<f64>>,
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

    /// Adds a further discrepancy.
    pub(crate) fn add(&mut self, discrepancy: Vec<Vec<f64>>) {
        if self.discrepancy.is_empty() {
            self.discrepancy = discrepancy;
            return;
        }
        for (own, more) in self.discrepancy.iter_mut().zip(discrepancy) {
            own.resize(own.len().max(more.len()), 0.0);
            own.iter_mut().zip(more).for_each(|(o, m)| *o += m);
        }
    }
}

/// The error of one channel that goes with the motion.
pub(crate) struct MotionError {
    /// Root mean square of the whole residual.
    pub(crate) rms: f64,
    /// Autocovariance of what a flexible model learns of it.
    pub(crate) autocovariance: Vec<f64>,
}

impl MotionError {
    /// The means over recordings, each with its channels; `None` without any.
    pub(crate) fn means(recordings: Vec<Vec<Self>>) -> Option<Vec<Self>> {
        let count = recordings.len() as f64;
        let mut all = recordings.into_iter();
        let mut sums = all.next()?;
        sums.iter_mut().for_each(|s| s.rms *= s.rms);
        for recording in all {
            for (sum, own) in sums.iter_mut().zip(recording) {
                sum.rms += own.rms * own.rms;
                let longest = sum.autocovariance.len().max(own.autocovariance.len());
                sum.autocovariance.resize(longest, 0.0);
                let pairs = sum.autocovariance.iter_mut().zip(&own.autocovariance);
                pairs.for_each(|(s, o)| *s += o);
            }
        }
        for sum in &mut sums {
            sum.rms = (sum.rms / count).sqrt();
            sum.autocovariance.iter_mut().for_each(|g| *g /= count);
        }
        Some(sums)
    }
}

impl<C: Candidates + ?Sized> Problem<'_, C> {
    /// The errors of a fitted hypothesis that go with the motion, channel by channel; `None` if it cannot be simulated.
    pub(crate) fn motion_errors(&self, hypothesis: &Hypothesis) -> Option<Vec<MotionError>> {
        let rows = FeatureRows::gather(self, hypothesis)?;
        let left = left_of_itself(&rows, &self.settings.verdict)?;
        let of_channel = |(residual, (left, _)): (&Vec<f64>, (Vec<f64>, f64))| {
            let learned: Vec<f64> = residual.iter().zip(&left).map(|(r, l)| r - l).collect();
            let series: Vec<&[f64]> =
                rows.experiments.iter().map(|r| &learned[r.clone()]).collect();
            let order = self.settings.noise.order;
            MotionError {
                rms: pam_numerics::statistics::root_mean_square(residual),
                autocovariance: autocovariance(&series, order),
            }
        };
        Some(rows.residuals.iter().zip(left).map(of_channel).collect())
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

/// Multiples of the channels themselves from multiples of what they have of their own.
fn in_channels(by_own: &[f64], shared: &[Vec<f64>]) -> Vec<f64> {
    let mut of_channels = by_own.to_vec();
    for (d, share) in by_own.iter().enumerate() {
        for (k, other) in shared[d].iter().enumerate() {
            of_channels[k] -= share * other;
        }
    }
    of_channels
}

/// The size of one experiment's noise over the common one: its variance, drawn towards the common one by as many
/// observations as [`relative_observations`](NoiseSettings::relative_observations).
fn relative_size(
    own: &[f64],
    variance: f64,
    correction: f64,
    noise: &Autoregression,
    settings: &NoiseSettings,
) -> f64 {
    if variance <= 0.0 {
        return 1.0;
    }
    let observations = own.len() as f64 / noise.correlated_rows();
    let ratio = correction * dot(own, own) / own.len().max(1) as f64 / variance;
    let prior = settings.relative_observations;
    ((observations * ratio + prior) / (observations + prior)).sqrt()
}
