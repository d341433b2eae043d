//! Coverage: how often a 95 % interval holds the truth.

use crate::linear::{Experiment, Linear, binomial_range, coloured, combined, white};
use pam_diagnose::DiagnosisSettings;
use pam_diagnose::data::TestSource;
use pam_diagnose::fit::Interval;
use pam_diagnose::search::Nuisance;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rayon::prelude::*;

const SLOPE: f64 = 0.8;

/// Three runs of 600 rows in which the first of two smooth columns is at work, with noise of unit variance.
fn runs(rho: f64, seed: u64) -> Linear {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let experiments = (0..3)
        .map(|_| {
            let columns = vec![coloured(&mut random, 600, 0.9), coloured(&mut random, 600, 0.9)];
            let measured = combined(&columns, &[SLOPE], &coloured(&mut random, 600, rho), 1.0);
            Experiment { columns, measured, ..Experiment::default() }
        })
        .collect();
    Linear::new(experiments).with_offset(1.0)
}

fn covered(each: impl Fn(u64) -> Option<Interval> + Sync, count: u64) -> [usize; 2] {
    let held: Vec<bool> = (0..count)
        .into_par_iter()
        .filter_map(|seed| each(seed).map(|i| i.contains(SLOPE)))
        .collect();
    [held.iter().filter(|h| **h).count(), held.len()]
}

/// The quadrature of independent errors, in the coordinate of the parameter.
#[test]
fn widening_adds_in_quadrature() {
    use pam_effects::effects::ParameterInfo;
    let interval = Interval { value: 10.0, ci95: [7.0, 13.0] };
    let wide = interval.widened(4.0, ParameterInfo::linear("force_n", [0.0, 50.0]));
    assert!((wide.ci95[0] - 5.0).abs() < 1e-12 && (wide.ci95[1] - 15.0).abs() < 1e-12);
    let ratio = 3.0_f64.exp();
    let scale = Interval { value: 2.0, ci95: [2.0 / ratio, 2.0 * ratio] };
    let wide = scale.widened(4.0, ParameterInfo::scale("time_s", [1e-3, 1e3]));
    let five = 5.0_f64.exp();
    assert!((wide.ci95[1] / (2.0 * five) - 1.0).abs() < 1e-12, "{wide:?}");
    assert!((wide.ci95[0] / (2.0 / five) - 1.0).abs() < 1e-12, "{wide:?}");
}

/// The column is nearly collinear with an offset of at most 0.3, and the true offset is at this limit. Where the fitted offset is below it,
/// the slope at the limit is the end of its interval, and the truth is around that end: the noise belongs beyond it, not in quadrature.
#[test]
fn an_interval_holds_the_truth_where_a_nuisance_is_at_its_limit() {
    let settings = DiagnosisSettings::default();
    let fitted = |seed: u64| {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let raised = |v: f64| 1.0 + 0.05 * v;
        let column: Vec<f64> = white(&mut random, 1200).into_iter().map(raised).collect();
        let noise = white(&mut random, 1200);
        let measured = column.iter().zip(noise).map(|(x, e)| SLOPE * x + 0.3 + 0.05 * e).collect();
        let columns = vec![column];
        let run = Experiment { columns, measured, ..Experiment::default() };
        let offset = Nuisance { deviation: 100.0, limits: [-0.3, 0.3] };
        let system = Linear::new(vec![run]).with_shared_offset(offset);
        let problem = system.problem(0.05, &settings);
        let fit = problem.fit(problem.base().with(0, &[0.1]), 20).ok()?;
        Some(problem.intervals(&fit).ok()?[0])
    };
    let [held, all] = covered(fitted, 400);
    assert!(all == 400 && held >= binomial_range(all, 0.95, 1e-3)[0], "{held} of {all}");
}

/// The model error is a random linear combination of six features, one of which is the column of the cause, and there are no baseline
/// recordings. The fit absorbs this one; its size is estimated from the other five, which remain in the residual.
#[test]
fn intervals_hold_the_truth_beside_a_wrong_model() {
    let settings = DiagnosisSettings::default();
    let named = |seed| {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let errors: Vec<f64> = white(&mut random, 6).iter().map(|e| 0.1 * e).collect();
        let experiments = (0..3)
            .map(|_| {
                let features: Vec<Vec<f64>> =
                    (0..6).map(|_| coloured(&mut random, 600, 0.9)).collect();
                let columns = vec![features[0].clone()];
                let right = combined(&columns, &[SLOPE], &white(&mut random, 600), 0.3);
                let measured = combined(&features, &errors, &right, 1.0);
                Experiment { columns, features, measured, ..Experiment::default() }
            })
            .collect();
        let system = Linear::new(experiments).with_offset(1.0);
        let d = system.diagnosed(TestSource::Absent, 0.1, None, &settings, seed);
        Some(d.causes.iter().find(|c| c.effect == "x0")?.parameters[0].1)
    };
    let [held, all] = covered(named, 200);
    println!("{held} of {all}, {:?}", binomial_range(all, 0.95, 1e-3));
    assert!(all > 190, "named in {all}");
    assert!(held >= binomial_range(all, 0.95, 1e-3)[0], "{held} of {all}");
}

/// Run by `cargo test --release --workspace --tests -- --ignored long::`.
mod long {
    use super::*;

    /// Intervals from the scatter of the residuals alone: of 1000, with 45 blocks, as many hold the truth as a binomial
    /// variable of 95 % (all but one in 1000 on either side), where a block holds ten correlation times of the noise or more.
    /// Where it holds two (ρ = 0.9, blocks of L = 40), neighbouring blocks share a part of the noise, `2 a/(L (1 − a²)) = 12 %`
    /// of the variance with `a = 0.9 ρ`; so the intervals have 94 % of their width, which hold the truth in 93.4 %.
    #[test]
    #[ignore = "long"]
    fn clustered_intervals_hold_the_truth_at_their_level() {
        let settings = DiagnosisSettings::default();
        for rho in [0.0, 0.6, 0.9] {
            let fitted = |seed| {
                let system = runs(rho, seed);
                let mut problem = system.problem(1.0, &settings);
                problem.rows_per_observation = (1.0 + rho) / (1.0 - rho);
                let fit = problem.fit(problem.base().with(0, &[0.1]), 20).ok()?;
                Some(problem.intervals(&fit).ok()?[0])
            };
            let [held, all] = covered(fitted, 1000);
            println!("AR({rho}): {held} of {all}, {:?}", binomial_range(all, 0.95, 1e-3));
            let [low, high] = binomial_range(all, if rho < 0.9 { 0.95 } else { 0.934 }, 1e-3);
            assert!(all == 1000 && (low..=high).contains(&held), "AR({rho}): {held} of {all}");
        }
    }

    /// The intervals of a diagnosis are widened by the spread between parts: they hold the truth in at least 95 % (of 300 no
    /// fewer than a binomial variable falls to once in 1000), and they are not wider than twice what the noise alone makes
    /// of them.
    #[test]
    #[ignore = "long"]
    fn widened_intervals_hold_the_truth_at_least_at_their_level() {
        let settings = DiagnosisSettings::default();
        for rho in [0.0, 0.6, 0.9] {
            let named = |seed| {
                let system = runs(rho, seed);
                let d = system.diagnosed(TestSource::Absent, 0.5, None, &settings, seed);
                let cause = d.causes.iter().find(|c| c.effect == "x0")?;
                Some(cause.parameters[0].1)
            };
            let [held, all] = covered(named, 300);
            println!("AR({rho}): {held} of {all}, {:?}", binomial_range(all, 0.95, 1e-3));
            assert!(all > 290, "AR({rho}): named in {all}");
            assert!(held >= binomial_range(all, 0.95, 1e-3)[0], "AR({rho}): {held} of {all}");
            let widths: Vec<f64> =
                (0..20).filter_map(|seed| named(seed).map(|i| i.ci95[1] - i.ci95[0])).collect();
            let mean = widths.iter().sum::<f64>() / widths.len() as f64;
            // The variance of the slope by generalised least squares: (1 − ρ²)/Σ (x_k − ρ x_{k−1})², with
            // E x_k x_{k−1} = 0.9.
            let factor = (1.0 - rho * rho) / (1.0 + rho * rho - 2.0 * 0.9 * rho);
            let from_noise = 2.0 * 1.96 * (factor / 1800.0).sqrt();
            println!("AR({rho}): {mean} wide, {from_noise} from the noise alone");
            assert!(
                mean > from_noise && mean < 2.0 * from_noise,
                "AR({rho}): {mean}, {from_noise}"
            );
        }
    }
}
