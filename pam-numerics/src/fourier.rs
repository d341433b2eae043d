//! The discrete Fourier transform: power spectra of pieces, and filters without phase.

use crate::dot::dot;
use std::f64::consts::TAU;

/// Norm of what conjugate gradients leave of the right-hand side, relative to it.
const CONVERGED: f64 = 1e-5;
/// Largest number of steps of conjugate gradients. They end after a few for each edge of the band, by its logarithms (Slepian 1978).
const MOST_ITERATIONS: usize = 300;

/// The discrete Fourier transform `X_j = Σ_k x_k e^{−2πi jk/n}` of `n` complex values, by halves (Cooley and Tukey 1965).
#[derive(Debug, Clone)]
pub struct Transform {
    /// `e^{−πi k/h}` at place `h + k`, for every half length `h` and `k < h`: in the order in which they are used.
    roots: Vec<[f64; 2]>,
}

impl Transform {
    /// The transform of so many values.
    ///
    /// # Panics
    /// If their number is no power of two.
    #[must_use]
    pub fn new(n: usize) -> Self {
        assert!(n.is_power_of_two(), "{n} values are no power of two");
        let mut roots = vec![[0.0; 2]; n];
        for k in 0..n / 2 {
            let (sin, cos) = (TAU * k as f64 / n as f64).sin_cos();
            roots[n / 2 + k] = [cos, -sin];
        }
        for place in (1..n / 2).rev() {
            roots[place] = roots[2 * place];
        }
        Self { roots }
    }

    /// Transforms values `[re, im]` in place.
    ///
    /// # Panics
    /// If there are more or fewer values than the transform is for.
    pub fn apply(&self, values: &mut [[f64; 2]]) {
        let n = values.len();
        assert_eq!(n, self.roots.len(), "the number of values");
        let bits = n.trailing_zeros();
        for k in 0..n {
            let reversed = if bits == 0 { 0 } else { k.reverse_bits() >> (usize::BITS - bits) };
            if k < reversed {
                values.swap(k, reversed);
            }
        }
        let mut half = 1;
        while half < n {
            let roots = &self.roots[half..2 * half];
            for block in values.chunks_exact_mut(2 * half) {
                let (first, second) = block.split_at_mut(half);
                for ((a, b), [c, s]) in first.iter_mut().zip(second).zip(roots) {
                    let turned = [c * b[0] - s * b[1], c * b[1] + s * b[0]];
                    *b = [a[0] - turned[0], a[1] - turned[1]];
                    *a = [a[0] + turned[0], a[1] + turned[1]];
                }
            }
            half *= 2;
        }
    }
}

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
    let transform = Transform::new(n);
    let power = |part: &[f64]| {
        let mut values = vec![[0.0; 2]; n];
        for ((value, x), w) in values.iter_mut().zip(part).zip(&window) {
            value[0] = w * (x - mean);
        }
        transform.apply(&mut values);
        values[..=n / 2].iter().map(|[re, im]| re * re + im * im).collect()
    };
    series.windows(piece).step_by(piece / 2).map(power).collect()
}

/// The part of a series that harmonics of a band of frequencies do not explain, up to both ends: the residual of ridge regression.
///
/// `band` weighs each frequency (cycles per sample), 0 outside and 1 inside. The regressors are the harmonics of a period that is
/// `beyond` samples longer than the series at least, so that the series is not taken for periodic; a filter by a single transform
/// would have to invent what comes before and after, and leaks the band into its surroundings there. With `S` the covariance of
/// signals of the band and `λ` the `ridge`, the residual is `λ (S + λ I)⁻¹ (y − mean)`, by conjugate gradients with products by the fast
/// transform: the conditional mean of white noise of variance `λ` beside a stationary signal of that spectrum (Wiener 1949).
#[must_use]
pub fn outside_band(
    series: &[f64],
    beyond: usize,
    ridge: f64,
    band: impl Fn(f64) -> f64,
) -> Vec<f64> {
    let len = series.len();
    let n = (len + beyond).next_power_of_two();
    let weights: Vec<f64> = (0..n).map(|j| band(j.min(n - j) as f64 / n as f64)).collect();
    let transform = Transform::new(n);
    let mut values = vec![[0.0; 2]; n];
    let mut times_covariance = |vector: &[f64], product: &mut [f64]| {
        values.fill([0.0; 2]);
        for (value, &x) in values.iter_mut().zip(vector) {
            value[0] = x;
        }
        transform.apply(&mut values);
        for (value, w) in values.iter_mut().zip(&weights) {
            // The inverse transform is that of the conjugate.
            *value = [w * value[0], -w * value[1]];
        }
        transform.apply(&mut values);
        for ((p, value), x) in product.iter_mut().zip(&values).zip(vector) {
            *p = value[0] / n as f64 + ridge * x;
        }
    };
    let mean = series.iter().sum::<f64>() / len.max(1) as f64;
    let mut left: Vec<f64> = series.iter().map(|x| x - mean).collect();
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
    solution.iter().map(|x| ridge * x).collect()
}
