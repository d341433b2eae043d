//! The correlation length of a residual.

use crate::settings::NoiseSettings;

/// Rows over which a residual is correlated, `1 + 2 Σ ρ_k` up to the first `ρ_k` below zero (Sokal 1997), at most
/// [`correlated_share`](NoiseSettings::correlated_share) of the rows.
#[must_use]
pub fn correlated_rows(errors: &[f64], settings: &NoiseSettings) -> f64 {
    let n = errors.len();
    let mean = errors.iter().sum::<f64>() / n as f64;
    let at_lag = |k: usize| -> f64 {
        errors.iter().zip(&errors[k..]).map(|(a, b)| (a - mean) * (b - mean)).sum()
    };
    let variance = at_lag(0);
    if variance <= 0.0 {
        return 1.0;
    }
    let sum: f64 = (1..(settings.lag_share * n as f64) as usize)
        .map(|k| at_lag(k) / variance)
        .take_while(|r| *r > 0.0)
        .sum();
    (1.0 + 2.0 * sum).min(settings.correlated_share * n as f64).max(1.0)
}
