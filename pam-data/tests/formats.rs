//! Tables of other formats, read through rig files: the files are written by `tests/files/make_tables.py` with the
//! formats' own libraries.

#[cfg(any(feature = "parquet", feature = "mcap", feature = "hdf5"))]
use pam_data::Recording;
use pam_data::{LoadOptions, RigFile, open_recordings};
use std::path::{Path, PathBuf};

fn file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files").join(name)
}

/// A rig whose columns have these names: time, angle, pressures, torque.
fn options([time, angle, p1, p2, torque]: [&str; 5], angle_unit: &str) -> LoadOptions {
    let text = format!(
        "[columns]\ntime = {{ column = \"{time}\", unit = \"s\" }}\n\
         displacement = {{ column = \"{angle}\", unit = \"{angle_unit}\" }}\n\
         pressure_flexor = {{ column = \"{p1}\", unit = \"bar\", reference = \"gauge\" }}\n\
         pressure_extensor = {{ column = \"{p2}\", unit = \"bar\", reference = \"gauge\" }}\n\
         force = {{ column = \"{torque}\", unit = \"N m\" }}\n[drive]\npulley_radius_mm = 20\n"
    );
    let rig = RigFile::parse(&text, Path::new("rig.toml")).unwrap();
    LoadOptions { rig: Some(rig), ..LoadOptions::default() }
}

const PLAIN: [&str; 5] = ["t", "angle", "p1", "p2", "torque"];

/// The run that the script writes: 1 Hz, 10 degrees, 0.05 bar and 0.02 N·m a degree.
#[cfg(any(feature = "parquet", feature = "mcap", feature = "hdf5"))]
fn is_the_run(r: &Recording, first: usize, pressure: impl Fn(usize) -> usize) {
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-6 * b.abs().max(1.0), "{a} {b}");
    assert_eq!(r.len(), 200 - first);
    let degrees = |k: usize| 10.0 * (std::f64::consts::TAU * k as f64 / 100.0).sin();
    for k in first..200 {
        let i = k - first;
        close(r.time_s[i] - r.time_s[0], i as f64 / 100.0);
        close(r.displacement_mm[i], degrees(k).to_radians() * 20.0);
        let p = pressure(k);
        close(r.pressure_flexor_kpa[i], 401.325 - 5.0 * degrees(p));
        close(r.pressure_extensor_kpa[i], 401.325 + 5.0 * degrees(p));
        close(r.force_mn[i], 0.2 * degrees(k) / 0.02 * 1e3);
    }
}

#[cfg(feature = "parquet")]
#[test]
fn parquet_files_are_tables() {
    for name in ["run.parquet", "run.zstd.parquet"] {
        let r = open_recordings(file(name), &options(PLAIN, "deg")).unwrap().remove(0);
        is_the_run(&r, 0, |k| k);
    }
    let folder = tempfile::tempdir().unwrap();
    let cut = folder.path().join("cut.parquet");
    let bytes = std::fs::read(file("run.parquet")).unwrap();
    std::fs::write(&cut, &bytes[..3000]).unwrap();
    let said = open_recordings(cut, &options(PLAIN, "deg")).unwrap_err().to_string();
    assert!(said.contains("cut.parquet") && said.contains("Parquet"), "{said}");
}

#[cfg(feature = "hdf5")]
#[test]
fn matlab_7_3_files_are_tables() {
    let r = open_recordings(file("run73.mat"), &options(PLAIN, "deg")).unwrap().remove(0);
    is_the_run(&r, 0, |k| k);
    let arrays = pam_data::formats::mat::read(&file("run73.mat")).unwrap();
    assert_eq!(arrays["count"], [7.0]);
    assert!(!arrays.contains_key("label"), "text is no array of numbers");
}

#[cfg(feature = "mcap")]
#[test]
fn json_messages_are_columns_and_slow_topics_hold() {
    let names = ["log_time", "/drive.angle.deg", "/air.p[0]", "/air.p[1]", "/drive.torque"];
    // Chunks in Zstandard and in LZ4.
    for name in ["json.mcap", "json.lz4.mcap"] {
        let r = open_recordings(file(name), &options(names, "deg")).unwrap().remove(0);
        is_the_run(&r, 0, |k| k - k % 2);
        assert!(
            r.notes.iter().any(|n| n.contains("/drive") && n.contains("held")),
            "{:?}",
            r.notes
        );
    }
    // The slow topic as the clock: every other sample.
    let mut slow = options(names, "deg");
    slow.rig.as_mut().unwrap().file.clock = Some("/air".into());
    assert_eq!(open_recordings(file("json.mcap"), &slow).unwrap()[0].len(), 100);
    slow.rig.as_mut().unwrap().file.clock = Some("/nothing".into());
    let said = open_recordings(file("json.mcap"), &slow).unwrap_err().to_string();
    assert!(said.contains("/air, /drive"), "{said}");
}

#[cfg(feature = "mcap")]
#[test]
fn ros_2_messages_are_columns() {
    let names = [
        "/joint_states.header.stamp",
        "/joint_states.position[0]",
        "/air.pressure[0]",
        "/air.pressure[1]",
        "/joint_states.effort[0]",
    ];
    let r = open_recordings(file("ros2.mcap"), &options(names, "rad")).unwrap().remove(0);
    // The first joint state has no pressure yet; pressures come with the odd ones.
    assert!(
        (r.displacement_mm[0]
            - 10.0_f64.to_radians() * (std::f64::consts::TAU / 100.0).sin() * 20.0)
            .abs()
            < 1e-6
    );
    assert_eq!(r.len(), 199);
}

/// A build without a feature says how to get it.
#[test]
fn what_was_not_built_is_said() {
    let cases = [
        ("run.parquet", "parquet", cfg!(feature = "parquet")),
        ("json.mcap", "mcap", cfg!(feature = "mcap")),
        ("run73.mat", "hdf5", cfg!(feature = "hdf5")),
    ];
    for (name, feature, built) in cases {
        for options in [LoadOptions::default(), options(PLAIN, "deg")] {
            let read = open_recordings(file(name), &options);
            if !built {
                let said = read.unwrap_err().to_string();
                let command = format!("cargo build --release --features {feature}");
                assert!(said.contains(&command), "{said}");
            }
        }
    }
}
