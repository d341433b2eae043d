//! Fourier transforms against their definition, and filters against sums of sines.

use pam_numerics::fourier::{outside_band, power_of_pieces};
use std::f64::consts::TAU;

#[test]
fn power_is_that_of_the_sum_of_its_definition() {
    for n in [2, 8, 32] {
        let series: Vec<f64> =
            (0..n).map(|k| (k as f64 * 0.7).sin() + (k as f64 * 1.3).cos()).collect();
        let mean = series.iter().sum::<f64>() / n as f64;
        let fast = &power_of_pieces(&series, n)[0];
        assert_eq!(fast.len(), n / 2 + 1);
        for (j, fast) in fast.iter().enumerate() {
            let mut sum = [0.0; 2];
            for (k, value) in series.iter().enumerate() {
                let window = 0.5 - 0.5 * (TAU * k as f64 / n as f64).cos();
                let (s, c) = (-TAU * (j * k) as f64 / n as f64).sin_cos();
                sum = [sum[0] + window * (value - mean) * c, sum[1] + window * (value - mean) * s];
            }
            assert!((fast - sum[0] * sum[0] - sum[1] * sum[1]).abs() < 1e-12 * (n * n) as f64);
        }
    }
}

#[test]
fn part_outside_a_band_is_right_up_to_the_ends() {
    let sine = |cycles: f64, k: usize| (TAU * cycles * k as f64 + 0.4).sin();
    let slow = |k: usize| 5.0 + sine(0.01, k) + 0.5 * sine(0.0123, k);
    let both: Vec<f64> = (0..3000).map(|k| slow(k) + 0.01 * sine(0.08, k)).collect();
    let band = |f: f64| if f < 0.03 { 1.0 } else { 0.0 };
    let fast = outside_band(&both, 500, 1e-6, band);
    for (k, v) in fast.iter().enumerate() {
        // A signal of the band may take about as much of the last samples as the other one has.
        let most = if (60..2940).contains(&k) { 3e-4 } else { 0.015 };
        assert!((v - 0.01 * sine(0.08, k)).abs() < most, "{k}: {v}");
    }
    let all = outside_band(&both, 500, 1e-6, |_| 0.0);
    let mean = both.iter().sum::<f64>() / 3000.0;
    assert!(all.iter().zip(&both).all(|(a, b)| (a - (b - mean)).abs() < 1e-12));
    assert!(outside_band(&[], 5, 1e-6, band).is_empty());
    assert_eq!(outside_band(&[3.0; 40], 5, 1e-6, band), [0.0; 40]);
}

/// Half a period of a sine has a mean, which is a part of the sine and no steady value beside it.
#[test]
fn a_sine_that_ends_within_a_period_leaves_no_offset() {
    let sine = |k: usize| (TAU * 0.01 * k as f64).sin();
    let other = |k: usize| 0.01 * (TAU * 0.08 * k as f64 + 0.4).sin();
    let series: Vec<f64> = (0..3050).map(|k| 100.0 * sine(k) + other(k)).collect();
    let band = |f: f64| if (0.008..0.012).contains(&f) { 1.0 } else { 0.0 };
    let left = outside_band(&series, 500, 1e-6, band);
    assert!((series.iter().sum::<f64>() / 3050.0).abs() > 1.0);
    for (k, left) in left.iter().enumerate().take(2750).skip(300) {
        assert!((left - other(k)).abs() < 0.03, "{k}: {left}");
    }
}

#[test]
fn power_has_its_peak_at_the_sine() {
    let series: Vec<f64> = (0..4096).map(|k| 3.0 + (TAU * 0.125 * k as f64).sin()).collect();
    let pieces = power_of_pieces(&series, 256);
    // Pieces overlap by half.
    assert_eq!(pieces.len(), 31);
    let power: Vec<f64> = (0..129).map(|j| pieces.iter().map(|p| p[j]).sum()).collect();
    let peak = (0..power.len()).max_by(|&a, &b| power[a].total_cmp(&power[b])).unwrap();
    assert_eq!((pieces[30].len(), peak), (129, 32));
    assert!(power[0] < 1e-9 * power[32] && power[64] < 1e-9 * power[32]);
    assert!(power_of_pieces(&series[..100], 256).is_empty());
}
