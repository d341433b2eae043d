//! Errors by channel, and the likelihood in which hypotheses compete.

/// Squared errors of the fitted channels.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ChannelErrors {
    /// Sum of squared errors of each channel.
    pub sums: Vec<f64>,
    /// Rows behind each sum.
    pub rows: usize,
}

impl ChannelErrors {
    /// Mean squared errors.
    #[must_use]
    pub fn mean(&self) -> Vec<f64> {
        self.sums.iter().map(|s| s / self.rows.max(1) as f64).collect()
    }

    /// Both sets of rows together.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        if self.sums.is_empty() {
            return other.clone();
        }
        let mut sum = self.clone();
        sum.sums.iter_mut().zip(&other.sums).for_each(|(a, b)| *a += b);
        sum.rows += other.rows;
        sum
    }

    /// Minus two times the log-likelihood per row for errors of unknown variance in each channel, but not below the
    /// noise: `Σ_c ln(MSE_c + σ_c²)`, up to a constant.
    #[must_use]
    pub fn deviance(&self, noise: &[f64]) -> f64 {
        let sum = self.mean().iter().zip(noise).map(|(m, f)| (m + f * f).ln()).sum();
        // Without rows there is nothing to be likely.
        if self.rows == 0 { 0.0 } else { sum }
    }

    /// Normalised χ², the mean of `MSE_c / σ_c²` over the channels: 1 for errors at the level of the noise.
    #[must_use]
    pub fn chi_square(&self, noise: &[f64]) -> f64 {
        let sum: f64 = self.mean().iter().zip(noise).map(|(m, f)| m / (f * f)).sum();
        sum / noise.len().max(1) as f64
    }
}
