//! Periods of the strongest lines in the residual of a correction.

use super::ground::Dyn;
use crate::error::DiagnoseError;
use crate::fit::{Hypothesis, Problem};
use pam_core::parallel;
use pam_numerics::statistics::mean;
use std::f64::consts::TAU;

/// Most periods.
const PERIODS: usize = 3;
/// Frequencies of the periodogram in the width of a line, which is one over the longest recording.
const PER_LINE: usize = 4;
/// Fewest cycles in the longest recording.
const FEWEST_CYCLES: f64 = 2.0;
/// Highest frequency, Hz.
const HIGHEST_HZ: f64 = 10.0;

/// Periods of the strongest lines in the spectrum of the residuals that a hypothesis leaves, s, the strongest first: maxima of the
/// periodogram with Hann's window (Schuster 1898), summed over channels and experiments in units of the noise, between the points of
/// its grid by a parabola.
pub(super) fn periods_s(
    problem: &Problem<'_, Dyn<'_>>,
    hypothesis: &Hypothesis,
) -> Result<Vec<f64>, DiagnoseError> {
    let length = |i: usize| problem.rows(i) as f64 * problem.row_s(i);
    let finite = |i: &usize| problem.rows(*i) > 2 && length(*i).is_finite();
    let experiments: Vec<usize> = (0..problem.len()).filter(finite).collect();
    let longest_s = experiments.iter().map(|i| length(*i)).fold(0.0, f64::max);
    let row_s = experiments.iter().map(|i| problem.row_s(*i)).fold(0.0, f64::max);
    if longest_s <= 0.0 {
        return Ok(Vec::new());
    }
    let step_hz = 1.0 / (PER_LINE as f64 * longest_s);
    let first_hz = FEWEST_CYCLES / longest_s;
    let last_hz = HIGHEST_HZ.min(0.5 / row_s);
    if last_hz <= first_hz {
        return Ok(Vec::new());
    }
    let count = ((last_hz - first_hz) / step_hz) as usize + 1;
    let frequency_hz = |j: f64| first_hz + j * step_hz;
    let each: Result<Vec<Vec<f64>>, DiagnoseError> = parallel::map(experiments.len(), |k| {
        let i = experiments[k];
        let mut power = vec![0.0; count];
        for channel in problem.whitened_residuals(hypothesis, i)? {
            let windowed = windowed(&channel);
            for (j, p) in power.iter_mut().enumerate() {
                *p += power_at(&windowed, TAU * frequency_hz(j as f64) * problem.row_s(i));
            }
        }
        Ok(power)
    })
    .into_iter()
    .collect();
    let mut power = vec![0.0; count];
    for own in each? {
        power.iter_mut().zip(own).for_each(|(sum, p)| *sum += p);
    }
    let mut maxima: Vec<(f64, f64)> = (1..count - 1)
        .filter(|&j| power[j] > power[j - 1] && power[j] >= power[j + 1])
        .map(|j| {
            let [a, b, c] = [power[j - 1], power[j], power[j + 1]];
            let offset = 0.5 * (a - c) / (a - 2.0 * b + c);
            (b, frequency_hz(j as f64 + offset).recip())
        })
        .collect();
    maxima.sort_by(|a, b| b.0.total_cmp(&a.0));
    Ok(maxima.into_iter().take(PERIODS).map(|m| m.1).collect())
}

/// A series less its mean, times Hann's window.
fn windowed(series: &[f64]) -> Vec<f64> {
    let (mean, step) = (mean(series), TAU / series.len() as f64);
    let window = |k: usize| 0.5 * (1.0 - (step * (k as f64 + 0.5)).cos());
    series.iter().enumerate().map(|(k, v)| (v - mean) * window(k)).collect()
}

/// The power of a series at an angular frequency per row.
fn power_at(series: &[f64], angle: f64) -> f64 {
    // Turned by one row at a time.
    let (sin, cos) = angle.sin_cos();
    let (mut re, mut im, mut c, mut s) = (0.0, 0.0, 1.0, 0.0);
    for v in series {
        re += v * c;
        im += v * s;
        (c, s) = (c * cos - s * sin, s * cos + c * sin);
    }
    re * re + im * im
}
