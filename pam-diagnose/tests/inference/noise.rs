//! Noise: fitted autoregressions against the processes that made the series, and whitening against its definition.

use crate::linear::{Experiment, Linear, coloured, combined, white};
use pam_diagnose::DiagnosisSettings;
use pam_diagnose::noise::{
    Autoregression, Covariances, Discrepancy, Noise, NoisePrior, autocovariance,
};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

fn mean_square(rows: &[f64]) -> f64 {
    rows.iter().map(|r| r * r).sum::<f64>() / rows.len() as f64
}

/// The autocovariances `ρ^k` are those of a first-order autoregression: order one, coefficient ρ, innovations of variance
/// `1 − ρ²`, correlated over `(1 + ρ)/(1 − ρ)` rows.
#[test]
fn exact_autocovariances_give_the_process() {
    for rho in [-0.5_f64, 0.0, 0.6, 0.96] {
        let gamma: Vec<f64> = (0..9).map(|k| rho.powi(k)).collect();
        let noise = Autoregression::of_autocovariance(&gamma, 1e4);
        assert_eq!(noise.order(), usize::from(rho != 0.0), "{rho}");
        assert!((noise.deviation() - 1.0).abs() < 1e-12);
        let rows = ((1.0 + rho) / (1.0 - rho)).max(1.0);
        assert!((noise.correlated_rows() / rows - 1.0).abs() < 1e-9, "{rho}");
        // The first row has no predecessor, the second one has one.
        let whitened = noise.whitened(&[2.0, 3.0, 5.0]);
        let s = (1.0 - rho * rho).sqrt();
        for (w, expected) in
            whitened.iter().zip([2.0, (3.0 - 2.0 * rho) / s, (5.0 - 3.0 * rho) / s])
        {
            assert!((w - expected).abs() < 1e-12, "{rho}: {w} {expected}");
        }
    }
}

/// The second-order process `e_k = a e_{k−1} + b e_{k−2} + w_k` has the autocovariances of its Yule–Walker equations,
/// `ρ_1 = a/(1 − b)`, `ρ_k = a ρ_{k−1} + b ρ_{k−2}`; whitening recovers the w_k.
#[test]
fn a_second_order_process_is_whitened_to_its_innovations() {
    let (a, b) = (1.2, -0.5);
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let w = white(&mut random, 5000);
    let mut e = vec![0.0; w.len()];
    for k in 0..w.len() {
        let before = |j: usize| if k >= j { e[k - j] } else { 0.0 };
        e[k] = a * before(1) + b * before(2) + w[k];
    }
    let mut rho = vec![1.0, a / (1.0 - b)];
    for k in 2..8 {
        rho.push(a * rho[k - 1] + b * rho[k - 2]);
    }
    let variance = 1.0 / (1.0 - a * rho[1] - b * rho[2]);
    let gamma: Vec<f64> = rho.iter().map(|r| r * variance).collect();
    let noise = Autoregression::of_autocovariance(&gamma, 5000.0);
    assert_eq!(noise.order(), 2);
    for (white, w) in noise.whitened(&e).iter().zip(&w).skip(2) {
        assert!((white - w).abs() < 1e-9);
    }
    // From the series itself, with the error of 5000 rows.
    let learned = Autoregression::of_autocovariance(&autocovariance(&[&e], 8), 5000.0);
    assert!((mean_square(&learned.whitened(&e)) - 1.0).abs() < 0.05);
}

/// What is learned of a residual is the noise that made it, whether it is white or coloured, and whether or not there is a
/// motion in it that the features span.
#[test]
fn the_noise_is_learned_beside_a_motion() {
    let settings = DiagnosisSettings::default();
    for (rho, motion) in [(0.0, 0.0), (0.9, 0.0), (0.9, 5.0)] {
        let mut random = ChaCha8Rng::seed_from_u64(2);
        let experiments = (0..3)
            .map(|_| {
                let features: Vec<Vec<f64>> =
                    (0..3).map(|_| coloured(&mut random, 2000, 0.9)).collect();
                let noise = coloured(&mut random, 2000, rho);
                let measured = combined(&features[..1], &[motion], &noise, 0.5);
                Experiment {
                    columns: vec![features[1].clone()],
                    measured,
                    features,
                    ..Experiment::default()
                }
            })
            .collect();
        let system = Linear::new(experiments);
        let problem = system.problem(0.01, &settings);
        let base = problem.base();
        let prior = NoisePrior::at_least(vec![1e-9]);
        let noise = Noise::learned(&problem, &base, &prior).unwrap();
        assert!((noise.deviation(0) / 0.5 - 1.0).abs() < 0.1, "{rho}: {}", noise.deviation(0));
        let rows = noise.channel(0).correlated_rows();
        let expected = (1.0 + rho) / (1.0 - rho);
        assert!((rows / expected - 1.0).abs() < 0.35, "{rho}: {rows} {expected}");
        // A known discrepancy joins, and no noise is below the least.
        let known = NoisePrior {
            discrepancy: Discrepancy {
                covariances: Covariances::independent(vec![vec![0.75]]),
                ..Discrepancy::default()
            },
            ..prior.clone()
        };
        let noise = Noise::learned(&problem, &base, &known).unwrap();
        assert!((noise.deviation(0) - 1.0).abs() < 0.05, "{}", noise.deviation(0));
        let noise = Noise::learned(&problem, &base, &NoisePrior::at_least(vec![2.0])).unwrap();
        assert!((noise.deviation(0) - 2.0).abs() < 1e-9);
        // Of a noise whose size is given, the correlation is learned.
        let given = NoisePrior { given: vec![Some(3.0)], ..prior };
        let noise = Noise::learned(&problem, &base, &given).unwrap();
        assert!((noise.deviation(0) - 3.0).abs() < 1e-9, "{}", noise.deviation(0));
        assert!((noise.channel(0).correlated_rows() / rows - 1.0).abs() < 1e-9);
    }
}

/// Slow noise that is learned from few rows beside slow features is underestimated, since the features imitate it. Cross-validation tells by
/// how much: its level is that of rows which the noise has not seen, within the spread of such levels. Of many rows it is 1.
#[test]
fn few_rows_tell_how_the_noise_describes_others() {
    let settings = DiagnosisSettings::default();
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut learned = |rows: usize| {
        let features = (0..20).map(|_| coloured(&mut random, rows, 0.95)).collect();
        let measured = coloured(&mut random, rows, 0.9);
        let columns = vec![white(&mut random, rows)];
        let system =
            Linear::new(vec![Experiment { columns, measured, features, ..Experiment::default() }]);
        let problem = system.problem(0.01, &settings);
        let prior = NoisePrior::at_least(vec![1e-9]);
        let noise = Noise::learned(&problem, &problem.base(), &prior).unwrap();
        let others = noise.whitened(0, &[coloured(&mut random, 500, 0.9)]);
        (noise.unseen_level(0), mean_square(&others[0]))
    };
    let mut all: Vec<_> = (0..101).map(|_| learned(80)).collect();
    all.sort_by(|a, b| a.0.median.total_cmp(&b.0.median));
    let told = all[50].0.median;
    all.sort_by(|a, b| a.1.total_cmp(&b.1));
    let is = all[50].1;
    assert!(is > 1.3, "{is}");
    assert!((0.6..1.7).contains(&(told / is)), "{told} {is}");
    assert!(all.iter().all(|(level, _)| level.mean >= 1.0 && level.median >= 1.0));
    let (level, is) = learned(4000);
    assert_eq!((level.median, level.mean), (1.0, 1.0));
    assert!((is - 1.0).abs() < 0.2, "{is}");
}

/// The covariances of sums of channels are those of the summed rows, whatever the weights, and add up over recordings.
#[test]
fn covariances_of_sums_are_those_of_summed_rows() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let a = coloured(&mut random, 400, 0.8);
    let own = coloured(&mut random, 400, 0.3);
    let b: Vec<f64> = a.iter().zip(&own).map(|(a, own)| 3.0 * a + own).collect();
    let both = Covariances::of_rows(&[vec![&a], vec![&b]], 5);
    let sum = |weights: [f64; 2]| -> Vec<f64> {
        a.iter().zip(&b).map(|(a, b)| weights[0] * a + weights[1] * b).collect()
    };
    let near = |found: &[f64], expected: &[f64]| {
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(expected) {
            assert!(
                (found - expected).abs() < 1e-10 * (1.0 + expected.abs()),
                "{found} {expected}"
            );
        }
    };
    for weights in [[1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [-3.0, 1.0], [0.4, -2.0]] {
        near(&both.of_sum(&weights), &autocovariance(&[&sum(weights)], 5));
        // With another sum at lag 0.
        let products = sum(weights).iter().zip(&b).map(|(s, b)| s * b).sum::<f64>() / 400.0;
        near(&both.of_sums(&weights, &[0.0, 1.0])[..1], &[products]);
    }
    let mut twice = Covariances::independent(vec![vec![1.0], vec![1.0]]);
    twice.add(&both, 2.0);
    let expected = autocovariance(&[&sum([-3.0, 1.0])], 5);
    let mut expected: Vec<f64> = expected.iter().map(|g| 2.0 * g).collect();
    expected[0] += 10.0;
    near(&twice.of_sum(&[-3.0, 1.0]), &expected);
    near(&twice.deviations()[..1], &[(1.0 + 2.0 * autocovariance(&[&a], 0)[0]).sqrt()]);
}
