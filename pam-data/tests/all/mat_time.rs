//! What times the samples of a MATLAB run.

use pam_data::{LoadOptions, PressureReference, Recording, RigFile, open_recordings};

/// A level 5 file of real arrays.
fn mat(arrays: &[(&str, &[f64])]) -> Vec<u8> {
    let element = |kind: u32, content: &[u8]| {
        let mut out = kind.to_le_bytes().to_vec();
        out.extend((content.len() as u32).to_le_bytes());
        out.extend(content);
        out.resize(out.len().next_multiple_of(8), 0);
        out
    };
    let mut file = b"MATLAB 5.0 MAT-file".to_vec();
    file.resize(124, b' ');
    file.extend([0, 1, b'I', b'M']);
    for (name, values) in arrays {
        let doubles: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let size: Vec<u8> = [values.len() as u32, 1].iter().flat_map(|n| n.to_le_bytes()).collect();
        let mut array = element(6, &[6, 0, 0, 0, 0, 0, 0, 0]);
        array.extend(element(5, &size));
        array.extend(element(1, name.as_bytes()));
        array.extend(element(9, &doubles));
        file.extend(element(14, &array));
    }
    file
}

const ROWS: usize = 100;

/// A run of `ROWS` samples with further arrays, whose pressures are `p1` and 400 kPa.
fn run(more: &[(&str, &[f64])], p1: f64, options: &LoadOptions) -> Result<Vec<Recording>, String> {
    let wave: Vec<f64> = (0..ROWS).map(|k| 1e-3 * (k as f64 / 9.0).sin()).collect();
    let (low, high) = (vec![p1; ROWS], vec![400.0; ROWS]);
    let mut arrays: Vec<(&str, &[f64])> =
        vec![("x", &wave), ("dx", &wave), ("F", &wave), ("p1", &low), ("p2", &high)];
    arrays.extend(more);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mat");
    std::fs::write(&path, mat(&arrays)).unwrap();
    open_recordings(&path, options).map_err(|e| e.to_string())
}

fn with_rate(rate_hz: f64) -> LoadOptions {
    let rig = RigFile::parse(&format!("[file]\nrate_hz = {rate_hz}\n"), "rig.toml").unwrap();
    LoadOptions { rig: Some(rig), ..LoadOptions::default() }
}

/// The rig file's rate, then a scalar, then an array as long as x, then 1 kHz; what decided is noted.
#[test]
fn times_come_from_rig_file_scalar_array_or_the_published_rate() {
    let plain = LoadOptions::default();
    let times: Vec<f64> = (0..ROWS).map(|k| 5.0 + 0.004 * k as f64).collect();
    let step = |more: &[(&str, &[f64])], options: &LoadOptions, noted: &str| {
        let r = run(more, 400.0, options).unwrap().remove(0);
        assert!(noted.is_empty() || r.notes.iter().any(|n| n.contains(noted)), "{:?}", r.notes);
        (r.time_s[0], (r.time_s[ROWS - 1] - r.time_s[0]) / (ROWS - 1) as f64)
    };
    let close = |(first, step): (f64, f64), (a, b): (f64, f64)| {
        assert!((first - a).abs() < 1e-12 && (step - b).abs() < 1e-12, "{first} {step}");
    };
    close(step(&[], &plain, ""), (0.0, 1e-3));
    close(step(&[("Fs", &[500.0])], &plain, "500 Hz of `Fs`"), (0.0, 2e-3));
    for name in ["t", "time", "time_s", "Time"] {
        close(step(&[(name, &times)], &plain, &format!("timed by `{name}`")), (5.0, 4e-3));
    }
    close(step(&[("Fs", &[500.0]), ("t", &times)], &plain, "`Fs`"), (0.0, 2e-3));
    close(step(&[("Fs", &[500.0]), ("t", &times)], &with_rate(100.0), "rig file"), (0.0, 1e-2));
    // Another array of that name is no time base.
    close(step(&[("t", &[1.0, 2.0])], &plain, ""), (0.0, 1e-3));
}

/// Gaps in the times split the run; times and rates that cannot be are refused by name.
#[test]
fn times_of_matlab_files_are_checked() {
    let plain = LoadOptions::default();
    let gap: Vec<f64> =
        (0..ROWS).map(|k| 0.004 * k as f64 + if k < 60 { 0.0 } else { 1.0 }).collect();
    let parts = run(&[("t", &gap)], 400.0, &plain).unwrap();
    assert_eq!(parts.iter().map(Recording::len).collect::<Vec<_>>(), [60, 40]);
    let back: Vec<f64> = (0..ROWS).map(|k| -(k as f64)).collect();
    assert!(run(&[("t", &back)], 400.0, &plain).unwrap_err().contains("does not increase"));
    let said = run(&[("Fs", &[-1.0])], 400.0, &plain).unwrap_err();
    assert!(
        said.contains("run.mat") && said.contains("`Fs`") && said.contains("positive"),
        "{said}"
    );
}

/// Constant pressures decide nothing, negative ones everything; the atmosphere is that of the rig file.
#[test]
fn the_zero_of_pressures_is_told() {
    let auto = LoadOptions::default();
    let r = run(&[], 300.0, &auto).unwrap().remove(0);
    assert_eq!(r.pressure_flexor_kpa[0], 300.0);
    assert!(r.notes.iter().any(|n| n.contains("--pressure gauge")), "{:?}", r.notes);
    let rig = RigFile::parse("[air]\natmosphere_kpa = 90\n", "rig.toml").unwrap();
    let gauge = LoadOptions {
        pressure_reference: PressureReference::Gauge,
        rig: Some(rig),
        ..LoadOptions::default()
    };
    assert_eq!(run(&[], 300.0, &gauge).unwrap()[0].pressure_flexor_kpa[0], 390.0);
    let said = run(&[], -3.0, &auto).unwrap_err();
    assert!(said.contains("--pressure gauge") && said.contains("reference = \"gauge\""), "{said}");
}
