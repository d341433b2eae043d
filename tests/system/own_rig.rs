//! A rig of one's own, from a file with other names, units and sizes to a trained model, a diagnosis and a plan. The
//! recordings in `data/elbow` are made by a script in another language.

use pam_tests::{run, stdout_of, text};
use serde_json::Value;
use std::fmt::Write;
use std::path::{Path, PathBuf};

const PAM: &str = env!("CARGO_BIN_EXE_pam-under-test");

fn elbow(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/elbow").join(name)
}

fn read(name: &str) -> String {
    std::fs::read_to_string(elbow(name)).unwrap()
}

/// What the file tells is guessed right, and what no file tells is asked for.
#[test]
fn a_first_rig_file_is_guessed() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("rig.toml");
    let recording = elbow("train-3.csv");
    let arguments = ["rig-file", "init", text(&recording), "--out", text(&out), "--json"];
    let json: Value = serde_json::from_str(&stdout_of(PAM, &arguments)).unwrap();
    let truth: toml::Table = read("rig.toml").parse().unwrap();
    for (key, column) in truth["columns"].as_table().unwrap() {
        let guessed = &json["rig"]["columns"][key];
        for part in ["column", "unit", "reference"] {
            let said = column.get(part).and_then(|v| v.as_str());
            assert_eq!(guessed[part].as_str(), said, "{key}.{part}");
        }
    }
    let missing: Vec<&str> =
        json["missing"].as_array().unwrap().iter().map(|m| m["key"].as_str().unwrap()).collect();
    for key in ["drive.pulley_radius_mm", "muscles.radius_mm", "muscles.length_mm"] {
        assert!(missing.contains(&key), "{missing:?}");
    }
    // It is a rig file as soon as the sizes are filled in, and it does not replace one unasked.
    let filled = std::fs::read_to_string(&out)
        .unwrap()
        .replace("# pulley_radius_mm =", "pulley_radius_mm = 25");
    std::fs::write(&out, filled).unwrap();
    let _ = stdout_of(PAM, &["rig-file", "check", text(&out)]);
    assert_eq!(run(PAM, &arguments).status.code(), Some(2));
}

/// Names without units, other separators, no header: the numbers tell the units.
#[test]
fn numbers_tell_what_names_do_not() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.txt");
    let mut out = "time pos p_left p_right current\n".to_owned();
    for line in read("train-1.csv").lines().skip(1) {
        let row: Vec<f64> = line.split(';').map(|c| c.replace(',', ".").parse().unwrap()).collect();
        // s, m at the tendon, kPa absolute, and a motor that pulls in the other direction.
        let x_m = row[1].to_radians() * 0.025;
        let [left, right] = [row[2], row[3]].map(|bar| 100.0 * bar + 101.325);
        writeln!(out, "{} {x_m} {left} {right} {}", 1e-3 * row[0], -row[4] / 0.9).unwrap();
    }
    std::fs::write(&path, out).unwrap();
    let rig = folder.path().join("rig.toml");
    let arguments = ["rig-file", "init", text(&path), "--out", text(&rig), "--json"];
    let json: Value = serde_json::from_str(&stdout_of(PAM, &arguments)).unwrap();
    let columns = &json["rig"]["columns"];
    assert_eq!(columns["time"]["unit"], "s");
    assert_eq!(columns["displacement"]["unit"], "m");
    assert_eq!(columns["pressure_flexor"]["column"], "p_right");
    assert_eq!(columns["pressure_flexor"]["unit"], "kPa");
    assert_eq!(columns["force"]["unit"], "A");
    assert_eq!(columns["force"]["sign"], -1.0);
    assert_eq!(json["rig"]["file"]["separator"], "space");
}

/// Rig files and recordings that are wrong in one way each: every one is named before anything is fitted.
#[test]
fn wrong_units_columns_and_files_are_named() {
    let (rig, csv) = (read("rig.toml"), read("train-3.csv"));
    let lines: Vec<&str> = csv.lines().collect();
    let with_line = |k: usize, line: &str| {
        let mut lines = lines.clone();
        lines[k] = line;
        lines.join("\n")
    };
    let with_column = |name: &str, cell: &dyn Fn(&str) -> String| {
        let mut rows = lines.iter();
        let mut out = format!("{}{name}\n", rows.next().unwrap());
        rows.for_each(|row| out += &format!("{}\n", cell(row)));
        out
    };
    let constant = with_column("", &|row| {
        let mut cells: Vec<&str> = row.split(';').collect();
        cells[2] = "2,0";
        cells.join(";")
    });
    let still = with_column(";v", &|row| format!("{row};0"));
    let velocity = rig.replace(
        "pressure_flexor =",
        "velocity = { column = \"v\", unit = \"deg/s\" }\npressure_flexor =",
    );
    let swapped =
        rig.replace("p_Bizeps", "P").replace("p_Trizeps", "p_Bizeps").replace("P (", "p_Trizeps (");
    let with = |from: &str, to: &str| (rig.replace(from, to), csv.clone());
    let of = |rig: String| (rig, csv.clone());
    let file = |csv: String| (rig.clone(), csv);
    let cases: Vec<(&str, (String, String), &str)> = vec![
        ("degrees as mm", with("\"deg\"", "\"mm\""), "displacement"),
        ("degrees as radians", with("\"deg\"", "\"rad\""), "pressures"),
        ("gauge as absolute", with("\"gauge\"", "\"absolute\""), "gauge"),
        ("bar as kPa", with("\"bar\"", "\"kPa\""), "pressures look like"),
        ("bar as psi", with("\"bar\"", "\"psi\""), "bar gauge"),
        ("bar as MPa", with("\"bar\"", "\"MPa\""), "bar gauge where MPa"),
        ("ms as s", with("\"ms\"", "\"s\""), "looks like ms"),
        ("ms as µs", with("\"ms\"", "\"us\""), "200000 Hz"),
        ("swapped muscles", of(swapped), "swapped"),
        (
            "sign of the angle",
            with("unit = \"deg\"", "unit = \"deg\", sign = -1"),
            "sign of the displacement",
        ),
        (
            "sign of the torque",
            with("unit = \"N m\"", "unit = \"N m\", sign = -1"),
            "sign of the force",
        ),
        ("prefix of the torque", with("\"N m\"", "\"mN m\""), "multiply force_n by 1000"),
        ("pulley", with("pulley_radius_mm = 25", "pulley_radius_mm = 2.5"), "displacement"),
        ("length of the muscles", with("length_mm = 250", "length_mm = 50"), "displacement"),
        ("no pulley", with("pulley_radius_mm = 25", ""), "drive.pulley_radius_mm"),
        ("unknown unit", with("\"deg\"", "\"ticks\""), "no unit of displacement"),
        ("unknown key", with("[drive]", "[drive]\npuley = 3"), ":12: unknown field `puley`"),
        (
            "missing columns",
            of(rig.replace("Winkel", "Angle").replace("Drehmoment", "Torque")),
            "`Torque (Nm)` (force)",
        ),
        ("one column twice", with("p_Trizeps", "p_Bizeps"), "are both"),
        ("separator", of(format!("{rig}[file]\nseparator = \",\"\n")), "missing"),
        ("decimal mark", of(format!("{rig}[file]\ndecimal = \".\"\n")), "is not a number"),
        (
            "text in a cell",
            file(with_line(50, "245;abc;2,0;2,0;0,1")),
            ":51: column `Winkel (deg)`: `abc`",
        ),
        ("a short row", file(with_line(50, "1;2;3")), ":51: 3 cells"),
        ("time goes back", file(with_line(50, lines[20])), ":51: time does not increase"),
        ("a dead pressure", file(constant), "never changes"),
        ("a velocity of zeros", (velocity, still), "velocity is zero"),
    ];
    let folder = tempfile::tempdir().unwrap();
    let [rig_file, data, out] = ["rig.toml", "train-3.csv", "out"].map(|n| folder.path().join(n));
    for (what, (rig, csv), named) in cases {
        std::fs::write(&rig_file, rig).unwrap();
        std::fs::write(&data, csv).unwrap();
        let output = run(
            PAM,
            &[
                "evaluate",
                "--model",
                "spring-damper",
                "--rig-file",
                text(&rig_file),
                "--data",
                text(&data),
                "--out",
                text(&out),
            ],
        );
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(said.contains(named), "{what}: {said}");
        // A single recording leaves a doubt between gauge and absolute: a warning.
        assert!(!output.status.success() || said.contains("gauge"), "{what}: {said}");
    }
}

/// A converted file brings its rig along: alone, with the rig file written beside it, and with the first rig file it gives
/// the model start of the original.
#[test]
fn converted_recordings_keep_their_rig() {
    let folder = tempfile::tempdir().unwrap();
    let rig = folder.path().join("rig.toml");
    // A rig in the mountains, at rest for a while, which filters.
    std::fs::write(
        &rig,
        format!(
            "{}\n[air]\natmosphere_kpa = 85\nrest_s = 0.5\ntemperature_c = 30\n[filter]\npressure_hz = 20\n",
            read("rig.toml")
        ),
    )
    .unwrap();
    let original = elbow("train-1.csv");
    let inspected = |file: &Path, rig: Option<&Path>| -> Value {
        let mut arguments = vec!["inspect", text(file), "--json"];
        arguments.extend(rig.iter().flat_map(|rig| ["--rig-file", text(rig)]));
        let all: Value = serde_json::from_str(&stdout_of(PAM, &arguments)).unwrap();
        let r = &all[0]["recordings"][0];
        let keys = ["mass_flexor_g", "mass_extensor_g", "at_rest", "ranges", "mass_origin"];
        Value::from_iter(keys.map(|key| (key, r[key].clone())))
    };
    let truth = inspected(&original, Some(&rig));
    assert_ne!(truth, inspected(&original, Some(&elbow("rig.toml"))), "the sizes matter");
    for name in ["run.csv", "run.npz"] {
        let out = folder.path().join(name);
        let arguments =
            ["convert", text(&original), text(&out), "--rig-file", text(&rig), "--json"];
        let said: Value = serde_json::from_str(&stdout_of(PAM, &arguments)).unwrap();
        let beside = folder.path().join("run.rig.toml");
        assert_eq!(said["written"], serde_json::json!([out, beside]));
        assert_eq!(inspected(&out, None), truth, "{name} alone");
        assert_eq!(inspected(&out, Some(&beside)), truth, "{name} with the rig file beside it");
        assert_eq!(inspected(&out, Some(&rig)), truth, "{name} with the first rig file");
        std::fs::remove_file(&beside).unwrap();
    }
    // Recordings of two rigs have no common start.
    let other = folder.path().join("other.csv");
    let first = elbow("rig.toml");
    let _ = stdout_of(PAM, &["convert", text(&original), text(&other), "--rig-file", text(&first)]);
    let both = run(PAM, &["inspect", text(&other), text(&folder.path().join("run.csv"))]);
    let said = String::from_utf8_lossy(&both.stderr);
    assert!(!both.status.success() && said.contains("--rig-file"), "{said}");
}

/// Run by `cargo test --release --workspace --tests -- --ignored long::`.
mod long {
    use super::*;

    /// With one rig file and no script: trained on recordings under the lab's own names, the mass found or withheld, dry
    /// friction named with an interval that holds it, and a plan.
    #[test]
    #[ignore = "long"]
    fn an_elbow_is_trained_diagnosed_and_planned() {
        let folder = tempfile::tempdir().unwrap();
        let [trained, found, plan] = ["run", "found", "plan"].map(|n| folder.path().join(n));
        let rig = elbow("rig.toml");
        let mut arguments = vec!["train", "--rig-file", text(&rig), "--data"];
        let data = elbow("");
        arguments.extend([
            text(&data),
            "--train",
            "train-*",
            "--heldout",
            "train-5",
            "--json",
            "--quiet",
        ]);
        // A third of the steps is enough for this motion.
        arguments.extend([
            "--set",
            "stage.1.matching.steps=2000",
            "--set",
            "stage.1.matching.mass_steps=1500",
        ]);
        arguments.extend(["--set", "stage.2.epochs=25"]);
        // Which of two frictions that are the same at one pressure comes first depends on the trained network, so the test has rates and
        // batches of its own.
        arguments.extend(["--set", "rate=1e-4", "--set", "stage.1.matching.rate=6e-3"]);
        arguments.extend(["--set", "stage.1.matching.batch=2048"]);
        arguments.extend(["--out", text(&trained)]);
        let json: Value = serde_json::from_str(&stdout_of(PAM, &arguments)).unwrap();
        assert_eq!(json["trained_on"].as_array().unwrap().len(), 5);
        let held_out =
            json["stages"].as_array().unwrap().last().unwrap()["r2_held_out"][0].as_f64().unwrap();
        assert!(held_out > 0.95, "{held_out}");
        // 4e-3 kg m² on a pulley of 25 mm.
        if let Some(mass) = json["parameters"]["mass_kg"].as_f64() {
            assert!((mass / 6.4 - 1.0).abs() < 0.1, "{mass}");
        }

        // The model brings the rig file along.
        let model = trained.join("model.safetensors");
        let [first, second] = ["stiff-1.csv", "stiff-2.csv"].map(elbow);
        let sound: Vec<PathBuf> = (1..=5).map(|k| elbow(&format!("train-{k}.csv"))).collect();
        let mut arguments =
            vec!["diagnose", "--no-law", "--model", text(&model), "--json", "--quiet", "--healthy"];
        arguments.extend(sound.iter().map(|path| text(path)));
        arguments.extend(["--data", text(&first), text(&second), "--out", text(&found)]);
        let json: Value = serde_json::from_str(&stdout_of(PAM, &arguments)).unwrap();
        let causes = json["causes"].as_array().unwrap();
        assert_eq!(causes[0]["effect"], "coulomb_friction", "{causes:?}");
        let friction = &causes[0];
        let interval = &friction["parameters"]["force_n"]["ci95"];
        let [low, high] = [0, 1].map(|k| interval[k].as_f64().unwrap());
        assert!(low <= 6.0 && 6.0 <= high, "6 N of dry friction: [{low}, {high}]");

        let arguments = [
            "plan",
            "--model",
            text(&model),
            "--motion",
            "sine:A=3,f=0.2",
            "--stiffness",
            "25",
            "--out",
            text(&plan),
            "--quiet",
        ];
        let _ = stdout_of(PAM, &arguments);
        assert!(plan.join("table.csv").exists());
    }
}
