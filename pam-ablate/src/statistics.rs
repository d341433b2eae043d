//! Paired comparisons.
//!
//! With differences `d_i`, one a seed, the mean has the interval `d̄ ± t₀.₉₇₅(n−1) s/√n` and the paired
//! t-test the statistic `t = d̄ √n/s` (Student 1908). The signed-rank test (Wilcoxon 1945) ranks `|d_i|`
//! without zeros, ties sharing their mean rank, and takes W, the sum of the ranks of positive
//! differences; its two-sided p is exact, counted over all 2ⁿ signs of these ranks. With n seeds it
//! cannot be below `2^(1−n)`: five seeds give 0.0625 at best. [`holm`] corrects for several comparisons (Holm
//! 1979).

use pam_numerics::statistics;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal};

/// Pairs up to which the signed-rank test is exact; above, W is taken as normal.
const EXACT: usize = 60;

/// Statistics of the differences of pairs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Paired {
    /// Number of pairs.
    pub pairs: usize,
    /// Mean difference.
    pub mean: f64,
    /// Standard deviation of the differences.
    pub deviation: Option<f64>,
    /// Interval of the mean difference.
    pub interval: Option<[f64; 2]>,
    /// Student's t.
    pub t: Option<f64>,
    /// Its two-sided p.
    pub p_t: Option<f64>,
    /// Wilcoxon's W.
    pub w: f64,
    /// Its two-sided p; absent if all differences are zero.
    pub p_wilcoxon: Option<f64>,
}

impl Paired {
    /// Statistics of differences; `None` without any.
    #[must_use]
    pub fn of(differences: &[f64]) -> Option<Self> {
        if differences.is_empty() {
            return None;
        }
        let mean = statistics::mean(differences);
        let test = statistics::paired_t_test(differences);
        let (w, p_wilcoxon) = signed_rank(differences);
        let half = statistics::mean_half_width_95(differences);
        Some(Self {
            pairs: differences.len(),
            mean,
            deviation: deviation(differences),
            interval: half.map(|h| [mean - h, mean + h]),
            t: test.map(|t| t.t),
            p_t: test.map(|t| t.p),
            w,
            p_wilcoxon,
        })
    }
}

/// Sample standard deviation; `None` below two values.
pub(crate) fn deviation(values: &[f64]) -> Option<f64> {
    (values.len() > 1).then(|| statistics::standard_deviation(values))
}

/// W and its two-sided p.
fn signed_rank(differences: &[f64]) -> (f64, Option<f64>) {
    let mut d: Vec<f64> = differences.iter().copied().filter(|d| *d != 0.0).collect();
    if d.is_empty() {
        return (0.0, None);
    }
    d.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    // Twice the ranks, so that those of ties are whole.
    let mut ranks = vec![0_usize; d.len()];
    let mut first = 0;
    while first < d.len() {
        let ties = d[first..].iter().take_while(|v| v.abs() == d[first].abs()).count();
        ranks[first..first + ties].fill(2 * first + ties + 1);
        first += ties;
    }
    let total: usize = ranks.iter().sum();
    let w2: usize = d.iter().zip(&ranks).filter(|(d, _)| **d > 0.0).map(|(_, r)| r).sum();
    let w = w2 as f64 / 2.0;
    let tail = w2.min(total - w2);
    let p = if d.len() <= EXACT {
        // How probable each sum is, rank by rank.
        let mut chances = vec![0.0; total + 1];
        chances[0] = 1.0;
        for &r in &ranks {
            for sum in (0..=total).rev() {
                let with = if sum >= r { chances[sum - r] } else { 0.0 };
                chances[sum] = 0.5 * (chances[sum] + with);
            }
        }
        2.0 * chances[..=tail].iter().sum::<f64>()
    } else {
        let mean = total as f64 / 4.0;
        let variance = ranks.iter().map(|r| (*r as f64 / 4.0).powi(2)).sum::<f64>();
        let z = (tail as f64 / 2.0 - mean + 0.5) / variance.sqrt();
        match Normal::new(0.0, 1.0) {
            Ok(normal) => 2.0 * normal.cdf(z),
            Err(_) => return (w, None),
        }
    };
    (w, Some(p.min(1.0)))
}

/// p-values corrected for there being several (Holm 1979), in their order.
#[must_use]
pub fn holm(p: &[Option<f64>]) -> Vec<Option<f64>> {
    let mut known: Vec<(usize, f64)> =
        p.iter().enumerate().filter_map(|(i, p)| Some((i, (*p)?))).collect();
    known.sort_by(|a, b| a.1.total_cmp(&b.1));
    let count = known.len();
    let mut corrected = vec![None; p.len()];
    let mut largest = 0.0_f64;
    for (rank, (i, p)) in known.into_iter().enumerate() {
        largest = largest.max(p * (count - rank) as f64).min(1.0);
        corrected[i] = Some(largest);
    }
    corrected
}
