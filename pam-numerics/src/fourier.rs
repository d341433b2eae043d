//! The discrete Fourier transform: power spectra of pieces, and filters without phase.

use std::f64::consts::TAU;

/// The discrete Fourier transform `X_j = Σ_k x_k e^{−2πi jk/n}` of complex values `[re, im]`, in place, by halves (Cooley and
/// Tukey 1965).
///
/// # Panics
/// If the number of values is no power of two.
pub fn transform(values: &mut [[f64; 2]]) {
    let n = values.len();
    assert!(n.is_power_of_two(), "{n} values are no power of two");
    let bits = n.trailing_zeros();
    for k in 0..n {
        let reversed = if bits == 0 { 0 } else { k.reverse_bits() >> (usize::BITS - bits) };
        if k < reversed {
            values.swap(k, reversed);
        }
    }
    let roots: Vec<[f64; 2]> = (0..n / 2)
        .map(|k| {
            let (sin, cos) = (TAU * k as f64 / n as f64).sin_cos();
            [cos, -sin]
        })
        .collect();
    let mut half = 1;
    while half < n {
        let stride = n / (2 * half);
        for block in values.chunks_exact_mut(2 * half) {
            let (first, second) = block.split_at_mut(half);
            for (k, (a, b)) in first.iter_mut().zip(second).enumerate() {
                let [c, s] = roots[k * stride];
                let turned = [c * b[0] - s * b[1], c * b[1] + s * b[0]];
                *b = [a[0] - turned[0], a[1] - turned[1]];
                *a = [a[0] + turned[0], a[1] + turned[1]];
            }
        }
        half *= 2;
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
    let power = |part: &[f64]| {
        let mut values = vec![[0.0; 2]; n];
        for ((value, x), w) in values.iter_mut().zip(part).zip(&window) {
            value[0] = w * (x - mean);
        }
        transform(&mut values);
        values[..=n / 2].iter().map(|[re, im]| re * re + im * im).collect()
    };
    series.windows(piece).step_by(piece / 2).map(power).collect()
}

/// A series whose content at each frequency (in cycles per sample) is multiplied by a gain, without a change of phase.
///
/// The series goes on at both ends as its mirror image about the end, over `reach` samples, in which it fades to its mean.
#[must_use]
pub fn filtered(series: &[f64], reach: usize, gain: impl Fn(f64) -> f64) -> Vec<f64> {
    let len = series.len();
    let (Some(&first), Some(&last)) = (series.first(), series.last()) else { return Vec::new() };
    let reach = reach.clamp(1, len).min(len - 1);
    let mean = series.iter().sum::<f64>() / len as f64;
    let n = (len + 2 * reach).next_power_of_two();
    let mut values = vec![[0.0; 2]; n];
    for (value, x) in values[reach..].iter_mut().zip(series) {
        value[0] = x - mean;
    }
    for k in 1..=reach {
        let fade = 0.5 + 0.5 * (0.5 * TAU * k as f64 / (reach + 1) as f64).cos();
        values[reach - k][0] = fade * (2.0 * first - series[k] - mean);
        values[reach + len - 1 + k][0] = fade * (2.0 * last - series[len - 1 - k] - mean);
    }
    transform(&mut values);
    for (j, value) in values.iter_mut().enumerate() {
        let gain = gain(j.min(n - j) as f64 / n as f64);
        // The inverse transform is that of the conjugate.
        *value = [gain * value[0], -gain * value[1]];
    }
    transform(&mut values);
    let constant = gain(0.0) * mean;
    values[reach..reach + len].iter().map(|v| v[0] / n as f64 + constant).collect()
}
