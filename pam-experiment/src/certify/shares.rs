//! Exact limits of shares.

use statrs::distribution::{Beta, ContinuousCDF};

/// Limits of a share at a two-sided confidence (Clopper and Pearson 1934), for `count` of `all`.
///
/// ```
/// use pam_experiment::certify::clopper_pearson;
/// let [low, high] = clopper_pearson(0, 59, 0.90);
/// assert_eq!(low, 0.0);
/// assert!((high - (1.0 - 0.05_f64.powf(1.0 / 59.0))).abs() < 1e-9); // the rule of three
/// ```
#[must_use]
pub fn clopper_pearson(count: u64, all: u64, confidence: f64) -> [f64; 2] {
    if all == 0 {
        return [0.0, 1.0];
    }
    let tail = 0.5 * (1.0 - confidence);
    let (k, n) = (count as f64, all as f64);
    let quantile = |a: f64, b: f64, p: f64| Beta::new(a, b).map_or(f64::NAN, |d| d.inverse_cdf(p));
    let low = if count == 0 { 0.0 } else { quantile(k, n - k + 1.0, tail) };
    let high = if count == all { 1.0 } else { quantile(k + 1.0, n - k, 1.0 - tail) };
    [low, high]
}
