use crate::common::{clean, diagnosis, model, noisy, protocol};
use pam_data::{Channel, Subject};
use pam_diagnose::{DiagnoseOptions, DiagnosisSettings};
use pam_effects::ActiveEffect;
use pam_effects::effects::by_id;
use pam_experiment::certify::{
    Certificate, CertifyFolder, CertifyOptions, Progress, Summary, Work, plan, run_cases,
    settings_file, with_baseline,
};
use pam_experiment::detect::DetectOptions;
use pam_experiment::plan::{Synthesis, measured};
use pam_numerics::statistics::{mean, standard_deviation};
use pam_rig::sensors::SensorParameters;
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;

/// Residuals that come back have the size and the correlation of those of the baseline, and differ from set to set.
#[test]
fn residuals_come_back_with_their_size_and_colour() {
    let model = model();
    let baseline = noisy(&model, &protocol(12.0), None, 3);
    let synthesis =
        Synthesis::new(&model, &baseline, &DiagnoseOptions::default()).expect("simulated");
    let (a, b) = (synthesis.set(None, 1).expect("a set"), synthesis.set(None, 2).expect("a set"));
    // Differences of two sets: the simulation is the same.
    let difference =
        |x: &[f64], y: &[f64]| -> Vec<f64> { x.iter().zip(y).map(|(x, y)| x - y).collect() };
    for c in [Channel::X, Channel::Pf] {
        let sets = difference(a[0].recording.channel(c), b[0].recording.channel(c));
        let truth = difference(
            baseline[0].recording.channel(c),
            synthesis_truth(&model, &baseline[0]).channel(c),
        );
        let (own, wanted) =
            (standard_deviation(&sets), 2.0_f64.sqrt() * standard_deviation(&truth));
        assert!((0.6..1.5).contains(&(own / wanted)), "{c:?}: {own} {wanted}");
        let correlation = |v: &[f64]| {
            let m = mean(v);
            let at = |lag: usize| -> f64 {
                v.iter().zip(&v[lag..]).map(|(a, b)| (a - m) * (b - m)).sum()
            };
            at(5) / at(0)
        };
        assert!((correlation(&sets) - correlation(&truth)).abs() < 0.15, "{c:?}");
    }
    assert_eq!(a[0].recording, synthesis.set(None, 1).expect("a set")[0].recording);
}

/// A residual that drifts comes back without jumps, wherever its blocks come from.
#[test]
fn drifting_residuals_do_not_jump() {
    let model = model();
    let mut baseline = noisy(&model, &protocol(12.0), None, 7);
    let drift_mm = 0.5;
    for subject in &mut baseline {
        let count = subject.recording.len() as f64;
        for (k, x) in subject.recording.displacement_mm.iter_mut().enumerate() {
            *x += drift_mm * k as f64 / count;
        }
    }
    let synthesis = Synthesis::new(&model, &baseline, &diagnosis(&[])).expect("simulated");
    let truth = synthesis_truth(&model, &baseline[0]);
    let largest_step_mm = (0..10).map(|seed| {
        let set = synthesis.set(None, seed).expect("a set");
        let pairs = set[0].recording.displacement_mm.iter().zip(&truth.displacement_mm);
        let left: Vec<f64> = pairs.map(|(x, y)| x - y).collect();
        left.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max)
    });
    let largest_step_mm = largest_step_mm.fold(0.0, f64::max);
    assert!(largest_step_mm < 0.02 * drift_mm, "{largest_step_mm} mm");
}

/// An offset of a sensor is the same at all times, also where blocks of residuals overlap.
#[test]
fn an_offset_comes_back_as_it_is() {
    let model = model();
    let mut baseline = noisy(&model, &protocol(12.0), None, 3);
    for subject in &mut baseline {
        let recording = &mut subject.recording;
        recording.pressure_flexor_kpa.iter_mut().for_each(|p| *p += 3.0);
        // Not computed from the reading at rest, which has the offset too.
        recording.given_masses = Some(subject.masses);
        *subject = Subject::of(recording.clone(), &model.joint).expect("given masses");
    }
    let synthesis =
        Synthesis::new(&model, &baseline, &DiagnoseOptions::default()).expect("simulated");
    let made = synthesis.set(None, 1).expect("a set");
    for (made, own) in made.iter().zip(&baseline) {
        let [made, own] = [made, own].map(|s| &s.recording.pressure_flexor_kpa);
        let difference: Vec<f64> = made.iter().zip(own).map(|(a, b)| a - b).collect();
        for (k, stretch) in difference.chunks_exact(difference.len() / 60).enumerate() {
            assert!(mean(stretch).abs() < 0.3, "{k}: {}", mean(stretch));
        }
    }
}

/// Where the baseline recordings have loads that the model lacks, of either sign, a load is named only beyond these.
#[test]
fn limits_are_beyond_what_baseline_recordings_show() {
    let model = model();
    let loads = [-6.0, 5.0, 7.0];
    let own = loads.map(|load| noisy(&model, &protocol(12.0), Some(("constant_load", load)), 7));
    let baseline: Vec<Subject> = own.iter().enumerate().map(|(k, all)| all[k].clone()).collect();
    let limit = |diagnosis: DiagnoseOptions| {
        let detect = DetectOptions {
            effects: vec!["constant_load".parse().expect("an effect")],
            diagnosis,
            ..DetectOptions::default()
        };
        let options = CertifyOptions { detect, nulls: 0, ..CertifyOptions::default() };
        let (plan, _) = plan(&model, &baseline, &options).expect("a plan");
        plan.limits[0].2.abs()
    };
    let without = diagnosis(&["constant_load"]);
    let with = with_baseline(&model, &baseline, &without).expect("the baseline is learned");
    let [without, with] = [without, with].map(limit);
    // Three recordings tell little of how large they are elsewhere.
    assert!(with > 2.0 * without && (20.0..200.0).contains(&with), "{without} {with}");
}

fn synthesis_truth(
    model: &pam_effects::ExtendedModel,
    subject: &pam_data::Subject,
) -> pam_data::Recording {
    use pam_trajectory::{Predictor, SolverSettings};
    let effect = by_id("viscous_damping").expect("known");
    let model = model.with([ActiveEffect { effect, values: vec![0.0] }]);
    let predicted = model.predict(&subject.recording, subject.masses, &SolverSettings::default());
    predicted.expect("it moves").to_recording(&subject.recording, subject.masses)
}

/// Noise of the measured force is in the force alone: the motion, in the mean of several sets, is that under the true force.
#[test]
fn noise_of_the_force_moves_nothing() {
    const SETS: u64 = 8;
    let model = model();
    let mut sensors = SensorParameters::default();
    sensors.current.noise_a = 0.1;
    let mut sine = protocol(84.0);
    sine.current.truncate(1);
    let truth = clean(&model, &sine);
    let read = |(k, s): (u64, &Subject)| measured(s, &sensors, 20.0, k).expect("long enough");
    let baseline: Vec<Subject> = (0..).zip(&truth).map(read).collect();
    let synthesis = Synthesis::new(&model, &baseline, &diagnosis(&[])).expect("simulated");
    let sets: Vec<Vec<Subject>> =
        (0..SETS).map(|seed| synthesis.set(None, seed).expect("a set")).collect();
    for (k, (read, truth)) in baseline.iter().zip(&truth).enumerate() {
        let mut mean_mm = vec![0.0; truth.recording.len()];
        for set in &sets {
            assert_eq!(set[k].recording.force_mn, read.recording.force_mn);
            let own = &set[k].recording.displacement_mm;
            mean_mm.iter_mut().zip(own).for_each(|(m, x)| *m += x / SETS as f64);
        }
        let error_mm = |x_mm: &[f64]| {
            let true_mm = &truth.recording.displacement_mm;
            let errors: Vec<f64> = x_mm.iter().zip(true_mm).map(|(x, y)| x - y).collect();
            standard_deviation(&errors)
        };
        let along_measured_mm = error_mm(&synthesis_truth(&model, read).displacement_mm);
        let made_mm = error_mm(&mean_mm);
        assert!(made_mm < 0.7 * along_measured_mm, "{made_mm} {along_measured_mm}");
    }
}

/// A biased pressure sensor shows the bias at rest as well, and the masses that follow from the reading are wrong by it.
#[test]
fn sensors_show_an_effect_at_rest_too() {
    let model = model();
    let baseline = noisy(&model, &protocol(6.0), None, 4);
    let synthesis =
        Synthesis::new(&model, &baseline, &DiagnoseOptions::default()).expect("simulated");
    let bias =
        ActiveEffect { effect: by_id("pressure_bias").expect("known"), values: vec![15.0, 0.0] };
    let (with, without) =
        (synthesis.set(Some(&bias), 1).expect("a set"), synthesis.set(None, 1).expect("a set"));
    let rest = |s: &pam_data::Subject| s.recording.reading_at_rest();
    let shown = rest(&with[0]).pressure_flexor_kpa - rest(&without[0]).pressure_flexor_kpa;
    assert!((shown - 15.0).abs() < 1e-6, "{shown}");
    let ratio = with[0].masses.flexor_g / without[0].masses.flexor_g;
    let wanted = rest(&with[0]).pressure_flexor_kpa / rest(&without[0]).pressure_flexor_kpa;
    assert!((ratio - wanted).abs() < 1e-9, "{ratio} {wanted}");
    assert_eq!(with[0].masses.extensor_g, without[0].masses.extensor_g);
}

/// A certificate resumes where it was stopped, shards share the cases, another plan is refused, and its settings carry it.
#[test]
fn a_certificate_resumes_and_is_quoted() {
    let model = model();
    let baseline = noisy(&model, &protocol(6.0), None, 5);
    let options = CertifyOptions {
        detect: DetectOptions {
            diagnosis: diagnosis(&["viscous_damping", "stiffness_scale"]),
            ..DetectOptions::default()
        },
        multiples: vec![4.0],
        repeats: 1,
        nulls: 2,
        ..CertifyOptions::default()
    };
    let (cases, _) = plan(&model, &baseline, &options).expect("a plan");
    assert_eq!(cases.cases.len(), 4);
    let synthesis =
        Synthesis::new(&model, &baseline, &DiagnoseOptions::default()).expect("simulated");
    let place = tempfile::tempdir().expect("a folder");
    let folder = CertifyFolder::at(place.path());
    folder.begin(&cases, &"inputs").expect("a new folder");
    folder.begin(&cases, &"inputs").expect("the same plan");
    assert!(folder.begin(&cases, &"others").is_err());
    let stop = AtomicBool::new(false);
    let run = |own: &(dyn Fn(usize) -> bool + Sync)| {
        let ran = Mutex::new(Vec::new());
        let note = |p: Progress<'_>| {
            if let Progress::Over(outcome) = p {
                ran.lock().expect("no panic").push(outcome.case.id.clone());
            }
        };
        let work = Work {
            model: &model,
            baseline: &baseline,
            synthesis: &synthesis,
            plan: &cases,
            diagnosis: &options.detect.diagnosis,
            folder: &folder,
        };
        run_cases(&work, own, 2, &stop, &note).expect("cases run");
        let mut ran = ran.into_inner().expect("no panic");
        ran.sort();
        ran
    };
    let first = run(&|k| k % 2 == 0);
    let second = run(&|_| true);
    assert_eq!((first.len(), second.len()), (2, 2));
    assert!(run(&|_| true).is_empty());
    let outcomes = folder.outcomes(&cases).expect("outcomes");
    let summary = Summary::of(&cases, &outcomes, &options, "a test");
    assert_eq!((summary.cases, summary.refused, summary.certificate.nulls), ([4, 4], 0, 2));
    let damping = summary.detected.iter().find(|d| d.label == "viscous_damping").expect("run");
    assert_eq!((damping.trials, damping.right), (1, 1));
    let file = settings_file(&summary, &options.detect.diagnosis.settings);
    let (settings, certificate) = Certificate::split(&file).expect("a file of settings");
    assert_eq!(certificate.as_ref(), Some(&summary.certificate));
    let settings = DiagnosisSettings::parse(&settings, &[]).expect("settings");
    assert!(settings.search.odds >= DiagnosisSettings::default().search.odds);
}
