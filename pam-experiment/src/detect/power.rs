//! Power of tests on noncentral χ².

use statrs::distribution::{ChiSquared, ContinuousCDF, Discrete, Poisson};

/// Terms of the Poisson mixture that are summed on each side of its middle, in standard deviations.
const DEVIATIONS: f64 = 9.0;

/// `P(χ²_p(λ) > t)`, the survival function of the noncentral χ² with `freedom` degrees of freedom and noncentrality `λ`: a
/// Poisson mixture of central ones (Johnson, Kotz and Balakrishnan, *Continuous Univariate Distributions* 2, §29.3).
///
/// ```
/// use pam_experiment::detect::noncentral_chi_square_sf;
/// // One degree of freedom: (z + √λ)² > t for a standard normal z; here P(|z + 3| > 1.96).
/// assert!((noncentral_chi_square_sf(1.959_964_f64.powi(2), 1.0, 9.0) - 0.850_84).abs() < 1e-4);
/// ```
#[must_use]
pub fn noncentral_chi_square_sf(t: f64, freedom: f64, noncentrality: f64) -> f64 {
    let central = |p: f64| ChiSquared::new(p).map_or(f64::NAN, |d| d.sf(t.max(0.0)));
    let half = 0.5 * noncentrality;
    if half < 1e-12 {
        return central(freedom);
    }
    let Ok(poisson) = Poisson::new(half) else { return f64::NAN };
    let reach = DEVIATIONS * half.sqrt() + DEVIATIONS;
    let (from, to) = ((half - reach).max(0.0) as u64, (half + reach) as u64);
    (from..=to).map(|j| poisson.pmf(j) * central(freedom + 2.0 * j as f64)).sum::<f64>().min(1.0)
}

/// The noncentrality at which a χ² of `freedom` degrees of freedom exceeds `t` with the given power.
#[must_use]
pub fn needed_noncentrality(t: f64, freedom: f64, power: f64) -> f64 {
    let (mut low, mut high) = (0.0, 4.0 * t.max(1.0) + 100.0);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if noncentral_chi_square_sf(t, freedom, middle) < power {
            low = middle
        } else {
            high = middle
        }
    }
    0.5 * (low + high)
}
