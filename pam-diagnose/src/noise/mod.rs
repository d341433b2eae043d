//! The residual of a correct model: the noise of each channel, its correlation in time and between
//! channels.
//!
//! The residual of a right model holds more than the noise of the sensors. Noise of the *measured force* drives the
//! simulation and comes out as slow, correlated errors of all channels; quantisation, filters and interpolation colour it.
//! No list of instruments tells all of that, but the data do: what a flexible model cannot learn from the motion is noise
//! ([`Noise::learned`]). A fault, in contrast, repeats with the motion.
//!
//! All decisions of a diagnosis read *whitened* residuals ([`Noise::whitened`]): each channel less what the channels before
//! it and its own past predict of its noise, in units of the error of that prediction. Under a right model they are
//! independent and of unit variance, whatever the sampling rate, the filter and the colour of the noise, so that sums of
//! squares are likelihoods and rows are observations (Cochrane and Orcutt 1949; Box, Jenkins and Reinsel, *Time Series
//! Analysis*).

mod autoregression;
mod correlation;
mod covariance;
mod instruments;
mod learned;
mod unseen;

pub use autoregression::{Autoregression, autocovariance};
pub use correlation::correlated_rows;
pub use covariance::Covariances;
pub use instruments::{estimated_noise, moving_discrepancy, noise_deviation};
pub(crate) use learned::MotionErrors;
pub use learned::{Discrepancy, NoisePrior};
pub use unseen::UnseenLevel;

/// The noise of the rows of each fitted channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Noise {
    /// Noise of each channel.
    channels: Vec<Autoregression>,
    /// For each channel, the multiples of the noise of the channels before it that it contains.
    shared: Vec<Vec<f64>>,
    /// For each experiment of the system, the size of each channel's noise relative to `channels`; empty where it was not
    /// learned.
    relative: Vec<Vec<f64>>,
    /// Standard deviation of the errors that the model itself is known to make in each channel, part of `channels`.
    discrepancy: Vec<f64>,
    /// The mean square of the whitened residual of each channel that is due to them.
    discrepancy_levels: Vec<f64>,
    /// Degrees of freedom of the learned size of each channel: rows less those that the flexible model used up.
    freedom: Vec<f64>,
    /// The level of each channel in rows from which the noise was not learned; empty where it was learned from many rows.
    unseen_levels: Vec<UnseenLevel>,
}

impl Noise {
    /// White noise of known standard deviations, independent between the channels.
    #[must_use]
    pub fn white(deviations: &[f64]) -> Self {
        let channels: Vec<_> = deviations.iter().map(|d| Autoregression::white(*d)).collect();
        let shared = (0..channels.len()).map(|c| vec![0.0; c]).collect();
        let discrepancy = vec![0.0; channels.len()];
        let freedom = vec![f64::INFINITY; channels.len()];
        let discrepancy_levels = discrepancy.clone();
        let (relative, unseen_levels) = (Vec::new(), Vec::new());
        Self { channels, shared, relative, discrepancy, discrepancy_levels, freedom, unseen_levels }
    }

    /// Noise of known channels, independent between them.
    #[must_use]
    pub fn independent(channels: Vec<Autoregression>) -> Self {
        let none = Self::white(&vec![1.0; channels.len()]);
        Self { channels, ..none }
    }

    /// The same noise in all experiments, for recordings from which it was not learned.
    #[must_use]
    pub fn common(&self) -> Self {
        Self { relative: Vec::new(), ..self.clone() }
    }

    /// Number of channels.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels.len()
    }

    /// Standard deviation of the noise of a channel, with what it shares with other channels, in the channel's unit.
    #[must_use]
    pub fn deviation(&self, channel: usize) -> f64 {
        // Channels share noise with each other, but nothing of what each has of its own.
        let own = self.channels.iter().map(Autoregression::deviation);
        let parts = self.loadings(channel).into_iter().zip(own);
        parts.map(|(loading, own)| (loading * own).powi(2)).sum::<f64>().sqrt()
    }

    /// The multiples of the own noise of a channel and of those before it that the noise of the channel contains.
    fn loadings(&self, channel: usize) -> Vec<f64> {
        let mut all = vec![0.0; channel];
        for (d, share) in self.shared[channel].iter().enumerate() {
            for (sum, loading) in all.iter_mut().zip(self.loadings(d)) {
                *sum += share * loading;
            }
        }
        all.push(1.0);
        all
    }

    /// Standard deviation of the errors that the model itself is known to make in a channel, a part of the noise.
    #[must_use]
    pub fn discrepancy(&self, channel: usize) -> f64 {
        self.discrepancy[channel]
    }

    /// The mean square of the whitened residual of each channel that is due to the model's own errors: their share of the variance of
    /// the channel less those before it, or the [level](Discrepancy::levels) of recordings without a fault if that is less.
    #[must_use]
    pub fn discrepancy_levels(&self) -> &[f64] {
        &self.discrepancy_levels
    }

    /// Degrees of freedom of the learned size of a channel's noise; infinite where it is known.
    #[must_use]
    pub fn freedom(&self, channel: usize) -> f64 {
        self.freedom[channel]
    }

    /// The level of the noise of a channel in rows from which it was not learned.
    #[must_use]
    pub fn unseen_level(&self, channel: usize) -> UnseenLevel {
        self.unseen_levels.get(channel).copied().unwrap_or(UnseenLevel::KNOWN)
    }

    /// Standard deviations of all channels.
    #[must_use]
    pub fn deviations(&self) -> Vec<f64> {
        (0..self.channels()).map(|c| self.deviation(c)).collect()
    }

    /// The correlation of a channel's own noise.
    #[must_use]
    pub fn channel(&self, channel: usize) -> &Autoregression {
        &self.channels[channel]
    }

    /// So many rows of the noise of all channels; `normal` draws standard normal numbers.
    pub fn drawn(&self, rows: usize, mut normal: impl FnMut() -> f64) -> Vec<Vec<f64>> {
        let mut all: Vec<Vec<f64>> = Vec::new();
        for (channel, shared) in self.channels.iter().zip(&self.shared) {
            let mut own = channel.drawn(rows, &mut normal);
            for (share, other) in shared.iter().zip(&all) {
                own.iter_mut().zip(other).for_each(|(o, x)| *o += share * x);
            }
            all.push(own);
        }
        all
    }

    /// The rows of all channels of an experiment, whitened. An empty channel is zero.
    #[must_use]
    pub fn whitened(&self, experiment: usize, rows: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let relative = self.relative.get(experiment).filter(|r| !r.is_empty());
        (0..rows.len())
            .map(|c| {
                let mut own = rows[c].clone();
                for (share, other) in self.shared[c].iter().zip(rows) {
                    if *share != 0.0 && !other.is_empty() {
                        own.resize(other.len(), 0.0);
                        own.iter_mut().zip(other).for_each(|(o, x)| *o -= share * x);
                    }
                }
                let mut white = self.channels[c].whitened(&own);
                if let Some(relative) = relative {
                    white.iter_mut().for_each(|w| *w /= relative[c]);
                }
                white
            })
            .collect()
    }
}
