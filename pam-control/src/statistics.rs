//! Paired t-test, straight lines.

use crate::error::ControlError;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// Mean and standard deviation (of a sample); NaN where undefined.
#[must_use]
pub fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    (mean, (squares / (n - 1.0)).sqrt())
}

/// A paired t-test.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PairedTest {
    /// Number of pairs.
    pub pairs: usize,
    /// Mean of second less first.
    pub mean_difference: f64,
    /// Student's t.
    pub t: f64,
    /// Probability of so large a |t| if the mean difference were zero.
    pub p: f64,
}

/// Tests whether the second numbers differ from the first ones in the mean, pair by pair.
///
/// # Errors
/// [`ControlError::Insufficient`] for fewer than two pairs, or differences that do not vary.
pub fn paired_t_test(pairs: &[[f64; 2]]) -> Result<PairedTest, ControlError> {
    let differences: Vec<f64> = pairs.iter().map(|[a, b]| b - a).collect();
    let n = differences.len();
    let (mean, deviation) = mean_and_deviation(&differences);
    let insufficient = || ControlError::Insufficient(format!("{n} pairs allow no paired t-test"));
    if n < 2 || !(deviation.is_finite() && deviation > 0.0) {
        return Err(insufficient());
    }
    let t = mean / (deviation / (n as f64).sqrt());
    let student = StudentsT::new(0.0, 1.0, (n - 1) as f64).map_err(|_| insufficient())?;
    Ok(PairedTest { pairs: n, mean_difference: mean, t, p: 2.0 * student.sf(t.abs()) })
}

/// Least-squares line `y = slope · x + offset`, with R².
#[must_use]
pub fn line(points: &[[f64; 2]]) -> [f64; 3] {
    let n = points.len() as f64;
    let mean = |i: usize| points.iter().map(|p| p[i]).sum::<f64>() / n;
    let (mx, my) = (mean(0), mean(1));
    let sum = |f: &dyn Fn(&[f64; 2]) -> f64| points.iter().map(f).sum::<f64>();
    let xy = sum(&|p| (p[0] - mx) * (p[1] - my));
    let xx = sum(&|p| (p[0] - mx).powi(2));
    let yy = sum(&|p| (p[1] - my).powi(2));
    let slope = xy / xx;
    [slope, my - slope * mx, xy * xy / (xx * yy)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sleep data of Student (1908): t = 4.0621, p = 0.00283.
    #[test]
    fn students_own_example() {
        let first = [0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0];
        let second = [1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4];
        let pairs: Vec<[f64; 2]> = first.into_iter().zip(second).map(|(a, b)| [a, b]).collect();
        let test = paired_t_test(&pairs).unwrap();
        assert!((test.t - 4.0621).abs() < 1e-4 && (test.p - 0.002_833).abs() < 1e-6, "{test:?}");
        assert!(paired_t_test(&pairs[..1]).is_err());
        assert!(paired_t_test(&[[1.0, 2.0], [2.0, 3.0]]).is_err());
    }
}
