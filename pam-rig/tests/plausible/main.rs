//! Wrong units, swapped columns and flipped signs are found in every format; faults of the joint are not taken for them.

mod wrong_inputs;

use pam_data::plausibility::{Finding, FindingKind, Severity, check};
use pam_data::preprocess::{RawLogOptions, recordings_from_raw_log};
use pam_data::{
    LoadOptions, MassOptions, RawLog, Recording, SavedModel, Subject, load_model, open_recordings,
};
use pam_rig::protocol::{CurrentSegment, LeadIn};
use pam_rig::{Protocol, RigParameters, Run, record};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

/// A file of the published reference data.
fn published(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/published").join(name)
}

static MODEL: LazyLock<SavedModel> =
    LazyLock::new(|| load_model(published("hybrid_model_puresine_16.eqx")).unwrap());

/// Unequal and equal pressures, psi.
const PSI: [[f64; 2]; 3] = [[45.0, 45.0], [30.0, 60.0], [60.0, 30.0]];

/// Text of a raw log of the virtual rig: the published excitation, shortened.
fn log(rig: &RigParameters, psi: [f64; 2]) -> String {
    let sines = [(0.5, 4.0), (1.0, 2.0), (2.0, 1.0)].into_iter().flat_map(|(hz, s)| {
        [1.0, 1.5].map(|amplitude_a| CurrentSegment::Sine {
            amplitude_a,
            frequency_hz: hz,
            duration_s: s,
        })
    });
    let lead_in = LeadIn { inflate_s: 6.0, rest_s: 1.0 };
    let protocol = Protocol { current: sines.collect(), lead_in, ..Protocol::paper() };
    let name = format!("nn_{:02.0}{:02.0}", psi[0], psi[1]);
    record(rig, &protocol, &Run { name, start_psi: psi }, 5).unwrap().log_text("test")
}

/// The recordings of a log's text.
fn read(name: &str, log: &str) -> Vec<Recording> {
    let log = RawLog::parse(Path::new(name), log.as_bytes()).unwrap();
    recordings_from_raw_log(&log, &RawLogOptions::default()).unwrap()
}

fn rig_recordings(effects: &[&str]) -> Vec<Recording> {
    let effects = effects.iter().map(|e| e.parse().unwrap()).collect();
    // A step of 0.25 ms: findings do not depend on the last digit of a motion.
    let rig = RigParameters { effects, steps_per_sample: 4, ..RigParameters::default() };
    PSI.iter().flat_map(|psi| read(&name(*psi), &log(&rig, *psi))).collect()
}

fn name(psi: [f64; 2]) -> String {
    format!("nn_{:02.0}{:02.0}", psi[0], psi[1])
}

/// Logs of the rig without a fault.
static LOGS: LazyLock<Vec<(String, String)>> = LazyLock::new(|| {
    PSI.iter().map(|psi| (name(*psi), log(&RigParameters::default(), *psi))).collect()
});

/// Their recordings, renamed so that no name tells the pressures.
static SOUND: LazyLock<Vec<Recording>> = LazyLock::new(|| {
    let read = LOGS.iter().flat_map(|(name, log)| read(name, log));
    read.enumerate()
        .map(|(k, r)| Recording { name: format!("run{k}"), command_psi: None, ..r })
        .collect()
});

/// The published measured run.
static REAL: LazyLock<Vec<Recording>> =
    LazyLock::new(|| open_recordings(published("data.mat"), &LoadOptions::default()).unwrap());

fn findings(recordings: Vec<Recording>) -> Vec<Finding> {
    let subjects = Subject::resolve(recordings, &MODEL, &MassOptions::default()).unwrap();
    check(&MODEL.model, &subjects)
}

fn kinds(findings: &[Finding]) -> Vec<(FindingKind, Severity)> {
    findings.iter().map(|f| (f.kind, f.severity)).collect()
}

type Change = fn(&mut Recording);

fn scale(values: &mut [f64], factor: f64) {
    values.iter_mut().for_each(|v| *v *= factor);
}

fn pressures(r: &mut Recording, f: impl Fn(f64) -> f64) {
    let sealed = r.sealed.as_mut();
    let each = [&mut r.pressure_flexor_kpa, &mut r.pressure_extensor_kpa];
    each.into_iter().for_each(|c| c.iter_mut().for_each(|p| *p = f(*p)));
    if let Some(s) = sealed {
        s.pressure_flexor_kpa = f(s.pressure_flexor_kpa);
        s.pressure_extensor_kpa = f(s.pressure_extensor_kpa);
    }
}

fn displacement(r: &mut Recording, factor: f64) {
    scale(&mut r.displacement_mm, factor);
    scale(&mut r.velocity_mm_s, factor);
    if let Some(s) = &mut r.sealed {
        s.displacement_mm *= factor;
    }
}

fn swap(r: &mut Recording) {
    std::mem::swap(&mut r.pressure_flexor_kpa, &mut r.pressure_extensor_kpa);
    if let Some(s) = &mut r.sealed {
        std::mem::swap(&mut s.pressure_flexor_kpa, &mut s.pressure_extensor_kpa);
    }
}

/// What can be done to a recording, and what must be found.
fn changes() -> Vec<(&'static str, Change, FindingKind)> {
    use FindingKind::{
        DeadPressure, DisplacementSign, DisplacementUnit, ForceSign, ForceUnit, GaugePressure,
        PressureUnit, SameSignPressures, SwappedMuscles, TimeUnit, Velocity, VelocityMissing,
    };
    vec![
        ("gauge kPa", |r| pressures(r, |p| p - 101.325), GaugePressure),
        ("bar", |r| pressures(r, |p| p / 100.0), PressureUnit),
        ("bar gauge", |r| pressures(r, |p| (p - 101.325) / 100.0), PressureUnit),
        ("psi", |r| pressures(r, |p| p / 6.894_76), PressureUnit),
        ("psi gauge", |r| pressures(r, |p| (p - 101.325) / 6.894_76), PressureUnit),
        ("Pa", |r| pressures(r, |p| p * 1e3), PressureUnit),
        ("MPa", |r| pressures(r, |p| p * 1e-3), PressureUnit),
        ("degrees", |r| displacement(r, 1.0 / 0.119_99), DisplacementUnit),
        ("metres", |r| displacement(r, 1e-3), DisplacementUnit),
        ("swapped", swap, SwappedMuscles),
        ("x flipped", |r| displacement(r, -1.0), DisplacementSign),
        ("force flipped", |r| scale(&mut r.force_mn, -1.0), ForceSign),
        ("kN", |r| scale(&mut r.force_mn, 1e-3), ForceUnit),
        ("mN", |r| scale(&mut r.force_mn, 1e3), ForceUnit),
        ("N·mm", |r| scale(&mut r.force_mn, 6.875), ForceUnit),
        ("amperes", |r| scale(&mut r.force_mn, 1.0 / 133.5), ForceUnit),
        ("ms", |r| scale(&mut r.time_s, 1e3), TimeUnit),
        ("µs", |r| scale(&mut r.time_s, 1e6), TimeUnit),
        ("no velocity", |r| scale(&mut r.velocity_mm_s, 0.0), VelocityMissing),
        ("v in m/s", |r| scale(&mut r.velocity_mm_s, 1e-3), Velocity),
        ("v flipped", |r| scale(&mut r.velocity_mm_s, -1.0), Velocity),
        ("dead flexor sensor", |r| r.pressure_flexor_kpa.fill(412.0), DeadPressure),
        (
            "one pressure twice",
            |r| r.pressure_extensor_kpa = r.pressure_flexor_kpa.clone(),
            SameSignPressures,
        ),
    ]
}

fn every_change_is_found(sound: &[Recording], except: &[&str]) {
    assert_eq!(kinds(&findings(sound.to_vec())), [], "{:#?}", findings(sound.to_vec()));
    let mut wrong = Vec::new();
    for (what, change, kind) in changes() {
        if except.contains(&what) {
            continue;
        }
        let mut changed = sound.to_vec();
        changed.iter_mut().for_each(change);
        let found = findings(changed);
        println!("{what}:");
        found.iter().for_each(|f| println!("    {:?} {:?} {f}", f.severity, f.kind));
        if kinds(&found) != [(kind, Severity::Error)] {
            wrong.push((what, kinds(&found)));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn every_change_of_rig_data_is_found() {
    every_change_is_found(&SOUND, &[]);
}

/// One run at one pair of nearly equal pressures cannot tell gauge pressures from polytropic air for certain.
#[test]
fn every_change_of_the_real_run_is_found() {
    every_change_is_found(&REAL, &["gauge kPa"]);
    let mut gauge = REAL.clone();
    gauge.iter_mut().for_each(|r| pressures(r, |p| p - 101.325));
    let found = findings(gauge);
    assert!(found.iter().any(|f| f.kind == FindingKind::GaugePressure), "{found:#?}");
}

/// Raw logs whose pressure columns are in another unit than psi gauge.
#[test]
fn units_of_raw_logs_are_found() {
    let changed = |factor: f64, offset: f64| -> Vec<Recording> {
        let change = |log: &str| -> String {
            let line = |line: &str| {
                if line.starts_with('#') || line.starts_with(" #") {
                    return line.to_owned();
                }
                let mut cells: Vec<String> = line.split('\t').map(str::to_owned).collect();
                for c in [6, 9] {
                    let value: f64 = cells[c].parse().unwrap();
                    cells[c] = (value * factor + offset).to_string();
                }
                cells.join("\t")
            };
            log.lines().map(line).collect::<Vec<_>>().join("\n")
        };
        LOGS.iter().flat_map(|(name, log)| read(name, &change(log))).collect()
    };
    let sound: Vec<Recording> = LOGS.iter().flat_map(|(name, log)| read(name, log)).collect();
    assert_eq!(kinds(&findings(sound)), []);
    for (what, factor, offset, unit) in [
        ("psi absolute", 1.0, 14.696, "psi absolute"),
        ("kPa gauge", 6.894_76, 0.0, "kPa gauge"),
        ("kPa absolute", 6.894_76, 101.325, "kPa absolute"),
        ("bar gauge", 0.068_947_6, 0.0, "bar gauge"),
    ] {
        let found = findings(changed(factor, offset));
        assert_eq!(
            kinds(&found),
            [(FindingKind::PressureUnit, Severity::Error)],
            "{what} {found:#?}"
        );
        assert!(found[0].message.contains(unit), "{what}: {}", found[0].message);
    }
}

/// Backlash in the displacement measurement that hides half of one small motion is no error of the geometry, which all recordings share,
/// unless there is no other recording.
#[test]
fn backlash_in_one_small_motion_is_no_wrong_geometry() {
    let rig = rig_recordings(&["backlash:gap_mm=1.1"]);
    // One sine, so that the backlash hides the same share of every period.
    let small = Recording { name: "small".into(), command_psi: None, ..rig[1].slice(1000..5000) };
    let of_geometry = |recordings: Vec<Recording>| -> Vec<Finding> {
        findings(recordings).into_iter().filter(|f| f.kind == FindingKind::Geometry).collect()
    };
    let alone = of_geometry(vec![small.clone()]);
    assert_eq!(kinds(&alone), [(FindingKind::Geometry, Severity::Error)], "{alone:#?}");
    let among = of_geometry(SOUND.iter().cloned().chain([small]).collect());
    assert_eq!(kinds(&among), [(FindingKind::Geometry, Severity::Warning)], "{among:#?}");
    assert_eq!(among[0].recordings, ["small"]);
    assert!(among[0].message.contains("3 of 4 recordings fit"), "{}", among[0].message);
}

/// A model of half the length, and masses of another unit or radius.
#[test]
fn geometry_and_masses_are_checked() {
    let mut short = MODEL.clone();
    short.model.geometry.length_mm = 100.0;
    let subjects = Subject::resolve(SOUND.clone(), &short, &MassOptions::default()).unwrap();
    let found = check(&short.model, &subjects);
    assert!(kinds(&found).contains(&(FindingKind::Geometry, Severity::Error)), "{found:#?}");

    let with_masses = |factor: f64| {
        let subjects = Subject::resolve(SOUND.clone(), &MODEL, &MassOptions::default()).unwrap();
        subjects
            .into_iter()
            .map(|s| {
                let mut r = s.recording;
                let mut m = s.masses;
                m.flexor_g *= factor;
                m.extensor_g *= factor;
                r.given_masses = Some(m);
                r
            })
            .collect::<Vec<_>>()
    };
    assert_eq!(kinds(&findings(with_masses(1.1))), []);
    for factor in [1e3, 2.25] {
        let found = findings(with_masses(factor));
        assert!(kinds(&found).contains(&(FindingKind::Masses, Severity::Error)), "{found:#?}");
    }
}

/// One bad file among good ones is named alone.
#[test]
fn a_single_bad_recording_is_named() {
    let mut set = SOUND.clone();
    swap(&mut set[1]);
    let found = findings(set);
    assert_eq!(kinds(&found), [(FindingKind::SwappedMuscles, Severity::Error)]);
    assert_eq!(found[0].recordings, ["run1"]);
}

/// A force that saturates far below its peak looks like a force in another unit, and a sensor that is half a period late like muscles
/// that are swapped.
#[test]
fn strong_saturation_and_late_sensors_are_no_findings() {
    let shaken = |effects: &[&str], hz: f64, change: fn(&mut Recording)| {
        let effects = effects.iter().map(|e| e.parse().unwrap()).collect();
        let rig = RigParameters { effects, ..RigParameters::default() };
        let sine = CurrentSegment::Sine { amplitude_a: 1.5, frequency_hz: hz, duration_s: 8.0 };
        let lead_in = LeadIn { inflate_s: 6.0, rest_s: 1.0 };
        let protocol = Protocol { current: vec![sine], lead_in, ..Protocol::paper() };
        let run = Run { name: "run".to_owned(), start_psi: [45.0, 45.0] };
        let log = record(&rig, &protocol, &run, 5).unwrap().log_text("test");
        let mut recordings = read("run", &log);
        recordings.iter_mut().for_each(change);
        kinds(&findings(recordings))
    };
    let mut refused = Vec::new();
    for hz in [0.5, 1.0, 2.5, 6.2] {
        for effect in [
            "force_saturation:force_n=20",
            "force_saturation:force_n=40",
            "position_delay:delay_ms=60",
            "pressure_delay:delay_ms=80",
            "actuation_delay:delay_ms=40",
            "pressure_sensor_lag:cutoff_hz=1",
        ] {
            let found = shaken(&[effect], hz, |_| {});
            if found.iter().any(|(_, severity)| *severity == Severity::Error) {
                refused.push((effect, hz, found));
            }
        }
    }
    assert!(refused.is_empty(), "{refused:#?}");
    let swapped = [(FindingKind::SwappedMuscles, Severity::Error)];
    assert_eq!(shaken(&[], 2.0, swap), swapped);
    let nmm = |r: &mut Recording| scale(&mut r.force_mn, 1.0 / 0.14545);
    assert_eq!(shaken(&[], 1.0, nmm), [(FindingKind::ForceUnit, Severity::Error)]);
}

/// Run by `cargo test --release --workspace --tests -- --ignored long::`.
mod long {
    use super::*;

    #[test]
    #[ignore = "long"]
    fn faults_of_the_joint_are_no_findings() {
        let strong = [
            "coulomb_friction:force_n=40",
            "stribeck_friction:coulomb_n=20,static_n=45,velocity_mm_s=2",
            "viscous_damping:coefficient_ns_m=4000",
            "hysteresis:force_n=40,slip_mm=0.5",
            "creep:stiffness_n_mm=25,time_constant_s=2",
            "constant_load:force_n=60",
            "added_inertia:mass_kg=150",
            "backlash:gap_mm=0.4",
            "cogging:force_n=25,pitch_mm=0.6",
            "tendon_slack:displacement_mm=0.7,stiffness_loss=0.5",
            "stiffness_drift:relative_per_min=0.5",
            "stiffness_scale:relative=0.25",
            "stiffness_scale:relative=-0.2",
            "leak:flexor_rate_per_s=1e-2,extensor_rate_per_s=5e-3",
            "leak:flexor_rate_per_s=1e-2,extensor_rate_per_s=0",
            "polytropic_gas:exponent=1.3",
            "geometry_coefficient:relative=0.2",
            "geometry_coefficient:relative=-0.15",
            "force_gain:relative=0.25",
            "force_gain:relative=-0.25",
            "force_saturation:force_n=110",
            "actuation_delay:delay_ms=50",
            "pressure_sensor_lag:cutoff_hz=0.7",
            "pressure_delay:delay_ms=60",
            "pressure_bias:flexor_kpa=30,extensor_kpa=-25",
            "pressure_bias:flexor_kpa=-20,extensor_kpa=-20",
            "pressure_gain:flexor_relative=0.15,extensor_relative=-0.12",
            "position_offset:offset_mm=0.5",
            "position_gain:relative=0.2",
            "position_gain:relative=-0.15",
            "periodic_disturbance",
            "chamber_crosstalk",
            "tendon_slip",
            "sensor_gain_jump",
            "encoder_freeze",
            "valve_glitch",
        ];
        let mut wrong = Vec::new();
        for effect in strong {
            let recordings = rig_recordings(&[effect]);
            // With the commanded pressures in the names, and without; all runs together, and one alone.
            let anonymous: Vec<Recording> =
                recordings.iter().map(|r| Recording { command_psi: None, ..r.clone() }).collect();
            for set in [&recordings, &anonymous, &vec![anonymous[0].clone()]] {
                let found = findings(set.clone());
                if !found.is_empty() {
                    wrong.push((effect, set.len(), found));
                }
            }
        }
        assert!(wrong.is_empty(), "{wrong:#?}");
    }
}
