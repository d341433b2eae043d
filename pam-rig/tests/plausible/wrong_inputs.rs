//! Wrong input of every kind that labs hand in: each is named before anything is fitted, by an error of the reader, by the
//! physics, or by the quality of the channels.

use super::{MODEL, SOUND, displacement, pressures, scale, swap};
use pam_data::formats::csv_columns;
use pam_data::plausibility::Severity;
use pam_data::plausibility::check;
use pam_data::quality::{self, QualityKind, QualitySettings};
use pam_data::{LoadOptions, MassOptions, Recording, SavedModel, Subject, open_recordings};

/// What is said of a file before a fit: the error of the reader, or findings.
fn said(text: &str, options: &LoadOptions, model: &SavedModel) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.csv");
    std::fs::write(&path, text).unwrap();
    let recordings = match open_recordings(&path, options) {
        Ok(recordings) => recordings,
        Err(e) => return e.to_string(),
    };
    let qualities: Vec<quality::Quality> =
        recordings.iter().map(|r| quality::assess(r, &QualitySettings::default())).collect();
    let subjects = match Subject::resolve(recordings, model, &MassOptions::default()) {
        Ok(subjects) => subjects,
        Err(e) => return e.to_string(),
    };
    let physics = check(&model.model, &subjects);
    let sentences = physics.iter().map(|f| f.message.clone());
    let told = qualities.iter().flat_map(|q| &q.findings);
    let told = told.filter(|f| {
        f.severity == Severity::Error || matches!(f.kind, QualityKind::Delay | QualityKind::Dead)
    });
    sentences.chain(told.map(|f| f.message.clone())).collect::<Vec<_>>().join("\n")
}

/// Unequal pressures: equal ones hide some mistakes. A file of another program gives no reading at rest.
fn sound() -> Recording {
    Recording { sealed: None, ..SOUND[1].clone() }
}

fn changed(change: impl Fn(&mut Recording)) -> String {
    let mut r = sound();
    change(&mut r);
    csv_columns::to_csv(&r, None)
}

/// Replaces the cell of a column in a line of text (counted from one, the names are the first).
fn with_cell(line: usize, column: usize, value: &str) -> String {
    let text = csv_columns::to_csv(&sound(), None);
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let mut cells: Vec<&str> = lines[line - 1].split(',').collect();
    cells[column] = value;
    lines[line - 1] = cells.join(",");
    lines.join("\n")
}

fn delayed(values: &mut Vec<f64>, samples: usize) {
    let first = values[0];
    values.splice(0..0, std::iter::repeat_n(first, samples));
    values.truncate(values.len() - samples);
}

#[test]
fn each_wrong_input_is_named() {
    let plain = LoadOptions::default();
    let text = || csv_columns::to_csv(&sound(), None);
    // A millimetre of the tendon is 8.33 degrees of the published pulley.
    let degrees = 1.0 / (6.875 * std::f64::consts::PI / 180.0);
    let with_masses = |factor: f64| {
        let m = gas_law_masses(factor);
        format!("# mass_flexor_g = {}\n# mass_extensor_g = {}\n{}", m[0], m[1], text())
    };
    let semicolons = text().replace(',', ";");
    let cases: Vec<(&str, String, &[&str])> = vec![
        ("degrees as mm", changed(|r| displacement(r, degrees)), &["degrees of the pulley"]),
        ("m as mm", changed(|r| displacement(r, 1e-3)), &["looks like m where mm"]),
        ("bar as kPa", changed(|r| pressures(r, |p| 0.01 * p)), &["bar absolute"]),
        (
            "psi gauge as kPa",
            changed(|r| pressures(r, |p| (p - 101.325) / 6.894_76)),
            &["psi gauge"],
        ),
        (
            "gauge as absolute",
            changed(|r| pressures(r, |p| p - 101.325)),
            &["look like gauge pressures"],
        ),
        ("ms as s", changed(|r| scale(&mut r.time_s, 1e3)), &["looks like ms"]),
        ("swapped pressures", changed(swap), &["swapped"]),
        (
            "velocity of zeros",
            changed(|r| scale(&mut r.velocity_mm_s, 0.0)),
            &["velocity is zero throughout"],
        ),
        ("velocity in m/s", changed(|r| scale(&mut r.velocity_mm_s, 1e-3)), &["looks like m/s"]),
        (
            "velocity of the wrong sign",
            changed(|r| scale(&mut r.velocity_mm_s, -1.0)),
            &["sign is wrong"],
        ),
        (
            "force of the wrong sign",
            changed(|r| scale(&mut r.force_mn, -1.0)),
            &["sign of the force is wrong"],
        ),
        (
            "displacement of the wrong sign",
            changed(|r| displacement(r, -1.0)),
            &["sign of the displacement is wrong"],
        ),
        ("mN as N", changed(|r| scale(&mut r.force_mn, 1e3)), &["force is", "mN where N"]),
        (
            "dead pressure",
            changed(|r| r.pressure_flexor_kpa.fill(300.0)),
            &["pressure_flexor_kpa", "dead"],
        ),
        ("dead encoder", changed(|r| displacement(r, 0.0)), &["displacement never changes"]),
        (
            "the same pressure twice",
            changed(|r| r.pressure_extensor_kpa = r.pressure_flexor_kpa.clone()),
            &["rise and fall together"],
        ),
        (
            "clipped pressure",
            changed(|r| {
                let mut sorted = r.pressure_flexor_kpa.clone();
                sorted.sort_by(f64::total_cmp);
                let limit = sorted[sorted.len() * 9 / 10];
                r.pressure_flexor_kpa.iter_mut().for_each(|p| *p = p.min(limit));
            }),
            &["pressure_flexor_kpa is clipped", "10.0 % of the time"],
        ),
        (
            "delayed pressure",
            changed(|r| delayed(&mut r.pressure_extensor_kpa, 120)),
            &["pressure_extensor_kpa comes", "after displacement_mm"],
        ),
        (
            "delayed velocity",
            changed(|r| delayed(&mut r.velocity_mm_s, 60)),
            &["velocity_mm_s comes", "after the derivative"],
        ),
        ("masses in mg", with_masses(1e3), &["masses that the file gives"]),
        ("repeated time", with_cell(40, 0, "0"), &["run.csv:40", "time_s", "repeated"]),
        ("not a number", with_cell(12, 3, "NaN"), &["run.csv:12", "pressure_flexor_kpa", "NaN"]),
        ("text in a cell", with_cell(9, 5, "off"), &["run.csv:9", "force_n", "`off`"]),
        (
            "missing columns",
            text().replace("displacement_mm", "x").replace("force_n", "F"),
            &["displacement_mm`, `force_n` are missing", "rig-file init"],
        ),
        ("semicolons", semicolons.clone(), &["run.csv:1", "missing", "rig-file init"]),
        (
            "decimal commas",
            semicolons.replace('.', ","),
            &["run.csv:1", "missing", "rig-file init"],
        ),
        ("truncated", text()[..text().len() - 30].to_owned(), &["cells", "truncated"]),
    ];
    let mut missed = Vec::new();
    for (name, text, words) in &cases {
        let said = said(text, &plain, &MODEL);
        if !words.iter().all(|w| said.contains(w)) {
            missed.push(format!("{name}: {said}"));
        }
    }
    // Options and models that do not fit the file.
    let mut loader = plain.clone();
    loader.raw_log.set("pulley_radius_mm=20").unwrap();
    let heard = said(&text(), &loader, &MODEL);
    assert!(heard.contains("pulley_radius_mm") && heard.contains("does nothing here"), "{heard}");
    let mut long = MODEL.clone();
    long.model.geometry.length_mm *= 3.0;
    let heard = said(&text(), &plain, &long);
    assert!(heard.contains("Check length"), "{heard}");
    assert!(missed.is_empty(), "{}", missed.join("\n\n"));
}

/// Masses of the gas law at the first sample, times a factor, g.
fn gas_law_masses(factor: f64) -> [f64; 2] {
    let r = sound();
    let m = MODEL.model.gas_law_masses(
        r.displacement_mm[0],
        [r.pressure_flexor_kpa[0], r.pressure_extensor_kpa[0]],
    );
    [factor * m.flexor_g, factor * m.extensor_g]
}

/// Nothing is said of sound recordings, the real one among them.
#[test]
fn sound_recordings_are_not_blamed() {
    for r in SOUND.iter().chain(super::REAL.iter()) {
        let quality = quality::assess(r, &QualitySettings::default());
        let told: Vec<_> = quality
            .findings
            .iter()
            .filter(|f| f.severity == Severity::Error || f.kind == QualityKind::Delay)
            .collect();
        assert!(told.is_empty(), "{}: {told:#?} {:#?}", r.name, quality.delays);
    }
    let heard = said(&csv_columns::to_csv(&sound(), None), &LoadOptions::default(), &MODEL);
    assert_eq!(heard, "");
}
