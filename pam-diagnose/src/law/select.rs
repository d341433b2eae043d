//! Short sums of terms that do, to first order, what the correction does.

use super::design::Design;
use crate::fit::ChannelErrors;
use pam_core::parallel;
use pam_numerics::dot;

/// A set of columns with its least squares.
#[derive(Debug, Clone)]
pub(crate) struct Selection {
    /// Indices of the columns.
    pub(crate) columns: Vec<usize>,
    /// Their coefficients.
    pub(crate) coefficients: Vec<f64>,
    /// Minus two times the logarithm of its posterior probability, up to a constant.
    pub(crate) total: f64,
}

/// A selection to which columns are added.
struct Growing {
    selection: Selection,
    /// Orthonormal basis of its columns.
    basis: Vec<Vec<f64>>,
    /// What it leaves of the target.
    left: Vec<f64>,
}

/// A set of columns with its estimated odds.
#[derive(Debug, Clone, PartialEq)]
struct Prospect {
    columns: Vec<usize>,
    total: f64,
}

/// How selections are compared.
pub(crate) struct Scores<'d> {
    pub(crate) design: &'d Design,
    pub(crate) rows_per_observation: f64,
    /// Mean whitened squares of the channels that are as good as noise.
    pub(crate) least: Vec<f64>,
}

/// A column has to have this share of its own beside the others.
pub(super) const OWN_SHARE: f64 = 1e-4;

impl Scores<'_> {
    /// Minus two times the log-likelihood of what is left.
    fn misfit(&self, left: &[f64]) -> f64 {
        let rows = self.design.row_count();
        let sums = self.design.by_channel(left).into_iter().zip(&self.least);
        let errors = ChannelErrors { sums: sums.map(|(s, least)| s / least).collect(), rows };
        rows as f64 / self.rows_per_observation * errors.deviance()
    }

    /// The price of a parameter.
    fn parameter_price(&self) -> f64 {
        (self.design.row_count().max(2) as f64).ln()
    }

    /// A beam search over sums of up to `most` of the columns, each with a price of its own; best first.
    pub(crate) fn beam(
        &self,
        columns: &[Vec<f64>],
        prices: &[f64],
        most: usize,
        width: usize,
    ) -> Vec<Selection> {
        let target = &self.design.target;
        let sizes: Vec<f64> = columns.iter().map(|c| dot(c, c)).collect();
        let mut all: Vec<Selection> = Vec::new();
        let least = self.design.weighted_mean(&self.least);
        let none = Selection { columns: Vec::new(), coefficients: Vec::new(), total: 0.0 };
        let mut beam = vec![Growing { selection: none, basis: Vec::new(), left: target.clone() }];
        for _ in 0..most {
            let grown: Vec<Vec<Prospect>> = parallel::map(beam.len(), |i| {
                let Growing { selection, basis, left } = &beam[i];
                let whole = dot(left, left);
                let mut gains: Vec<Prospect> = Vec::new();
                for (k, column) in columns.iter().enumerate() {
                    if selection.columns.contains(&k) || sizes[k] == 0.0 {
                        continue;
                    }
                    // Of the column what the set has not.
                    let shares: f64 = basis.iter().map(|b| dot(b, column).powi(2)).sum();
                    let own = sizes[k] - shares;
                    if own < OWN_SHARE * sizes[k] {
                        continue;
                    }
                    let gain = dot(column, left).powi(2) / own;
                    let mut more = selection.columns.clone();
                    more.push(k);
                    more.sort_unstable();
                    let price: f64 = more.iter().map(|k| prices[*k] + self.parameter_price()).sum();
                    // As the deviance would be if all channels had the same error.
                    let rows = (self.design.row_count() * self.design.channels()) as f64;
                    let chi = (whole - gain).max(0.0) / rows / least;
                    let deviance = if chi > 1.0 { chi.ln() } else { chi - 1.0 };
                    let total = rows / self.rows_per_observation * deviance + price;
                    gains.push(Prospect { columns: more, total });
                }
                gains.sort_by(|a, b| a.total.total_cmp(&b.total));
                gains.truncate(2 * width);
                gains
            });
            let mut next: Vec<Prospect> = grown.into_iter().flatten().collect();
            next.sort_by(|a, b| a.total.total_cmp(&b.total));
            next.dedup_by(|a, b| a.columns == b.columns);
            next.truncate(4 * width);
            let solved =
                parallel::map(next.len(), |i| self.solved(columns, prices, &next[i].columns));
            let mut solved: Vec<Growing> = solved.into_iter().flatten().collect();
            solved.sort_by(|a, b| a.selection.total.total_cmp(&b.selection.total));
            all.extend(solved.iter().map(|s| s.selection.clone()));
            solved.truncate(width);
            beam = solved;
        }
        all.sort_by(|a, b| a.total.total_cmp(&b.total));
        all
    }

    /// The least squares of a set of columns; `None` if they are not independent.
    pub(super) fn least_squares(
        &self,
        columns: &[Vec<f64>],
        prices: &[f64],
        set: &[usize],
    ) -> Option<Selection> {
        self.solved(columns, prices, set).map(|grown| grown.selection)
    }

    fn solved(&self, columns: &[Vec<f64>], prices: &[f64], set: &[usize]) -> Option<Growing> {
        let (n, target) = (set.len(), &self.design.target);
        let entry = |i: usize, j: usize| dot(&columns[set[i]], &columns[set[j]]);
        let right: Vec<f64> = set.iter().map(|&k| dot(&columns[k], target)).collect();
        let coefficients = pam_numerics::ScaledCholesky::new(n, entry, 1e-10)?.solve(&right)?;
        let mut left = target.clone();
        for (c, &k) in coefficients.iter().zip(set) {
            left.iter_mut().zip(&columns[k]).for_each(|(l, x)| *l -= c * x);
        }
        let misfit = self.misfit(&left);
        let price: f64 = set.iter().map(|k| prices[*k] + self.parameter_price()).sum();
        let basis = super::design::orthonormal(set.iter().map(|&k| columns[k].clone()).collect());
        let selection = Selection { columns: set.to_vec(), coefficients, total: misfit + price };
        Some(Growing { selection, basis, left })
    }
}
