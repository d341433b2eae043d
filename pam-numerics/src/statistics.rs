//! Means, quantiles, Student's t and the paired t-test.

use serde::Serialize;
use statrs::distribution::{ChiSquared, ContinuousCDF, Normal, StudentsT};

/// Arithmetic mean; NaN without values.
#[must_use]
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Root mean square; NaN without values.
#[must_use]
pub fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

/// Sample standard deviation `√(Σ (v − v̄)² / (n − 1))`; NaN below two values.
#[must_use]
pub fn standard_deviation(values: &[f64]) -> f64 {
    let mean = mean(values);
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    if values.len() < 2 { f64::NAN } else { (squares / (values.len() - 1) as f64).sqrt() }
}

/// Quantile of order `share` (from 0 to 1) by linear interpolation between order statistics, the definition 7 of
/// Hyndman and Fan (1996) and the default of NumPy; NaN without values.
#[must_use]
pub fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let at = share.clamp(0.0, 1.0) * sorted.len().saturating_sub(1) as f64;
    let value = |i: usize| sorted.get(i).copied().unwrap_or(f64::NAN);
    let (low, high) = (value(at.floor() as usize), value(at.ceil() as usize));
    if low == high { low } else { low + at.fract() * (high - low) }
}

/// Median: the mean of the two middle values if their number is even; NaN without values.
#[must_use]
pub fn median(values: &[f64]) -> f64 {
    quantile(values, 0.5)
}

/// The finite values without repetitions, in order. Values that differ by rounding only, by 10⁻⁹ of the largest, are one
/// level.
#[must_use]
pub fn levels(values: &[f64]) -> Vec<f64> {
    let mut different: Vec<f64> = values.iter().copied().filter(|v| v.is_finite()).collect();
    different.sort_unstable_by(f64::total_cmp);
    let size = different.first().map_or(0.0, |a| a.abs().max(different[different.len() - 1].abs()));
    different.dedup_by(|b, a| *b - *a <= 1e-9 * size);
    different
}

/// Third differences, in which a motion that is smooth over four samples vanishes. Of white noise of variance σ² they have
/// the variance [`THIRD_DIFFERENCE_VARIANCE`] σ² (Gasser, Sroka and Jennen-Steinmetz 1986, on pseudo-residuals).
#[must_use]
pub fn third_differences(values: &[f64]) -> Vec<f64> {
    values.windows(4).map(|w| w[3] - 3.0 * w[2] + 3.0 * w[1] - w[0]).collect()
}

/// Variance of third differences of white noise of unit variance: 1 + 9 + 9 + 1.
pub const THIRD_DIFFERENCE_VARIANCE: f64 = 20.0;

/// The step of the grid on which all values lie, such as that of an encoder or of rounded decimals; 0 where they show none,
/// with less than two different values, or where more than half of them are different.
///
/// The step is the mean of the gaps between neighbouring different values, each over the whole number of smallest gaps
/// nearest to it; each gap must be a whole number of steps to 5 % of a step.
#[must_use]
pub fn resolution(values: &[f64]) -> f64 {
    let different = levels(values);
    if different.len() < 2 || 2 * different.len() > values.len() {
        return 0.0;
    }
    let gaps = || different.windows(2).map(|w| w[1] - w[0]);
    let smallest = gaps().fold(f64::INFINITY, f64::min);
    let steps: f64 = gaps().map(|g| (g / smallest).round()).sum();
    let step = gaps().sum::<f64>() / steps;
    let whole = |g: f64| (g / step - (g / step).round()).abs() < 0.05;
    if gaps().all(whole) { step } else { 0.0 }
}

/// Student's t with `freedom` degrees of freedom that a two-sided 95 % interval reaches to: the factor from a
/// standard error to half the width of the interval. For a `freedom` that is not positive, 1.96 of the normal
/// distribution.
#[must_use]
pub fn t_quantile_95(freedom: f64) -> f64 {
    if freedom > 1e5 {
        // Expansion about the normal quantile (Abramowitz and Stegun 26.7.5): the inversion loses digits here.
        let z: f64 = 1.959_963_984_540_054;
        return z + (z.powi(3) + z) / (4.0 * freedom);
    }
    StudentsT::new(0.0, 1.0, freedom).map_or(1.96, |t| t.inverse_cdf(0.975))
}

/// Quantile of Student's t with `freedom` degrees of freedom: the value that it exceeds with a probability of
/// `1 − probability`; that of the normal distribution for more than 100 000. NaN for arguments out of range.
#[must_use]
pub fn t_quantile(probability: f64, freedom: f64) -> f64 {
    if !(0.0..=1.0).contains(&probability) {
        return f64::NAN;
    }
    if freedom > 1e5 {
        return Normal::standard().inverse_cdf(probability);
    }
    StudentsT::new(0.0, 1.0, freedom).map_or(f64::NAN, |t| t.inverse_cdf(probability))
}

/// Quantile of the χ² distribution with `freedom` degrees of freedom; NaN for arguments out of range.
#[must_use]
pub fn chi_square_quantile(probability: f64, freedom: f64) -> f64 {
    if !(0.0..=1.0).contains(&probability) {
        return f64::NAN;
    }
    ChiSquared::new(freedom).map_or(f64::NAN, |c| c.inverse_cdf(probability))
}

/// Half the width of the 95 % confidence interval of a mean, `t₀.₉₇₅(n − 1) s / √n`; `None` below two values.
#[must_use]
pub fn mean_half_width_95(values: &[f64]) -> Option<f64> {
    let n = values.len() as f64;
    (n > 1.0).then(|| t_quantile_95(n - 1.0) * standard_deviation(values) / n.sqrt())
}

/// Result of a paired t-test.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PairedTTest {
    /// Number of pairs `n`.
    pub pairs: usize,
    /// Mean difference `d̄`.
    pub mean_difference: f64,
    /// `t = d̄ √n / s`.
    pub t: f64,
    /// Two-sided p-value: the probability of so large a |t| if the mean difference were zero.
    pub p: f64,
}

/// Paired t-test (Student 1908) on the differences of the pairs; `None` for fewer than two pairs and for
/// differences that do not vary.
#[must_use]
pub fn paired_t_test(differences: &[f64]) -> Option<PairedTTest> {
    let n = differences.len();
    let (mean_difference, deviation) = (mean(differences), standard_deviation(differences));
    if !(deviation.is_finite() && deviation > 0.0) {
        return None;
    }
    let t = mean_difference * (n as f64).sqrt() / deviation;
    let student = StudentsT::new(0.0, 1.0, (n - 1) as f64).ok()?;
    Some(PairedTTest { pairs: n, mean_difference, t, p: 2.0 * student.sf(t.abs()) })
}

/// One-sided p-value of Student's t-test for a mean above zero; 1 if the mean is not above zero, and for values that do not vary.
#[must_use]
pub fn positive_mean_p_value(values: &[f64]) -> f64 {
    match paired_t_test(values) {
        Some(t) if t.mean_difference > 0.0 => 0.5 * t.p,
        _ => 1.0,
    }
}
