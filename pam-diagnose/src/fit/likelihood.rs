//! Errors by channel, and the likelihood in which hypotheses compete.

/// Squared errors of the fitted channels, whitened: in units of the noise.
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

    /// Minus two times the log-likelihood per row, `Σ_c g(MSE_c)` up to a constant, for residuals in units of the noise.
    ///
    /// `g(m) = m − 1` at and below the noise: its size is known. `g(m) = ln m` above it: the error is that of a model that
    /// is not right, of unknown variance (the likelihood with the variance at its maximum).
    #[must_use]
    pub fn deviance(&self) -> f64 {
        let of = |m: f64| if m > 1.0 { m.ln() } else { m - 1.0 };
        // Without rows there is nothing to be likely.
        if self.rows == 0 { 0.0 } else { self.mean().into_iter().map(of).sum() }
    }

    /// As [`deviance`](Self::deviance), but a mean square counts as at least `least`, the
    /// [level of the model's own errors](crate::noise::Noise::discrepancy_levels): these repeat with the motion, so a smaller
    /// residual is no further evidence.
    #[must_use]
    pub fn deviance_above(&self, least: &[f64]) -> f64 {
        let bounded = self.sums.iter().zip(least).map(|(s, least)| s.max(least * self.rows as f64));
        Self { sums: bounded.collect(), rows: self.rows }.deviance()
    }

    /// Normalised χ², the mean of `MSE_c` over the channels: 1 for errors at the level of the noise.
    #[must_use]
    pub fn chi_square(&self) -> f64 {
        self.mean().iter().sum::<f64>() / self.sums.len().max(1) as f64
    }
}
