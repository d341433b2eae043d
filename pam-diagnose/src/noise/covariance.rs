//! Covariances in time, of channels and between them.

use super::autoregression::autocovariance;

/// Stationary covariances of several channels, `γ_cd(l) = ½ (E e_c(k) e_d(k+l) + E e_d(k) e_c(k+l))` at the lags `l` = 0, 1, …:
/// those of every sum of the channels follow from them ([`of_sum`](Self::of_sum)).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Covariances {
    /// `γ_cd` at all lags for each `c` and each `d ≤ c`.
    lower: Vec<Vec<Vec<f64>>>,
}

impl Covariances {
    /// Channels that do not go with each other, each with its autocovariances.
    #[must_use]
    pub fn independent(channels: Vec<Vec<f64>>) -> Self {
        let row = |(c, own): (usize, Vec<f64>)| {
            let mut row = vec![vec![0.0; own.len()]; c];
            row.push(own);
            row
        };
        Self { lower: channels.into_iter().enumerate().map(row).collect() }
    }

    /// Those of rows at the lags up to `most`; `channels[c]` holds the series of channel `c`, one for each experiment, each of mean zero.
    #[must_use]
    pub fn of_rows(channels: &[Vec<&[f64]>], most: usize) -> Self {
        // 2 γ_cd is what γ of the sum has beyond those of both.
        let own: Vec<Vec<f64>> = channels.iter().map(|c| autocovariance(c, most)).collect();
        let between = |c: usize, d: usize| -> Vec<f64> {
            if c == d {
                return own[c].clone();
            }
            let sums: Vec<Vec<f64>> = channels[c]
                .iter()
                .zip(&channels[d])
                .map(|(a, b)| a.iter().zip(*b).map(|(a, b)| a + b).collect())
                .collect();
            let sums: Vec<&[f64]> = sums.iter().map(Vec::as_slice).collect();
            let both = autocovariance(&sums, most);
            let each = own[c].iter().zip(&own[d]);
            both.iter().zip(each).map(|(both, (a, b))| 0.5 * (both - a - b)).collect()
        };
        let row = |c: usize| (0..=c).map(|d| between(c, d)).collect();
        Self { lower: (0..channels.len()).map(row).collect() }
    }

    /// Standard deviations of the channels.
    #[must_use]
    pub fn deviations(&self) -> Vec<f64> {
        let variance = |(c, row): (usize, &Vec<Vec<f64>>)| row[c].first().copied().unwrap_or(0.0);
        self.lower.iter().enumerate().map(variance).map(|v| v.max(0.0).sqrt()).collect()
    }

    /// The autocovariances of `Σ_c weights[c] e_c`; empty without channels.
    #[must_use]
    pub fn of_sum(&self, weights: &[f64]) -> Vec<f64> {
        self.of_sums(weights, weights)
    }

    /// The covariances of two sums of the channels, as [`of_sum`](Self::of_sum).
    #[must_use]
    pub fn of_sums(&self, one: &[f64], other: &[f64]) -> Vec<f64> {
        let mut all = Vec::new();
        for (c, row) in self.lower.iter().enumerate() {
            for (d, gamma) in row.iter().enumerate() {
                let weight = |c: usize, d: usize| {
                    let of = |w: &[f64], c: usize| w.get(c).copied().unwrap_or(0.0);
                    of(one, c) * of(other, d)
                };
                let weight = if c == d { weight(c, c) } else { weight(c, d) + weight(d, c) };
                add(&mut all, gamma, weight);
            }
        }
        all
    }

    /// Adds a multiple of other ones.
    pub fn add(&mut self, other: &Self, factor: f64) {
        for (c, row) in other.lower.iter().enumerate() {
            if c == self.lower.len() {
                self.lower.push(vec![Vec::new(); c + 1]);
            }
            for (own, more) in self.lower[c].iter_mut().zip(row) {
                add(own, more, factor);
            }
        }
    }
}

/// Adds a multiple of numbers; there may be more of them.
fn add(sums: &mut Vec<f64>, more: &[f64], factor: f64) {
    sums.resize(sums.len().max(more.len()), 0.0);
    sums.iter_mut().zip(more).for_each(|(s, m)| *s += factor * m);
}
