//! Correlated noise of one channel, and the filter that makes it white.

/// A stationary Gaussian autoregression `e_k = Σ_j a_j e_{k−j} + s w_k` with white `w` of unit variance.
///
/// The predictors of all lower orders are kept, so that the first rows of a series, which have fewer predecessors, are
/// whitened exactly as well (Durbin 1960; Brockwell and Davis, *Time Series: Theory and Methods*, §5.2).
#[derive(Debug, Clone, PartialEq)]
pub struct Autoregression {
    /// The coefficients of the best linear predictor from `k` predecessors, for `k` from 0 to the order.
    predictors: Vec<Vec<f64>>,
    /// Standard deviation of the error of each predictor.
    deviations: Vec<f64>,
}

impl Autoregression {
    /// White noise.
    #[must_use]
    pub fn white(deviation: f64) -> Self {
        Self { predictors: vec![Vec::new()], deviations: vec![deviation] }
    }

    /// The autoregression with the autocovariances `γ_0, γ_1, …` (Yule–Walker equations by the recursion of Levinson
    /// and Durbin), of the order up to `γ.len() − 1` that minimises `n ln s² + k ln n` for `n` observations (Schwarz
    /// 1978).
    #[must_use]
    pub fn of_autocovariance(gamma: &[f64], observations: f64) -> Self {
        let variance = gamma.first().copied().unwrap_or(0.0);
        let mut all = Self::white(variance.max(f64::MIN_POSITIVE).sqrt());
        let mut left = variance;
        for k in 1..gamma.len() {
            let last = &all.predictors[k - 1];
            let known: f64 = last.iter().zip(gamma[1..k].iter().rev()).map(|(a, g)| a * g).sum();
            let reflection = (gamma[k] - known) / left;
            let share = 1.0 - reflection * reflection;
            // A share that is not positive is no autocovariance any more, but rounding.
            if !(reflection.is_finite() && share > LEAST_SHARE) {
                break;
            }
            let mut next: Vec<f64> =
                last.iter().zip(last.iter().rev()).map(|(a, b)| a - reflection * b).collect();
            next.push(reflection);
            left *= share;
            all.predictors.push(next);
            all.deviations.push(left.sqrt());
        }
        let n = observations.max(2.0);
        let criterion = |k: usize| 2.0 * n * all.deviations[k].ln() + k as f64 * n.ln();
        let best = (0..all.deviations.len())
            .min_by(|&a, &b| criterion(a).total_cmp(&criterion(b)))
            .unwrap_or(0);
        all.predictors.truncate(best + 1);
        all.deviations.truncate(best + 1);
        all
    }

    /// The order.
    #[must_use]
    pub fn order(&self) -> usize {
        self.predictors.len() - 1
    }

    /// The standard deviation of the noise.
    #[must_use]
    pub fn deviation(&self) -> f64 {
        self.deviations[0]
    }

    /// The standard deviation of the error of the predictor from all predecessors.
    #[must_use]
    pub fn innovation(&self) -> f64 {
        self.deviations[self.order()]
    }

    /// The same correlation with another standard deviation.
    #[must_use]
    pub fn scaled_to(&self, deviation: f64) -> Self {
        let factor = deviation / self.deviation();
        let deviations = self.deviations.iter().map(|d| d * factor).collect();
        Self { predictors: self.predictors.clone(), deviations }
    }

    /// The rows less what their predecessors predict, in units of the predictor's error: white and of unit variance if
    /// the rows are this noise.
    #[must_use]
    pub fn whitened(&self, rows: &[f64]) -> Vec<f64> {
        let order = self.order();
        let first = order.min(rows.len());
        let mut predicted = vec![0.0; rows.len()];
        for (k, value) in predicted[..first].iter_mut().enumerate() {
            let before = rows[..k].iter().rev();
            *value = self.predictors[k].iter().zip(before).map(|(a, r)| a * r).sum();
        }
        // Lag by lag, so that a row does not wait for the one before it.
        for (lag, a) in (1..).zip(&self.predictors[order]) {
            let before = rows[first - lag.min(first)..].iter();
            predicted[first..].iter_mut().zip(before).for_each(|(sum, r)| *sum += a * r);
        }
        let each = rows.iter().zip(predicted).enumerate();
        each.map(|(k, (row, predicted))| (row - predicted) / self.deviations[k.min(order)])
            .collect()
    }

    /// So many rows of this noise; `normal` draws standard normal numbers.
    pub fn drawn(&self, rows: usize, mut normal: impl FnMut() -> f64) -> Vec<f64> {
        let mut all: Vec<f64> = Vec::with_capacity(rows);
        for k in 0..rows {
            let from = k.min(self.order());
            let before = all[k - from..].iter().rev();
            let known: f64 = self.predictors[from].iter().zip(before).map(|(a, r)| a * r).sum();
            all.push(known + self.deviations[from] * normal());
        }
        all
    }

    /// Rows over which the noise is correlated: the variance of a long mean over that of independent rows,
    /// `s² / ((1 − Σ a_j)² γ_0)`.
    #[must_use]
    pub fn correlated_rows(&self) -> f64 {
        let order = self.order();
        let sum: f64 = self.predictors[order].iter().sum();
        let ratio = self.deviations[order] / (1.0 - sum) / self.deviation();
        (ratio * ratio).max(1.0)
    }
}

/// Least share of the variance that a further coefficient may leave: below it the recursion loses its digits.
const LEAST_SHARE: f64 = 1e-10;

/// Autocovariances `1/n Σ_k e_k e_{k+l}` at the lags `l` from 0 to `most`, over several series, each of which has mean zero
/// by its construction (residuals of a regression with a constant).
#[must_use]
pub fn autocovariance(series: &[&[f64]], most: usize) -> Vec<f64> {
    let n: usize = series.iter().map(|s| s.len()).sum();
    (0..=most)
        .map(|lag| {
            let of = |s: &&[f64]| -> f64 {
                s.iter().zip(s.get(lag..).unwrap_or_default()).map(|(a, b)| a * b).sum()
            };
            series.iter().map(of).sum::<f64>() / n.max(1) as f64
        })
        .collect()
}
