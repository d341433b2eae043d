//! The program refuses implausible recordings, says why, and goes on if told to.

use pam_data::formats::csv_columns;
use pam_data::preprocess::{RawLogOptions, recordings_from_raw_log};
use pam_data::{RawLog, Recording};
use pam_rig::protocol::CurrentSegment;
use pam_rig::{Protocol, RigParameters, Run, record};
use pam_tests::{published_weights, run, text};
use std::path::{Path, PathBuf};

const PAM: &str = env!("CARGO_BIN_EXE_pam-under-test");

/// A short recording of the virtual rig, its pressures as gauge.
fn gauge(name: &str, psi: [f64; 2]) -> Recording {
    let sine = |frequency_hz, duration_s| CurrentSegment::Sine {
        amplitude_a: 1.2,
        frequency_hz,
        duration_s,
    };
    let protocol = Protocol { current: vec![sine(0.5, 4.0), sine(1.0, 2.0)], ..Protocol::paper() };
    let run = Run { name: name.to_owned(), start_psi: psi };
    let log = record(&RigParameters::default(), &protocol, &run, 5).unwrap().log_text("test");
    let log = RawLog::parse(Path::new(name), log.as_bytes()).unwrap();
    let mut r = recordings_from_raw_log(&log, &RawLogOptions::default()).unwrap().remove(0);
    for column in [&mut r.pressure_flexor_kpa, &mut r.pressure_extensor_kpa] {
        column.iter_mut().for_each(|p| *p -= 101.325);
    }
    r
}

/// The program refuses before it fits, says why and how, and goes on if told to.
#[test]
fn the_program_refuses_inspects_and_reads_gauge_pressures() {
    let folder = tempfile::tempdir().unwrap();
    let psi = [[45.0, 45.0], [30.0, 60.0], [60.0, 30.0]];
    let paths: Vec<PathBuf> = (0..)
        .zip(psi)
        .map(|(k, psi)| {
            let path = folder.path().join(format!("run{k}.csv"));
            csv_columns::write(&path, &gauge(&format!("run{k}"), psi)).unwrap();
            path
        })
        .collect();
    let weights = published_weights();
    let out = folder.path().join("found");
    let mut arguments = vec![
        "diagnose",
        "--no-law",
        "--model",
        text(&weights),
        "--out",
        text(&out),
        "--effects",
        "coulomb_friction",
        "--data",
    ];
    arguments.extend(paths.iter().map(|p| text(p)));
    let refused = run(PAM, &arguments);
    let said = String::from_utf8_lossy(&refused.stderr).into_owned();
    assert_eq!(refused.status.code(), Some(1), "{said}");
    for words in ["look like gauge pressures", "--pressure gauge", "--allow-implausible"] {
        assert!(said.contains(words), "{said}");
    }
    assert!(!out.join("diagnosis.json").exists());

    let inspected = run(PAM, &["inspect", "--json", "--model", text(&weights), text(&paths[1])]);
    let inspected: serde_json::Value = serde_json::from_slice(&inspected.stdout).unwrap();
    assert_eq!(inspected[0]["plausibility"][0]["kind"], "gauge_pressure", "{inspected}");
    let read_as_gauge =
        ["inspect", "--json", "--pressure", "gauge", "--model", text(&weights), text(&paths[1])];
    let read_as_gauge = run(PAM, &read_as_gauge);
    let read_as_gauge: serde_json::Value = serde_json::from_slice(&read_as_gauge.stdout).unwrap();
    assert_eq!(read_as_gauge[0]["plausibility"], serde_json::json!([]));

    let mut insisted = arguments.clone();
    insisted.insert(1, "--allow-implausible");
    let insisted = run(PAM, &insisted);
    assert!(insisted.status.success(), "{}", String::from_utf8_lossy(&insisted.stderr));
    let json: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("diagnosis.json")).unwrap())
            .unwrap();
    assert_eq!(json["plausibility"][0]["kind"], "gauge_pressure");
    let html = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(html.contains("look like gauge pressures"));
}
