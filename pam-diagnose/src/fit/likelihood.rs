//! Errors by channel, and the likelihood in which hypotheses compete.

use serde::Serialize;

/// Channels that take part in a fit, as indices into the state: x, P_f, P_e. The velocity is the
/// derivative of the displacement in every data format and carries nothing of its own.
pub const CHANNELS: [usize; 3] = [0, 2, 3];

/// Root-mean-square error below which a channel counts as explained, mm, kPa, kPa.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Floors(pub [f64; 3]);

/// Mean squared errors of the fitted channels.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ChannelErrors {
    /// Sums of squared errors of x, P_f, P_e.
    pub sums: [f64; 3],
    /// Rows behind each sum.
    pub rows: usize,
}

impl ChannelErrors {
    /// Mean squared errors.
    #[must_use]
    pub fn mean(&self) -> [f64; 3] {
        self.sums.map(|s| s / self.rows.max(1) as f64)
    }

    /// Both sets of rows together.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        let mut sums = self.sums;
        sums.iter_mut().zip(other.sums).for_each(|(a, b)| *a += b);
        Self { sums, rows: self.rows + other.rows }
    }

    /// Minus two times the log-likelihood a row for errors of unknown variance in each channel, down to
    /// the floors: `Σ_c ln(MSE_c + floor_c²)`, up to a constant.
    #[must_use]
    pub fn deviance(&self, floors: &Floors) -> f64 {
        deviance(&self.mean(), &floors.0)
    }

    /// Squared error in units of the floors, `Σ_c MSE_c / floor_c²`.
    #[must_use]
    pub fn in_floors(&self, floors: &Floors) -> f64 {
        self.mean().iter().zip(floors.0).map(|(m, f)| m / (f * f)).sum()
    }
}

/// `Σ_c ln(MSE_c + floor_c²)` for any number of channels.
pub(crate) fn deviance(mean_squares: &[f64], floors: &[f64]) -> f64 {
    mean_squares.iter().zip(floors).map(|(m, f)| (m + f * f).ln()).sum()
}
