//! The search against the best subset by enumeration.

use crate::linear::{Experiment, Linear, combined, white};
use pam_diagnose::DiagnosisSettings;
use pam_diagnose::data::{Split, TestSource};
use pam_diagnose::search::{Candidates, search};
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};

const SIGMA: f64 = 0.5;
const COLUMNS: usize = 8;

/// Three runs of 250 rows; neighbouring columns are correlated by `rho`.
fn regression(slopes: &[f64], rho: f64, seed: u64) -> Linear {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let experiments = (0..3)
        .map(|_| {
            let mut columns: Vec<Vec<f64>> =
                (0..COLUMNS).map(|_| white(&mut random, 250)).collect();
            for j in 1..COLUMNS {
                let (before, after) = columns.split_at_mut(j);
                let new = (1.0 - rho * rho).sqrt();
                after[0].iter_mut().zip(&before[j - 1]).for_each(|(x, b)| *x = rho * b + new * *x);
            }
            let measured = combined(&columns, slopes, &white(&mut random, 250), SIGMA);
            let features = columns.clone();
            Experiment { columns, measured, features, ..Experiment::default() }
        })
        .collect();
    Linear::new(experiments)
}

/// Solves `A x = b` by Gauss's elimination with pivots.
fn solved(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs())).unwrap();
        a.swap(k, pivot);
        b.swap(k, pivot);
        for i in k + 1..n {
            let f = a[i][k] / a[k][k];
            let (above, below) = a.split_at_mut(i);
            below[0][k..].iter_mut().zip(&above[k][k..]).for_each(|(x, p)| *x -= f * p);
            b[i] -= f * b[k];
        }
    }
    for k in (0..n).rev() {
        let sum: f64 = (k + 1..n).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - sum) / a[k][k];
    }
    b
}

/// Minus two times the log-posterior of a subset that is fitted by ordinary least squares to the training rows: the sums of
/// squares of training and validation rows over σ², with `p ln n` for `p` columns and `2 ln K` for the choice of each.
fn total(system: &Linear, split: &Split<'_, dyn Candidates + '_>, subset: &[usize]) -> f64 {
    let rows = |which: &[usize], of: &dyn Fn(&Experiment) -> Vec<f64>| -> Vec<f64> {
        which.iter().flat_map(|&e| of(&system.experiments[e])).collect()
    };
    let (train, validation) = (&split.train.experiments, &split.validation.experiments);
    let columns = |which: &[usize]| -> Vec<Vec<f64>> {
        subset.iter().map(|&j| rows(which, &|e| e.columns[j].clone())).collect()
    };
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (x, y) = (columns(train), rows(train, &|e| e.measured.clone()));
    let gram = x.iter().map(|a| x.iter().map(|b| dot(a, b)).collect()).collect();
    let slopes = solved(gram, x.iter().map(|a| dot(a, &y)).collect());
    let cost = |which: &[usize]| {
        let (x, mut r) = (columns(which), rows(which, &|e| e.measured.clone()));
        for (x, slope) in x.iter().zip(&slopes) {
            r.iter_mut().zip(x).for_each(|(r, x)| *r -= slope * x);
        }
        dot(&r, &r) / (SIGMA * SIGMA)
    };
    cost(train)
        + cost(validation)
        + subset.len() as f64 * (750.0_f64.ln() + 2.0 * (COLUMNS as f64).ln())
}

/// The subset of at most three columns with the lowest total.
fn enumerated(system: &Linear, split: &Split<'_, dyn Candidates + '_>) -> (Vec<usize>, f64) {
    let subsets = (0_u32..1 << COLUMNS).filter(|s| s.count_ones() <= 3);
    subsets
        .map(|s| {
            let subset: Vec<usize> = (0..COLUMNS).filter(|j| s >> j & 1 == 1).collect();
            let total = total(system, split, &subset);
            (subset, total)
        })
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .unwrap()
}

/// Growing and shrinking finds the best of all 93 subsets, with the same likelihood to rounding, for none to three columns at
/// work, uncorrelated and correlated.
#[test]
fn the_best_subset_is_found() {
    let settings = DiagnosisSettings::default();
    let mut sizes = [0; 4];
    for seed in 0..60_u64 {
        let mut random = ChaCha8Rng::seed_from_u64(1000 + seed);
        let rho = [0.0, 0.7, 0.9][(seed % 3) as usize];
        let size = (seed / 3 % 4) as usize;
        let mut all: Vec<usize> = (0..COLUMNS).collect();
        all.shuffle(&mut random);
        let mut slopes = [0.0; COLUMNS];
        for j in &all[..size] {
            let sign = if random.random_bool(0.5) { 1.0 } else { -1.0 };
            slopes[*j] = sign * random.random_range(1.5..4.0);
        }
        let system = regression(&slopes, rho, seed);
        let roles = system.roles(TestSource::Absent, seed, &settings);
        let mut rows = system.rows(&roles, 1e-9, &settings);
        assert_eq!((rows.choosing.train.len(), rows.choosing.validation.len()), (2, 1));
        let (best, _) = enumerated(&system, &rows.choosing);
        let found = search(&mut rows, 3, 1, &|_| {}).unwrap();
        assert_eq!(found.best.hypothesis().set(), best, "seed {seed}, {slopes:?}");
        let mut truth = all[..size].to_vec();
        truth.sort_unstable();
        assert_eq!(best, truth, "seed {seed}");
        sizes[size] += 1;
    }
    assert_eq!(sizes, [15; 4]);
}

/// Two columns that correlate by 0.98 and act against each other: alone either explains a hundredth of what both do
/// (its correlation with the difference is √((1 − ρ)/2)), and the pair is found.
#[test]
fn a_pair_is_found_of_which_neither_shows_alone() {
    let settings = DiagnosisSettings::default();
    for seed in 0..10 {
        let slopes = [0.0, 0.0, 0.0, 10.0, -10.0];
        let system = regression(&slopes, 0.98, seed);
        let roles = system.roles(TestSource::Absent, seed, &settings);
        let mut rows = system.rows(&roles, 1e-9, &settings);
        let found = search(&mut rows, 3, 1, &|_| {}).unwrap();
        let alone = |j: usize| found.screened.iter().find(|s| s.0 == j).unwrap().1;
        assert!(alone(3) < 0.05 && alone(4) < 0.05, "{} {}", alone(3), alone(4));
        assert_eq!(found.best.hypothesis().set(), [3, 4], "seed {seed}");
        assert_eq!(enumerated(&system, &rows.choosing).0, [3, 4], "seed {seed}");
        for member in &found.best.hypothesis().members {
            let slope = if member.candidate == 3 { 10.0 } else { -10.0 };
            assert!((member.values[0] - slope).abs() < 1.0, "{member:?}");
        }
    }
}

/// Without a column at work, nothing is chosen, correlated columns or not, in all but one of twenty cases.
#[test]
fn nothing_is_chosen_where_no_column_is_at_work() {
    let settings = DiagnosisSettings::default();
    let chosen = (0..100_u64)
        .filter(|&seed| {
            let system = regression(&[], [0.0, 0.9][seed as usize % 2], seed);
            let roles = system.roles(TestSource::Absent, seed, &settings);
            let mut rows = system.rows(&roles, 1e-9, &settings);
            let found = search(&mut rows, 3, seed, &|_| {}).unwrap();
            assert_eq!(found.screened.len(), COLUMNS);
            found.best.members() > 0
        })
        .count();
    assert!(chosen <= 5, "{chosen} of 100");
}
