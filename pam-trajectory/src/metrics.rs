//! Goodness of fit.

use pam_data::{Channel, Recording};
use serde::{Deserialize, Serialize};

/// One value for each measured channel.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct PerChannel<T> {
    /// Displacement.
    pub x: T,
    /// Velocity.
    pub v: T,
    /// Flexor pressure.
    pub pf: T,
    /// Extensor pressure.
    pub pe: T,
}

impl<T> PerChannel<T> {
    /// The value of a channel, by reference.
    pub fn channel(&self, channel: Channel) -> &T {
        match channel {
            Channel::X => &self.x,
            Channel::V => &self.v,
            Channel::Pf => &self.pf,
            Channel::Pe => &self.pe,
        }
    }

    /// The value of a channel.
    pub fn get(&self, channel: Channel) -> T
    where
        T: Copy,
    {
        *self.channel(channel)
    }

    /// A value computed for each channel.
    pub fn from_fn(mut f: impl FnMut(Channel) -> T) -> Self {
        Self { x: f(Channel::X), v: f(Channel::V), pf: f(Channel::Pf), pe: f(Channel::Pe) }
    }
}

/// Spread of measurements, relative to their size, that rounding alone makes: such a channel is constant.
const ROUNDING: f64 = 1e-12;

/// Coefficient of determination, `R² = 1 − Σ (y − ŷ)² / Σ (y − ȳ)²`. NaN for fewer than two values
/// or measurements that are constant but for rounding; −∞ is possible for a diverging prediction.
#[must_use]
pub fn r2(measured: &[f64], predicted: &[f64]) -> f64 {
    if measured.len() < 2 {
        return f64::NAN;
    }
    let mean = measured.iter().sum::<f64>() / measured.len() as f64;
    let (mut residual, mut total) = (0.0, 0.0);
    for (m, p) in measured.iter().zip(predicted) {
        residual += (m - p) * (m - p);
        total += (m - mean) * (m - mean);
    }
    let largest = measured.iter().fold(0.0, |m: f64, y| m.max(y.abs()));
    let floor = measured.len() as f64 * (ROUNDING * largest).powi(2);
    if total > floor { 1.0 - residual / total } else { f64::NAN }
}

/// Mean squared distance from the mean; 0 if there are no values.
#[must_use]
pub fn variance(values: &[f64]) -> f64 {
    let share = 1.0 / values.len().max(1) as f64;
    let mean = share * values.iter().sum::<f64>();
    share * values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>()
}

/// Root-mean-square error, in the unit of the values; NaN if there are none.
#[must_use]
pub fn rmse(measured: &[f64], predicted: &[f64]) -> f64 {
    let sum: f64 = measured.iter().zip(predicted).map(|(m, p)| (m - p) * (m - p)).sum();
    (sum / measured.len() as f64).sqrt()
}

/// R² and RMSE of all channels. RMSE in mm, mm/s, kPa, kPa.
///
/// ```
/// use pam_trajectory::metrics::{r2, rmse};
///
/// let (measured, predicted) = ([0.0, 1.0, 2.0, 3.0], [0.1, 0.9, 2.1, 2.9]);
/// assert!((rmse(&measured, &predicted) - 0.1).abs() < 1e-12);
/// assert!((r2(&measured, &predicted) - (1.0 - 0.04 / 5.0)).abs() < 1e-12); // 1 − squared error / variance
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Scores {
    /// Coefficients of determination.
    pub r2: PerChannel<f64>,
    /// Root-mean-square errors.
    pub rmse: PerChannel<f64>,
}

impl Scores {
    /// Scores of `predicted` against `measured` over the samples `range`.
    #[must_use]
    pub fn over(
        measured: &Recording,
        predicted: &PerChannel<Vec<f64>>,
        range: std::ops::Range<usize>,
    ) -> Self {
        let score = |f: fn(&[f64], &[f64]) -> f64| {
            PerChannel::from_fn(|c| {
                f(&measured.channel(c)[range.clone()], &predicted.channel(c)[range.clone()])
            })
        };
        Self { r2: score(r2), rmse: score(rmse) }
    }

    /// Channel-wise mean of several scores; undefined values (NaN) do not take part.
    #[must_use]
    pub fn mean<'a>(scores: impl Iterator<Item = &'a Self> + Clone) -> Self {
        let mean = |value: &dyn Fn(&Self) -> f64| {
            let (sum, count) = scores
                .clone()
                .map(value)
                .filter(|v| !v.is_nan())
                .fold((0.0, 0_usize), |(s, n), v| (s + v, n + 1));
            if count == 0 { f64::NAN } else { sum / count as f64 }
        };
        Self {
            r2: PerChannel::from_fn(|c| mean(&|s: &Self| s.r2.get(c))),
            rmse: PerChannel::from_fn(|c| mean(&|s: &Self| s.rmse.get(c))),
        }
    }
}
