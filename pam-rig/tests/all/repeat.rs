//! The same settings and seed give the same bytes, however a folder of recordings came about.

use pam_core::JointModel;
use pam_core::force::SpringDamper;
use pam_data::{LoadOptions, MassChoice, MassOrigin, TRUTH_SUFFIX};
use pam_data::{collect_paths, open_recordings, resolve_masses};
use pam_rig::folder::SETTINGS_FILE;
use pam_rig::{Effect, Protocol, RigParameters, Session, record};
use std::collections::BTreeMap;
use std::path::Path;

/// Three conditions, 4.5 s of lead-in (the loader looks for the excitation from frame 2000 on) and 2 s
/// of excitation.
const PROTOCOL: &str = "name = \"short\"\nconditions = [[30, 60], [45, 45], [60, 20]]\n\
    [lead_in]\ninflate_s = 4.0\nrest_s = 0.5\n\
    [[current]]\nkind = \"sine\"\namplitude_a = 1.0\nfrequency_hz = 1.0\nduration_s = 1.0\n\
    [[current]]\nkind = \"random_pulses\"\namplitude_a = 0.5\nwidth_ms = 50.0\n\
    pause_ms = [50.0, 200.0]\nduration_s = 1.0\n";

fn protocol() -> Protocol {
    Protocol::parse(PROTOCOL, Path::new("short.toml")).unwrap()
}

fn session(seed: u64) -> Session {
    let effect: Effect = "cogging:force_n=8,pitch_mm=0.5".parse().unwrap();
    let rig = RigParameters { effects: vec![effect], ..RigParameters::default() };
    Session { rig, protocol: protocol(), seed, truth: true, note: "a test".into() }
}

/// All files of a folder with their bytes.
fn bytes(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap())
        .map(|e| (e.file_name().into_string().unwrap(), std::fs::read(e.path()).unwrap()))
        .collect()
}

/// Records into a folder on some threads and says which recordings were made.
fn record_on(threads: usize, session: &Session, folder: &Path) -> Vec<(String, bool)> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let entries = pool.install(|| session.record_into(folder, false, &|_| {})).unwrap();
    entries.into_iter().map(|e| (e.name, !e.was_there)).collect()
}

#[test]
fn a_seed_repeats_and_another_does_not() {
    let (rig, protocol) = (session(7).rig, protocol());
    let runs = protocol.runs().unwrap();
    let made = |seed, run: usize| record(&rig, &protocol, &runs[run], seed).unwrap();
    let (a, b, other) = (made(7, 0), made(7, 0), made(8, 0));
    assert_eq!(a.log_text("n"), b.log_text("n"));
    assert_eq!(a.truth.to_arrays(), b.truth.to_arrays());
    assert_ne!(a.log_text("n"), other.log_text("n"));
    assert_ne!(a.truth.to_arrays(), other.truth.to_arrays());
    // Two recordings of one folder do not share their noise either.
    let current = |run: usize| -> Vec<f64> {
        made(7, run).rows[100..1100].iter().map(|r| r.current_a).collect()
    };
    assert_ne!(current(0), current(1));
}

#[test]
fn threads_do_not_matter() {
    let [one, two] = [1, 2].map(|threads| {
        let folder = tempfile::tempdir().unwrap();
        let made = record_on(threads, &session(7), folder.path());
        let names: Vec<&str> = made.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["nn_3060", "nn_4545", "nn_6020"]);
        assert!(made.iter().all(|(_, made)| *made));
        bytes(folder.path())
    });
    // Three logs, three truths, the settings.
    assert_eq!(one.len(), 7);
    assert!(one == two, "the folders differ");
}

#[test]
fn an_interrupted_session_goes_on_to_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let session = session(7);
    record_on(2, &session, folder.path());
    let complete = bytes(folder.path());
    // One log is lost with its truth, one without, and one truth without its log; a file was half
    // written.
    std::fs::remove_file(path("nn_3060")).unwrap();
    std::fs::remove_file(path(&format!("nn_3060{TRUTH_SUFFIX}"))).unwrap();
    std::fs::remove_file(path("nn_4545")).unwrap();
    std::fs::write(path(".pam-xyz"), "half a lo").unwrap();
    let made = record_on(1, &session, folder.path());
    assert_eq!(made.iter().map(|(_, made)| *made).collect::<Vec<_>>(), [true, true, false]);
    assert!(bytes(folder.path()) == complete, "the folder differs");

    std::fs::remove_file(path(&format!("nn_6020{TRUTH_SUFFIX}"))).unwrap();
    let made = record_on(1, &session, folder.path());
    assert_eq!(made.iter().map(|(_, made)| *made).collect::<Vec<_>>(), [false, false, true]);
    assert!(bytes(folder.path()) == complete, "the folder differs");
}

#[test]
fn other_settings_are_refused_unless_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    record_on(1, &session(7), folder.path());
    let before = bytes(folder.path());
    let mut no_effect = session(7);
    no_effect.rig.effects.clear();
    let mut longer = session(7);
    longer.protocol.lead_in.rest_s = 0.6;
    for other in [session(8), no_effect, longer] {
        let error = other.record_into(folder.path(), false, &|_| {}).unwrap_err().to_string();
        assert!(error.contains("other settings") && error.contains("overwrite"), "{error}");
        assert!(bytes(folder.path()) == before, "a refused session changed the folder");
    }
    session(8).record_into(folder.path(), true, &|_| {}).unwrap();
    let fresh = tempfile::tempdir().unwrap();
    record_on(1, &session(8), fresh.path());
    assert!(bytes(folder.path()) == bytes(fresh.path()));
}

#[test]
fn logs_of_other_origin_are_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("nn_4545"), "measured by hand").unwrap();
    let error = session(7).record_into(folder.path(), false, &|_| {}).unwrap_err().to_string();
    assert!(error.contains("did not make"), "{error}");
    assert_eq!(bytes(folder.path()).len(), 1);
}

/// A sealed folder tells an estimator nothing but its logs.
#[test]
fn logs_enter_through_the_door_of_real_ones_and_the_truth_does_not() {
    let folder = tempfile::tempdir().unwrap();
    record_on(2, &session(7), folder.path());
    let model = JointModel::datasheet(SpringDamper::published());
    let paths = collect_paths(&[folder.path().to_owned()]).unwrap();
    let names: Vec<_> = paths.iter().map(|p| p.file_name().unwrap().to_str().unwrap()).collect();
    assert_eq!(names, ["nn_3060", "nn_4545", "nn_6020"]);
    for (path, psi) in paths.iter().zip([[30.0, 60.0], [45.0, 45.0], [60.0, 20.0]]) {
        let text = std::fs::read_to_string(path).unwrap();
        assert!(text.starts_with("#a test\n") && !text.contains("cogging"), "{}", &text[..80]);
        let [recording] = &open_recordings(path, &LoadOptions::default()).unwrap()[..] else {
            panic!("one recording a log")
        };
        assert_eq!(recording.command_psi, Some(psi));
        // Time zero is where the excitation begins, give or take the filter of the loader.
        let excited_s = recording.time_s.last().unwrap() - recording.time_s[0];
        assert!((excited_s - 2.0).abs() < 0.02, "{excited_s} s");
        let sealed = recording.sealed.unwrap();
        for (measured, psi) in
            [sealed.pressure_flexor_kpa, sealed.pressure_extensor_kpa].into_iter().zip(psi)
        {
            assert!((measured - (psi * 6.89476 + 101.325)).abs() < 1.5 * 6.89476, "{measured} kPa");
        }
        // The nominal volume of 15.7 cm³ is less than the air's by the dead one.
        let (masses, origin) =
            resolve_masses(recording, &model, false, MassChoice::GasLaw, None).unwrap();
        assert_eq!(origin, MassOrigin::GasLaw);
        for (mass, psi) in [masses.flexor_g, masses.extensor_g].into_iter().zip(psi) {
            let expected = (psi * 6.89476 + 101.325) * 15_708.0 / 8.47e7;
            assert!((mass / expected - 1.0).abs() < 0.1, "{mass} of {expected} g");
        }
        let x = || recording.displacement_mm.iter().copied();
        assert!(x().fold(f64::MIN, f64::max) - x().fold(f64::MAX, f64::min) > 0.5);
        let truth = folder.path().join(format!("{}{TRUTH_SUFFIX}", recording.name));
        let refused = open_recordings(&truth, &LoadOptions::default()).unwrap_err().to_string();
        assert!(refused.contains("sealed truth"), "{refused}");
    }
    let settings = folder.path().join(SETTINGS_FILE);
    assert!(std::fs::read_to_string(&settings).unwrap().contains("cogging"));
    assert!(open_recordings(&settings, &LoadOptions::default()).is_err());
}
