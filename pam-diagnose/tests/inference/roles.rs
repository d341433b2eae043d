//! Training, validation and test data: disjoint, complete, and the test data unseen.

use crate::linear::{Experiment, Linear, combined, white};
use pam_diagnose::data::{Roles, Span, TestData, TestSource};
use pam_diagnose::diagnosis::{Diagnosis, Prepared, run};
use pam_diagnose::fit::{Hypothesis, Problem};
use pam_diagnose::noise::{Noise, NoisePrior, estimated_noise, noise_deviation};
use pam_diagnose::search::Candidates;
use pam_diagnose::settings::DataSettings;
use pam_diagnose::{DiagnosisSettings, Verdict};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;

/// Runs of 5.0, 5.2, 5.4, … s with two columns, of which the first is at work, in rows of five points.
fn runs(count: usize, seed: u64) -> Linear {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let experiments = (0..count)
        .map(|e| {
            let rows = 1250 + 53 * e;
            let columns = vec![white(&mut random, rows), white(&mut random, rows)];
            let measured = combined(&columns, &[1.0, 0.0], &white(&mut random, rows), 0.1);
            let features = columns.clone();
            Experiment { columns, measured, features, ..Experiment::default() }
        })
        .collect();
    let mut system = Linear::new(experiments);
    (system.row_s, system.points_per_row, system.burn_in_s) = (4e-3, 5, 0.5);
    system
}

/// How often each point of each experiment is in a problem.
fn counted(system: &Linear, problem: &Problem<'_, Linear>, into: &mut [Vec<usize>]) {
    for (&e, window) in problem.experiments.iter().zip(&problem.windows) {
        assert_eq!(window.len() % system.points_per_row, 0);
        into[e][window.clone()].iter_mut().for_each(|n| *n += 1);
    }
}

fn none(system: &Linear) -> Vec<Vec<usize>> {
    (0..system.experiments.len()).map(|e| vec![0; system.points(e)]).collect()
}

/// The test points, as the times of the test set's figures show them.
fn tested(system: &Linear, roles: &Roles, settings: &DiagnosisSettings) -> Vec<Vec<usize>> {
    let base = Hypothesis::base(system, 1);
    let mut points = none(system);
    for trace in roles.test(system, &Noise::white(&[0.1]), settings).traces(&base, &base) {
        let e = (0..system.experiments.len()).find(|&e| system.name(e) == trace.name).unwrap();
        for t in trace.time_s {
            points[e][(t / system.row_s).round() as usize] += 1;
        }
    }
    points
}

/// Every point after the burn-in has one role, up to less than a row at the end of a window; a part of the rows in a share
/// of a third trains, validates and tests.
#[test]
fn roles_are_disjoint_and_cover_the_recordings() {
    let settings = DiagnosisSettings::default();
    for count in [1, 2, 3, 4, 9] {
        let system = runs(count, 1);
        let mut sources = vec![TestSource::Kept, TestSource::Absent];
        sources.extend((count > 1).then_some(TestSource::GivenFrom(count - 1)));
        for (source, seed) in sources.iter().flat_map(|s| (0..5).map(move |seed| (*s, seed))) {
            let roles = system.roles(source, seed, &settings);
            let noise = Noise::white(&[0.1]);
            let split = roles.split(&system, &noise, &settings);
            let (mut train, mut validation, mut whole) =
                (none(&system), none(&system), none(&system));
            counted(&system, &split.train, &mut train);
            counted(&system, &split.validation, &mut validation);
            counted(&system, &roles.whole(&system, &noise, &settings), &mut whole);
            let test = tested(&system, &roles, &settings);
            let what = format!("{count} recordings, {source:?}, seed {seed}");
            let mut sums = [0; 3];
            for e in 0..count {
                let (mut unused, mut missed) = (0, 0);
                for k in 0..system.points(e) {
                    let each = [train[e][k], validation[e][k], test[e][k]];
                    let roles: usize = each.iter().sum();
                    assert!(roles <= 1, "{what}: point {k} of {e} is in {each:?}");
                    unused += usize::from(roles == 0);
                    sums.iter_mut().zip(each).for_each(|(s, n)| *s += n);
                    assert!(whole[e][k] + each[2] <= 1, "{what}: point {k} of {e}");
                    // The refit takes both, up to less than a row at the end of each window.
                    missed += usize::from(whole[e][k] < each[0] + each[1]);
                }
                // Half a second of burn-in (125 points), and less than a row (5) at the end of each window.
                assert!((125..125 + 3 * 5).contains(&unused), "{what}: {unused} points unused");
                assert!(missed < 5, "{what}: {missed} points are not refitted");
            }
            assert!(sums[0] > 0 && sums[1] > 0, "{what}: {sums:?}");
            assert_eq!(sums[2] > 0, source != TestSource::Absent, "{what}: {sums:?}");
            let open = train.iter().zip(&validation);
            let open = open.filter(|(t, v)| t.contains(&1) || v.contains(&1)).count();
            assert_eq!(split.same_experiments, open < 3, "{what}: {open} recordings are open");
        }
    }
}

/// Recordings at the ends of the ranges of the pressures train, whatever the seed is; among equals the seed draws.
#[test]
fn the_test_set_lies_between_the_other_recordings() {
    let tested = |pressures: &[[f64; 2]], split_seed: usize| {
        let span = |c: &[f64; 2]| Span {
            name: format!("{c:?}"),
            duration_s: 20.0,
            ranges: c.iter().map(|p| [p - 20.0, p + 20.0]).collect(),
        };
        let spans: Vec<Span> = pressures.iter().map(span).collect();
        let data = DataSettings { split_seed, ..DiagnosisSettings::default().data };
        let roles = Roles::assign(&spans, TestSource::Kept, &data).expect("long enough");
        match roles.test_data {
            Some(TestData::Kept { recordings }) => recordings,
            other => panic!("{other:?}"),
        }
    };
    let orders = [[0, 1, 2], [2, 0, 1], [1, 2, 0]];
    for (order, seed) in orders.into_iter().flat_map(|o| (0..8).map(move |seed| (o, seed))) {
        let all = [[300.0, 280.0], [400.0, 410.0], [520.0, 480.0]];
        let given = order.map(|k: usize| all[k]);
        assert_eq!(tested(&given, seed), ["[400.0, 410.0]"], "{order:?}, seed {seed}");
    }
    // 1 kPa of 40 is no other range.
    let equal = [[400.0, 401.0], [401.0, 400.0], [400.5, 400.0]];
    let mut drawn: Vec<String> = (0..8).flat_map(|seed| tested(&equal, seed)).collect();
    drawn.sort();
    drawn.dedup();
    assert!(drawn.len() > 1, "{drawn:?}");
}

/// Every name and number that follows from the open data; the verdict reads the test data as well.
fn decisions(d: &Diagnosis<()>) -> String {
    format!(
        "{:?} {:?} {:?} {:?} {:?} {:?}",
        d.causes, d.ranking, d.residual, d.null_test, d.noise, d.fitted
    )
}

/// With other measurements in the test rows, at any source of the test set, every decision and every fitted number is the
/// same bit for bit (`{:?}` of an f64 tells any two apart), and the errors on the test set are not.
#[test]
fn no_decision_sees_the_test_set() {
    let settings = DiagnosisSettings::default();
    for (count, source) in [
        (1, TestSource::Kept),
        (2, TestSource::Kept),
        (5, TestSource::Kept),
        (3, TestSource::GivenFrom(1)),
    ] {
        let clean = runs(count, 2);
        let roles = clean.roles(source, 3, &settings);
        let test = tested(&clean, &roles, &settings);
        let mut other = clean.clone();
        let mut random = ChaCha8Rng::seed_from_u64(4);
        for (e, points) in other.experiments.iter_mut().zip(&test) {
            let noise = white(&mut random, points.len());
            for ((y, tested), n) in e.measured.iter_mut().zip(points).zip(noise) {
                *y += 0.5 * n * *tested as f64;
            }
        }
        let diagnosed = |system: &Linear| {
            let prepared = Prepared {
                system,
                roles: &roles,
                noise: estimated_noise(system, &roles.open(), &settings.noise),
                prior: NoisePrior::at_least(vec![1e-9]),
                baseline_discrepancy: Vec::new(),
                baseline: None,
                settings: &settings,
                seed: 3,
            };
            run(&prepared, &|_, _| {}, |_| ()).unwrap()
        };
        let (a, b) = (diagnosed(&clean), diagnosed(&other));
        assert_eq!(a.named(), ["x0"], "{count}, {source:?}");
        assert_eq!(decisions(&a), decisions(&b), "{count}, {source:?}");
        assert_eq!((a.verdict, b.verdict), (Verdict::Explained, Verdict::PartlyExplained));
        let after = |d: &Diagnosis<()>| d.error_reduction.channels[0].rmse_after;
        assert!(after(&a) < 0.2 && after(&b) > 0.4, "{} {}", after(&a), after(&b));
    }
}

/// White noise of σ on a slow motion of 30 σ is found within 10 %; the relative part joins it in quadrature.
#[test]
fn noise_is_estimated_from_the_data_alone() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let motion = |k: usize| 30.0 * (2e-3 * std::f64::consts::TAU * k as f64).sin();
    let rows: Vec<f64> =
        white(&mut random, 4000).iter().enumerate().map(|(k, e)| motion(k) + e).collect();
    assert!((noise_deviation(std::slice::from_ref(&rows), 0.0) - 1.0).abs() < 0.1);
    // A sine of amplitude 30 has a root mean square of 30/√2.
    let joined = noise_deviation(&[rows], 0.1);
    assert!((joined / 1.0_f64.hypot(0.1 * 30.0 / 2.0_f64.sqrt()) - 1.0).abs() < 0.03, "{joined}");
}

/// 3000 samples at 1 kHz span 2.999 s and are enough; what is too short is said to all its digits.
#[test]
fn the_shortest_length_counts_samples() {
    let assign = |duration_s: f64| {
        let spans = [Span { name: "run".into(), duration_s, ranges: Vec::new() }];
        Roles::assign(&spans, TestSource::Kept, &DiagnosisSettings::default().data)
    };
    assert!(assign(2.999).is_ok());
    let message = assign(2.9966).unwrap_err().to_string();
    assert!(message.contains("2.9966 s") && message.contains("at least 3 s"), "{message}");
}
