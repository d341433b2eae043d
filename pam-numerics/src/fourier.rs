//! The discrete Fourier transform of real series (by `realfft`): power spectra of pieces, and filters without phase.

use crate::dot::dot;
use realfft::RealFftPlanner;
use std::f64::consts::TAU;

/// Norm of what conjugate gradients leave of the right-hand side, relative to it.
const CONVERGED: f64 = 1e-5;
/// Largest number of steps of conjugate gradients. They end after a few for each edge of the band, by its logarithms (Slepian 1978).
const MOST_ITERATIONS: usize = 300;

/// Power of pieces of a series at the frequencies `j / n` per sample, `j` from 0 to `n/2`, with `n` the power of two from `piece` on:
/// periodograms of pieces that overlap by half, less the mean of the series, with Hann's window (Welch 1967). Empty for a series
/// shorter than a piece.
#[must_use]
pub fn power_of_pieces(series: &[f64], piece: usize) -> Vec<Vec<f64>> {
    let piece = piece.max(2);
    if series.len() < piece {
        return Vec::new();
    }
    let n = piece.next_power_of_two();
    let window: Vec<f64> =
        (0..piece).map(|k| 0.5 - 0.5 * (TAU * k as f64 / piece as f64).cos()).collect();
    let mean = series.iter().sum::<f64>() / series.len() as f64;
    let transform = RealFftPlanner::new().plan_fft_forward(n);
    let (mut values, mut spectrum) = (transform.make_input_vec(), transform.make_output_vec());
    let mut scratch = transform.make_scratch_vec();
    let power = |part: &[f64]| {
        // The transform uses its input as memory.
        values.fill(0.0);
        for ((value, x), w) in values.iter_mut().zip(part).zip(&window) {
            *value = w * (x - mean);
        }
        transform
            .process_with_scratch(&mut values, &mut spectrum, &mut scratch)
            .expect("vectors of the transform's own lengths");
        spectrum.iter().map(|c| c.norm_sqr()).collect()
    };
    series.windows(piece).step_by(piece / 2).map(power).collect()
}

/// The part of a series that harmonics of a band of frequencies do not explain, up to both ends: the residual of ridge regression.
///
/// `band` weighs each frequency (cycles per sample), 0 outside and 1 inside. The regressors are the harmonics of a period that is
/// `beyond` samples longer than the series at least, so that the series is not taken for periodic; a filter by a single transform
/// would have to invent what comes before and after, and leaks the band into its surroundings there. With `S` the covariance of
/// signals of the band and `λ` the `ridge`, the residual is `λ (S + λ I)⁻¹ (y − μ)`, by conjugate gradients with products by the fast
/// transform: the conditional mean of white noise of variance `λ` beside a stationary signal of that spectrum (Wiener 1949). The steady part
/// `μ` is estimated by generalised least squares beside that signal, since the mean of a series that ends within a period of the signal is no
/// steady part.
#[must_use]
pub fn outside_band(
    series: &[f64],
    beyond: usize,
    ridge: f64,
    band: impl Fn(f64) -> f64,
) -> Vec<f64> {
    let len = series.len();
    let n = (len + beyond).next_power_of_two();
    let mut planner = RealFftPlanner::new();
    let (forward, inverse) = (planner.plan_fft_forward(n), planner.plan_fft_inverse(n));
    // Neither direction is normalised.
    let weights: Vec<f64> = (0..=n / 2).map(|j| band(j as f64 / n as f64) / n as f64).collect();
    let (mut values, mut spectrum) = (forward.make_input_vec(), forward.make_output_vec());
    let mut scratch = [forward.make_scratch_vec(), inverse.make_scratch_vec()];
    let mut times_covariance = |vector: &[f64], product: &mut [f64]| {
        let [ahead, back] = &mut scratch;
        let (own, after) = values.split_at_mut(len);
        own.copy_from_slice(vector);
        after.fill(0.0);
        forward
            .process_with_scratch(&mut values, &mut spectrum, ahead)
            .expect("vectors of the transform's own lengths");
        spectrum.iter_mut().zip(&weights).for_each(|(c, w)| *c *= *w);
        // Both ends of the spectrum of a real series are real, even where a weight is not a number.
        for end in [0, n / 2] {
            spectrum[end].im = 0.0;
        }
        inverse
            .process_with_scratch(&mut spectrum, &mut values, back)
            .expect("a spectrum with real ends");
        for ((p, value), x) in product.iter_mut().zip(&values).zip(vector) {
            *p = value + ridge * x;
        }
    };
    // The solution x of (S + λ I) x = y.
    let mut solved = |mut left: Vec<f64>| {
        let mut solution = vec![0.0; len];
        let mut direction = left.clone();
        let mut product = vec![0.0; len];
        let mut square = dot(&left, &left);
        let enough = CONVERGED * CONVERGED * square;
        for _ in 0..MOST_ITERATIONS {
            if square <= enough {
                break;
            }
            times_covariance(&direction, &mut product);
            let step = square / dot(&direction, &product);
            for k in 0..len {
                solution[k] += step * direction[k];
                left[k] -= step * product[k];
            }
            let next = dot(&left, &left);
            for (d, l) in direction.iter_mut().zip(&left) {
                *d = l + next / square * *d;
            }
            square = next;
        }
        solution
    };
    // Less the mean, a constant series is exactly zero.
    let mean = series.iter().sum::<f64>() / len.max(1) as f64;
    let varying = solved(series.iter().map(|x| x - mean).collect());
    let of_one = solved(vec![1.0; len]);
    let steady = varying.iter().sum::<f64>() / of_one.iter().sum::<f64>();
    varying.iter().zip(&of_one).map(|(x, one)| ridge * (x - steady * one)).collect()
}
