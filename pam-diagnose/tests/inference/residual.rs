//! Dependence, jumps, stability and the flexible reference, each where it is there and where it is not.

use crate::linear::{Experiment, Linear, coloured, combined, white};
use pam_diagnose::DiagnosisSettings;
use pam_diagnose::data::TestSource;
use pam_diagnose::noise::correlated_rows;
use pam_diagnose::rejection::ParameterStability;
use pam_diagnose::residual::{ChannelResidual, FlexibleModel, ResidualSummary};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

fn summary(experiments: Vec<Experiment>) -> ChannelResidual {
    let system = Linear::new(experiments);
    let settings = DiagnosisSettings::default();
    let problem = system.problem(0.01, &settings);
    let base = problem.base();
    ResidualSummary::of(&problem, &base, &base, &[0.01]).channels.remove(0)
}

fn share(of: &ChannelResidual, factor: &str) -> f64 {
    of.dependence.iter().find(|d| d.factor == factor).unwrap().share
}

/// `r = f² + e` with independent f and e of unit variance: Var f² = 2, so f explains 2/3 of the variance, less what twelve
/// groups average away; e explains nothing of it linearly but 1/3 as a factor. A factor that is not in it explains 0 ± 0.01.
#[test]
fn dependence_is_the_share_of_variance() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let experiments = (0..2)
        .map(|_| {
            let factors: Vec<Vec<f64>> = (0..3).map(|_| white(&mut random, 5000)).collect();
            let measured = factors[0].iter().zip(&factors[1]).map(|(f, e)| f * f + e).collect();
            Experiment { measured, factors, ..Experiment::default() }
        })
        .collect();
    let found = summary(experiments);
    let order: Vec<&str> = found.dependence.iter().map(|d| d.factor.as_str()).collect();
    assert_eq!(order[..2], ["factor 0", "factor 1"]);
    // Groups at the ends of a normal factor are wide: they average a good part of f² away.
    assert!(share(&found, "factor 0") > 0.5 && share(&found, "factor 0") < 2.0 / 3.0);
    assert!((share(&found, "factor 1") - 1.0 / 3.0).abs() < 0.03);
    assert!(share(&found, "factor 2") < 0.01 && share(&found, "recording") < 0.01);
    assert!(found.description.contains("factor 0") && !found.description.contains("factor 2"));
    // The mean of f² in the middle groups is that of the truth.
    let groups = &found.dependence[0].groups;
    assert_eq!(groups.len(), 12);
    assert!(groups[5..7].iter().all(|g| (g[1] - g[0] * g[0]).abs() < 0.1), "{groups:?}");
}

/// Two recordings of different mean: `recording` explains d²/4 over d²/4 + 1 for a difference d of the means.
#[test]
fn a_difference_between_recordings_is_a_dependence() {
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let experiments = [0.0, 2.0]
        .map(|mean| {
            let measured = white(&mut random, 4000).iter().map(|e| mean + e).collect();
            Experiment { measured, ..Experiment::default() }
        })
        .to_vec();
    let found = summary(experiments);
    assert!((share(&found, "recording") - 0.5).abs() < 0.03);
    assert!((found.mean - 1.0).abs() < 0.05);
    assert!((found.rms - 3.0_f64.sqrt()).abs() < 0.05, "{}", found.rms);
}

/// Correlation of neighbours: that of an autoregression is its coefficient.
#[test]
fn neighbours_correlate_as_they_were_made() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    for rho in [0.0, 0.6, 0.9] {
        let measured = coloured(&mut random, 20_000, rho);
        let found = summary(vec![Experiment { measured, ..Experiment::default() }]);
        assert!((found.next_correlation - rho).abs() < 0.03, "{rho}: {}", found.next_correlation);
    }
}

/// White noise is independent, and an autoregression counts as one observation in `(1 + ρ)/(1 − ρ)` rows. The correlation of
/// a rectangular wave of half period 20 falls linearly to zero at lag 10: 1 + 2 Σ (1 − k/10) = 10.
#[test]
fn correlation_is_counted_in_rows() {
    let settings = DiagnosisSettings::default().noise;
    let mut random = ChaCha8Rng::seed_from_u64(7);
    assert!(correlated_rows(&white(&mut random, 4000), &settings) < 1.2);
    for rho in [0.6_f64, 0.9] {
        let rows = correlated_rows(&coloured(&mut random, 100_000, rho), &settings);
        assert!((rows * (1.0 - rho) / (1.0 + rho) - 1.0).abs() < 0.15, "{rho}: {rows}");
    }
    let wave: Vec<f64> = (0..4000).map(|k| if k / 20 % 2 == 0 { 1.0 } else { -1.0 }).collect();
    let rows = correlated_rows(&wave, &settings);
    assert!((rows - 10.0).abs() < 0.5, "{rows}");
}

/// A step of the mean or of the size at 23 s of 60 s is found within a second, with the values before and after; noise,
/// white or correlated over 0.4 s, has no jump.
#[test]
fn a_jump_is_found_at_its_time() {
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let at = (23.0 / 0.02) as usize;
    let jump_of = |measured: Vec<f64>| {
        let found = summary(vec![Experiment { measured, ..Experiment::default() }]);
        (found.profiles[0].1.jump, found.description)
    };
    let stepped = |random: &mut ChaCha8Rng, mean: f64, size: f64| -> Vec<f64> {
        let noise = white(random, 3000);
        let value = |(k, e): (usize, &f64)| if k < at { *e } else { mean + size * e };
        noise.iter().enumerate().map(value).collect()
    };
    let (jump, description) = jump_of(stepped(&mut random, 4.0, 1.0));
    let jump = jump.expect("a step of the mean");
    assert!((jump.time_s - 23.0).abs() < 1.0, "{jump:?}");
    assert!(jump.before.abs() < 0.15 && (jump.after - 4.0).abs() < 0.15, "{jump:?}");
    assert!(description.contains("it changes at t = "), "{description}");
    let (jump, _) = jump_of(stepped(&mut random, 0.0, 5.0));
    let jump = jump.expect("a step of the size");
    assert!((jump.time_s - 23.0).abs() < 1.0, "{jump:?}");
    assert!((jump.rms_before - 1.0).abs() < 0.1 && (jump.rms_after - 5.0).abs() < 0.3, "{jump:?}");
    for seed in 0..100 {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        for rho in [0.0, 0.9] {
            let (jump, description) = jump_of(coloured(&mut random, 3000, rho));
            assert!(jump.is_none() && !description.contains("it changes"), "{rho}: {jump:?}");
        }
    }
    // A block of the profile is a second long; its size is that of the noise.
    let measured = white(&mut random, 3000);
    let found = summary(vec![Experiment { measured, ..Experiment::default() }]);
    let profile = &found.profiles[0].1;
    assert_eq!((profile.rms.len(), profile.time_s[1]), (60, 1.0));
    assert!(profile.rms.iter().all(|r| (r - 1.0).abs() < 0.45), "{:?}", profile.rms);
}

/// One column at work with the same slope in every part, and with one that turns its sign in the last third.
#[test]
fn a_slope_that_changes_is_not_stable() {
    let settings = DiagnosisSettings::default();
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for (last, stable) in [(2.0, true), (-2.0, false)] {
        let experiments = (0..2)
            .map(|_| {
                let columns = vec![white(&mut random, 600)];
                let mut measured = combined(&columns, &[2.0], &white(&mut random, 600), 0.5);
                for k in 400..600 {
                    measured[k] += (last - 2.0) * columns[0][k];
                }
                Experiment { columns, measured, ..Experiment::default() }
            })
            .collect();
        let system = Linear::new(experiments);
        let problem = system.problem(0.5, &settings);
        let fit = problem.fit(problem.base().with(0, &[0.1]), 20).unwrap();
        let intervals = problem.intervals(&fit).unwrap();
        let found = ParameterStability::of(&problem, &fit.hypothesis, 0, &intervals).unwrap();
        assert_eq!(found.parts.len(), 6);
        for (name, start_s, value) in &found.parts {
            let truth = if *start_s > 7.9 { last } else { 2.0 };
            // A third has 200 rows: σ/√200 = 0.035.
            assert!((value - truth).abs() < 0.15, "{name} from {start_s} s: {value}, true {truth}");
        }
        // Quartiles at −2 and 2: half their distance is 2.
        let spread = found.relative_spread * fit.hypothesis.members[0].values[0].abs();
        assert!((spread - if stable { 0.0 } else { 2.0 }).abs() < 0.1, "{spread}");
        // Half the interval of a mean of six, by the scatter of the parts: t(5) s/√6.
        let most = if stable { 2.57 * 0.035 / 6.0_f64.sqrt() * 3.0 } else { f64::INFINITY };
        assert!(found.half_widths[0] < most, "{:?}", found.half_widths);
        assert!(stable || found.half_widths[0] > 1.0, "{:?}", found.half_widths);
    }
}

/// The flexible model removes what its features span and leaves the noise; with features that are not in it, it removes
/// nothing. Its effective number of weights is that of its columns, and what they took of the noise is given back.
#[test]
fn the_flexible_model_leaves_what_its_features_do_not_span() {
    for (known, left) in [(true, 1.0), (false, 10.0)] {
        let mut random = ChaCha8Rng::seed_from_u64(6);
        let (z, other) = (white(&mut random, 1500), white(&mut random, 1500));
        // Error of 9 + 1 times the variance of the noise.
        let residual = combined(std::slice::from_ref(&z), &[3.0], &white(&mut random, 1500), 1.0);
        let features = vec![if known { z } else { other }, vec![1.0; 1500]];
        let model = FlexibleModel::learn(&features, &residual, 1e-9, f64::INFINITY).unwrap();
        assert!((model.weight_count - 2.0).abs() < 1e-6, "{}", model.weight_count);
        let rest = model.left(&features, &residual);
        let mean_square = rest.iter().map(|r| r * r).sum::<f64>() / 1500.0;
        assert!((mean_square / left - 1.0).abs() < 0.15, "{known}: {mean_square}");
    }
}

/// The parts of the data of a system whose test set is whole recordings end nowhere.
#[test]
fn open_parts_of_whole_recordings_have_no_end() {
    let settings = DiagnosisSettings::default();
    let one = Experiment { measured: vec![0.0; 600], ..Experiment::default() };
    let system = Linear::new(vec![one; 3]);
    let roles = system.roles(TestSource::Absent, 1, &settings);
    assert_eq!(roles.open(), system.open());
}
