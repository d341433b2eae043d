//! The verdict's truth table: first the rule between its numbers, then what comes in before it.

use crate::linear::{Experiment, Linear, coloured, combined, white};
use pam_diagnose::data::TestSource;
use pam_diagnose::diagnosis::Diagnosis;
use pam_diagnose::verdict::VerdictInput;
use pam_diagnose::{DiagnosisSettings, Verdict};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

/// Each combination of what the rule reads.
#[test]
fn the_rule_has_one_outcome_for_each_combination() {
    use Verdict::{
        Explained, ModelInadequate, NothingFound, PartlyExplained, Unconfirmed, Unexplained,
    };
    let settings = DiagnosisSettings::default().verdict;
    let none = VerdictInput::default();
    let good = VerdictInput { causes: 1, confirmed: true, reduced: true, named_share: 1.0, ..none };
    let rows = [
        (none, NothingFound),
        (VerdictInput { left: true, ..none }, Unexplained),
        (VerdictInput { inadequate: true, left: true, ..none }, ModelInadequate),
        (good, Explained),
        (VerdictInput { causes: 3, ..good }, Explained),
        (VerdictInput { named_share: 0.25, ..good }, Explained), // the bound itself is enough
        (VerdictInput { named_share: 0.24, left: true, ..good }, Unexplained),
        // An error within the noise need not be removed.
        (VerdictInput { named_share: 0.24, ..good }, Explained),
        (VerdictInput { left: true, ..good }, PartlyExplained),
        (VerdictInput { doubtful: true, ..good }, PartlyExplained),
        (VerdictInput { reduced: false, ..good }, PartlyExplained),
        (VerdictInput { confirmed: false, ..good }, Unconfirmed),
        // Test data that cannot tell are not against it.
        (VerdictInput { confirmed: false, untested: true, ..good }, PartlyExplained),
        (VerdictInput { untested: true, ..none }, NothingFound),
        (VerdictInput { confirmed: false, left: true, named_share: 0.0, ..good }, Unconfirmed),
    ];
    for (evidence, verdict) in rows {
        assert_eq!(Verdict::of(evidence, &settings), verdict, "{evidence:?}");
    }
    let all = [NothingFound, Explained, PartlyExplained, Unexplained, Unconfirmed, ModelInadequate];
    let words = all.map(|v| {
        assert_eq!(serde_json::to_value(v).unwrap(), v.to_string());
        v.to_string()
    });
    assert_eq!(words[..2], ["nothing_found", "explained"]);
    assert_eq!(words[2..], ["partly_explained", "unexplained", "unconfirmed", "model_inadequate"]);
}

/// Three runs of 400 rows with noise of unit variance: `y = Σ θ_j x_j + u z + e`, with four candidate columns and a column
/// `z` that is none of them, but a feature of the flexible model.
fn runs(slopes: [f64; 4], unlisted: f64, seed: u64) -> Linear {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let experiments = (0..3)
        .map(|_| {
            let columns: Vec<Vec<f64>> = (0..4).map(|_| coloured(&mut random, 400, 0.5)).collect();
            let other = coloured(&mut random, 400, 0.5);
            let mut measured = combined(&columns, &slopes, &white(&mut random, 400), 1.0);
            measured.iter_mut().zip(&other).for_each(|(y, z)| *y += unlisted * z);
            let features = columns.iter().cloned().chain([other]).collect();
            Experiment { columns, measured, features, ..Experiment::default() }
        })
        .collect();
    Linear::new(experiments)
}

fn diagnosed(system: &Linear) -> Diagnosis<()> {
    system.diagnosed(TestSource::Absent, 1.0, None, &DiagnosisSettings::default(), 1)
}

/// With θ and u the error above the noise is θ² + u² times the noise's variance, of which θ²/(θ² + u²) has a name.
#[test]
fn the_outcome_follows_from_what_is_hidden() {
    use Verdict::{Explained, NothingFound, PartlyExplained, Unexplained};
    let nothing: &[&str] = &[];
    let rows = [
        ([0.0; 4], 0.0, NothingFound, nothing),
        ([5.0, 0.0, 0.0, 0.0], 0.0, Explained, &["x0"]),
        ([5.0, 0.0, -4.0, 0.0], 0.0, Explained, &["x0", "x2"]), // the larger share first
        ([5.0, 0.0, 0.0, 0.0], 1.5, Explained, &["x0"]),        // 92 %
        ([5.0, 0.0, 0.0, 0.0], 4.0, PartlyExplained, &["x0"]),  // 61 %
        ([5.0, 0.0, 0.0, 0.0], 7.0, PartlyExplained, &["x0"]),  // 34 %
        ([5.0, 0.0, 0.0, 0.0], 14.0, Unexplained, nothing),     // 11 %
        ([0.0; 4], 5.0, Unexplained, nothing),
    ];
    for (slopes, unlisted, verdict, names) in rows {
        let d = diagnosed(&runs(slopes, unlisted, 3));
        assert_eq!((d.verdict, d.named()), (verdict, names.to_vec()), "{slopes:?}, {unlisted}");
        let all: f64 = slopes.iter().map(|s| s * s).sum::<f64>() + unlisted * unlisted;
        for cause in &d.causes {
            let place = cause.effect[1..].parse::<usize>().unwrap();
            let own = slopes[place] * slopes[place];
            let share = own / all;
            assert!((cause.share_of_error_removed - share).abs() < 0.12, "{cause:?}, {share}");
            assert!(cause.confusable_with.is_empty(), "{:?}", cause.confusable_with);
        }
    }
}

/// A term that is at work in the first two thirds of each recording only: it is named, with the time at which it ends and its
/// values before and after, and the verdict is never `explained`. With one value everywhere it is.
#[test]
fn a_cause_that_ends_is_said_to_end() {
    for size in [1.35, 5.0] {
        let mut system = runs([0.0; 4], 0.0, 5);
        for e in &mut system.experiments {
            let rows = e.measured.len();
            for k in 0..2 * rows / 3 {
                e.measured[k] += size * e.columns[1][k];
            }
        }
        let d = diagnosed(&system);
        assert_eq!((d.verdict, d.named()), (Verdict::PartlyExplained, vec!["x1"]), "{size}");
        let change = d.causes[0].stability_test.in_time.as_ref().expect("a change");
        // Rows of 20 ms, blocks of 40: 266 of 400 rows are 5.3 s, to a block of 0.8 s.
        assert!((change.time_s - 5.3).abs() < 0.81, "{change:?}");
        assert!(change.before > 0.8 * size && change.after.abs() < 0.3 * size, "{change:?}");
        assert!(d.reasons.iter().any(|r| r.contains("changes at t = ")), "{:?}", d.reasons);
        let d = diagnosed(&runs([0.0, size, 0.0, 0.0], 0.0, 5));
        assert_eq!((d.verdict, d.named()), (Verdict::Explained, vec!["x1"]), "{size}");
        assert!(d.causes[0].stability_test.holds() && d.reasons.is_empty(), "{:?}", d.reasons);
        assert!(d.causes[0].stability.as_ref().unwrap().relative_spread < 0.3);
    }
}

/// A candidate that seems to be as large on baseline recordings, where it is absent, is no cause: its interval is widened
/// by what its values there let one expect of the mean of three recordings. With v in each of three baseline recordings
/// around zero, that is v t √(1/3 + 1/3), with t = 3.182 the 97.5 % quantile of Student's t for three degrees of freedom.
/// With baseline recordings that do not show it, it stands.
#[test]
fn a_name_that_the_baseline_shows_as_well_is_rejected() {
    let settings = DiagnosisSettings::default();
    let system = runs([3.0, 0.0, 0.0, 0.0], 0.0, 6);
    let with = |slope: f64| {
        let baseline = runs([slope, 0.0, 0.0, 0.0], 0.0, 7);
        system.diagnosed(TestSource::Absent, 1.0, Some(&baseline), &settings, 1)
    };
    let (absent, present) = (with(0.0), with(2.8));
    assert_eq!((absent.verdict, absent.named()), (Verdict::Explained, vec!["x0"]));
    assert_eq!((present.verdict, present.named()), (Verdict::Unexplained, vec![]));
    // In between the interval is wider by the apparent value.
    let between = with(1.0);
    let half = |d: &Diagnosis<()>| {
        let [low, high] = d.causes[0].parameters[0].1.ci95;
        0.5 * (high - low)
    };
    let expected = half(&absent).hypot(3.182 * (2.0_f64 / 3.0).sqrt());
    assert!((half(&between) / expected - 1.0).abs() < 0.1, "{} {expected}", half(&between));
}

/// Columns that hardly differ are confusable; independent ones are not. The threshold is a share of 95 % of the removed error:
/// a column that correlates by ρ removes ρ² of it.
#[test]
fn columns_that_hardly_differ_are_confusable() {
    for (rho, confusable) in [(0.98_f64, true), (0.8, false)] {
        let mut system = runs([5.0, 0.0, 0.0, 0.0], 0.0, 8);
        let mut random = ChaCha8Rng::seed_from_u64(9);
        for e in &mut system.experiments {
            let new = coloured(&mut random, 400, 0.5);
            let old = e.columns[0].iter().zip(&new);
            e.columns[3] = old.map(|(x, n)| rho * x + (1.0 - rho * rho).sqrt() * n).collect();
        }
        let d = diagnosed(&system);
        assert_eq!(d.named(), ["x0"]);
        let expected: &[&str] = if confusable { &["x3"] } else { &[] };
        assert_eq!(d.causes[0].confusable_with, expected, "{rho}");
    }
}
