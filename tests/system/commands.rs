//! The commands as a newcomer and a script use them.

use pam_tests::{published, published_weights, run, small_csv, stdout_of, text};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

const PAM: &str = env!("CARGO_BIN_EXE_pam-under-test");

/// Every file below a folder with its content.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut out = BTreeMap::new();
    let mut open = vec![folder.to_owned()];
    while let Some(next) = open.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().display().to_string();
                out.insert(name, std::fs::read(path).unwrap());
            }
        }
    }
    out
}

/// What `pam evaluate` prints for a model, data and a folder for the results.
fn evaluated([model, data, out]: [&std::path::Path; 3], more: &[&str]) -> String {
    let paths = ["--model", text(model), "--data", text(data), "--out", text(out)];
    stdout_of(PAM, &[&["evaluate", "--accept"], &paths[..], more].concat())
}

#[test]
fn an_evaluation_of_many_recordings_is_the_same_at_any_thread_count() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("data");
    std::fs::create_dir(&data).unwrap();
    for k in 0..5 {
        std::fs::write(data.join(format!("run{k}.csv")), small_csv(300 + 100 * k)).unwrap();
    }
    let weights = published_weights();
    let out = folder.path().join("out");
    let evaluate = |threads: &str| {
        let printed = evaluated([&weights, &data, &out], &["--json", "--threads", threads]);
        (printed, contents(&out))
    };
    let (one, two) = (evaluate("1"), evaluate("2"));
    assert_eq!(one, two);
    let json: Value = serde_json::from_str(&one.0).unwrap();
    let recordings = json["recordings"].as_array().unwrap();
    let names: Vec<&str> = recordings.iter().map(|r| r["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["run0", "run1", "run2", "run3", "run4"]);
    assert_eq!(recordings[0]["mass_flexor_g"], 0.0765);
    let mean = recordings.iter().map(|r| r["rmse"]["x"].as_f64().unwrap()).sum::<f64>() / 5.0;
    assert!((json["mean"]["rmse"]["x"].as_f64().unwrap() - mean).abs() < 1e-12);
}

#[test]
fn an_evaluation_writes_the_predictions_that_are_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let data = folder.path().join("run.csv");
    std::fs::write(&data, small_csv(300)).unwrap();
    let (weights, out) = (published_weights(), folder.path().join("out"));
    for (which, lines) in [("none", None), ("all", Some(300)), ("thinned", Some(300))] {
        let _ = evaluated([&weights, &data, &out], &["--predictions", which]);
        let csv = std::fs::read_to_string(out.join("predictions/run.csv")).ok();
        // A line of names stands before the samples.
        let samples = csv.map(|c| c.lines().filter(|l| !l.starts_with('#')).count() - 1);
        assert_eq!(samples, lines, "{which}");
        std::fs::remove_dir_all(&out).unwrap();
    }
}

#[test]
fn inspect_says_what_is_in_any_file() {
    let (weights, run) = (published_weights(), published("data.mat"));
    let (log, surfaces) = (published("nn_3060_excerpt.txt"), published("poly44_all_fits.mat"));
    let printed = stdout_of(
        PAM,
        &["inspect", text(&weights), text(&run), text(&log), text(&surfaces), "--json"],
    );
    let json: Value = serde_json::from_str(&printed).unwrap();
    assert_eq!(json[0]["activation"], "leaky_relu");
    assert_eq!(json[0]["parameters"], 9892);
    let k = json[0]["slopes"][0]["stiffness_four_point_n_mm"].as_f64().unwrap();
    assert!((k - 127.3).abs() < 0.1);
    assert_eq!(json[1]["recordings"][0]["samples"], 28_027);
    assert_eq!(json[2]["gaps"][0], serde_json::json!([6244.0, 6276.0]));
    assert!(json[2]["no_recording"].as_str().unwrap().contains("13 rows"));
    assert!(json[3]["arrays"].to_string().contains("coeffs_fF_loadingP"));
}

#[test]
fn inspect_sums_up_a_folder_and_goes_on_past_a_bad_file() {
    let folder = tempfile::tempdir().unwrap();
    for k in 0..3 {
        std::fs::write(folder.path().join(format!("run{k}.csv")), small_csv(101)).unwrap();
    }
    let printed = stdout_of(PAM, &["inspect", text(folder.path())]);
    assert!(printed.contains("3 recordings, 0.3 s"), "{printed}");
    std::fs::write(folder.path().join("run1.csv"), "time_s,force_n\n0,1\n").unwrap();
    let output = run(PAM, &["inspect", text(folder.path())]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("run1.csv:1"));
    assert!(String::from_utf8_lossy(&output.stdout).contains("2 recordings"));
}

#[test]
fn a_made_up_force_comes_to_rest_where_the_spring_says() {
    let folder = tempfile::tempdir().unwrap();
    let (out, report) = (folder.path().join("run.csv"), folder.path().join("run.html"));
    let _ = stdout_of(
        PAM,
        &[
            "simulate",
            "--model",
            "spring-damper",
            "--force",
            "step:A=100,t=0.5",
            "--duration",
            "4",
            "--air-masses",
            "0.0315272,0.0315272",
            "--out",
            text(&out),
            "--report",
            text(&report),
        ],
    );
    let csv = std::fs::read_to_string(&out).unwrap();
    assert!(csv.starts_with("# mass_flexor_g = 0.0315272\n"));
    let last: Vec<f64> =
        csv.lines().last().unwrap().split(',').map(|c| c.parse().unwrap()).collect();
    assert_eq!(last[0], 4.0);
    // 100 N on 127.3 N/mm.
    assert!((last[1] - 100.0 / 127.3).abs() < 1e-4, "{last:?}");
    assert!(std::fs::read_to_string(report).unwrap().contains("<svg"));
}

/// A recording with a gap is simulated in parts, each from its own first sample.
#[test]
fn a_recording_with_a_gap_is_simulated_in_parts() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let gapped: String = small_csv(400)
        .lines()
        .enumerate()
        .filter(|(i, _)| !(150..250).contains(i))
        .map(|(_, l)| format!("{l}\n"))
        .collect();
    std::fs::write(path("run.csv"), gapped).unwrap();
    let (data, out) = (path("run.csv"), path("out.csv"));
    let arguments = [
        "simulate",
        "--accept",
        "--model",
        "spring-damper",
        "--data",
        text(&data),
        "--out",
        text(&out),
        "--json",
    ];
    let json: Value = serde_json::from_str(&stdout_of(PAM, &arguments)).unwrap();
    let samples: Vec<u64> =
        json["runs"].as_array().unwrap().iter().map(|r| r["samples"].as_u64().unwrap()).collect();
    assert_eq!(samples, [147, 153]);
    let second = std::fs::read_to_string(path("out_2.csv")).unwrap();
    let first_row = second.lines().find(|l| l.starts_with(|c: char| c.is_ascii_digit()));
    assert!(first_row.unwrap().starts_with("0.247,"), "{second:.200}");
    assert!(
        second.contains("# sealed_pressure_flexor_kpa = 412\n"),
        "the valves stay closed across a gap"
    );
}

#[test]
fn conversions_chain() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("a.csv"), small_csv(100)).unwrap();
    let _ = stdout_of(PAM, &["convert", text(&path("a.csv")), text(&path("b.npz"))]);
    let _ = stdout_of(PAM, &["convert", text(&path("b.npz")), text(&path("c.csv"))]);
    let numbers = |name: &str| {
        let csv = std::fs::read_to_string(path(name)).unwrap();
        csv.lines()
            .skip(3)
            .flat_map(|l| l.split(',').map(|c| c.parse::<f64>().unwrap()).collect::<Vec<_>>())
            .collect::<Vec<_>>()
    };
    for (a, b) in numbers("a.csv").iter().zip(numbers("c.csv")) {
        assert!((a - b).abs() <= 1e-13 * a.abs());
    }
    let weights = published_weights();
    let _ = stdout_of(PAM, &["convert", text(&weights), text(&path("m.safetensors"))]);
    let printed = stdout_of(PAM, &["inspect", text(&path("m.safetensors")), "--json"]);
    assert!(printed.contains("127.3"));
}

/// A diverging recording does not stop the others; the exit code says so.
#[test]
fn a_failed_prediction_is_reported_and_the_rest_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("good.csv"), small_csv(300)).unwrap();
    // A chamber loses its volume when x passes L0/ν; only an absurd force gets there.
    let wild: String = small_csv(300)
        .lines()
        .enumerate()
        .map(|(i, l)| match l.rsplit_once(',') {
            Some((head, _)) if i > 2 => format!("{head},1e7\n"),
            _ => format!("{l}\n"),
        })
        .collect();
    std::fs::write(path("wild.csv"), wild).unwrap();
    let weights = published_weights();
    let out = path("out");
    let output = run(
        PAM,
        &[
            "evaluate",
            "--model",
            text(&weights),
            "--data",
            text(&path("good.csv")),
            text(&path("wild.csv")),
            "--out",
            text(&out),
            "--step-ms",
            "1",
            "--accept",
        ],
    );
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{errors}");
    assert!(errors.contains("wild") && errors.contains("t ="), "{errors}");
    let json: Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("evaluation.json")).unwrap())
            .unwrap();
    assert_eq!(json["recordings"].as_array().unwrap().len(), 1);
    assert_eq!(json["failed"][0]["name"], "wild");
}

#[test]
fn help_teaches() {
    let help = stdout_of(PAM, &["--help"]);
    for word in ["evaluate", "simulate", "inspect", "convert", "Examples", "Exit codes"] {
        assert!(help.contains(word), "{word}");
    }
    for command in ["evaluate", "simulate", "inspect", "convert", "demo"] {
        let help = stdout_of(PAM, &[command, "--help"]);
        assert!(help.contains("--seed") && help.contains("Exit codes: 0 success"), "{help}");
    }
    assert_eq!(run(PAM, &["evaluate"]).status.code(), Some(2));
}

/// The list of checks, and what is missing in it, for a person and for a script.
#[test]
fn doctor_finds_what_is_missing() {
    let checks: Value = serde_json::from_str(&stdout_of(PAM, &["doctor", "--json"])).unwrap();
    assert_eq!(checks["healthy"], true);
    let outcome = |checks: &Value, what: &str| {
        let all = checks["checks"].as_array().unwrap();
        all.iter().find(|c| c["what"] == what).unwrap()["outcome"].clone()
    };
    assert_eq!(outcome(&checks, "default model"), "ok");

    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "").unwrap();
    // A file is no folder to write in.
    let output = run(PAM, &["doctor", "--json", "--out", text(&file.join("below"))]);
    assert_eq!(output.status.code(), Some(1));
    let checks: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(outcome(&checks, "write access"), "failure");
}

#[test]
fn shells_and_man_know_every_command() {
    for shell in ["bash", "zsh", "fish"] {
        let script = stdout_of(PAM, &["completions", shell]);
        assert!(script.contains("diagnose") && script.contains("healthy"), "{shell}");
    }
    let folder = tempfile::tempdir().unwrap();
    let _ = stdout_of(PAM, &["man", "--out", text(folder.path())]);
    let page = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    assert!(page("pam.1").contains("diagnose"));
    assert!(page("pam-rig-record.1").contains("conditions"));
}

/// A plain model of an extended one: its load is part of the network's numbers.
#[test]
fn an_extended_model_becomes_a_plain_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let mut saved = pam_data::load_model(published_weights()).unwrap();
    let plain_force = saved.model.force.clone();
    for (effect, value) in [("constant_load", 12.0), ("coulomb_friction", 20.0)] {
        let record = serde_json::json!({ "effect": effect, "values": { "force_n": value } });
        saved.info.effects.push(record);
    }
    pam_data::models::save_model(path("extended.safetensors"), &saved).unwrap();
    let told = stdout_of(
        PAM,
        &[
            "convert",
            "--plain",
            text(&path("extended.safetensors")),
            text(&path("plain.safetensors")),
        ],
    );
    assert!(told.contains("coulomb_friction is left out"), "{told}");
    let plain = pam_data::load_model(path("plain.safetensors")).unwrap();
    assert!(plain.info.effects.is_empty());
    assert_eq!(Some(plain.model.force), plain_force.shifted(-12_000.0));
}

/// Run by `cargo test --release --workspace --tests -- --ignored long::`.
mod long {
    use super::*;

    /// The demonstration needs no file and no command, and the same seed writes the same bytes at any number of threads.
    #[test]
    #[ignore = "long"]
    fn the_default_needs_nothing_and_repeats() {
        let folder = tempfile::tempdir().unwrap();
        let output =
            std::process::Command::new(PAM).current_dir(folder.path()).output().expect("it starts");
        assert!(output.status.success());
        let printed = String::from_utf8(output.stdout).unwrap();
        assert!(printed.contains("Hidden in the logs") && printed.contains("report"), "{printed}");
        assert!(printed.lines().count() < 25, "one screen");
        let (default, again) = (folder.path().join("pam-demo"), folder.path().join("again"));
        let _ = stdout_of(PAM, &["demo", "--out", text(&again), "--seed", "1", "--threads", "1"]);
        // The recording is named by its file; only the folder's name differs.
        let without_folder = |out: &Path, name: &str| {
            contents(out)
                .into_iter()
                .map(|(k, v)| (k, String::from_utf8_lossy(&v).replace(name, "OUT")))
                .collect::<BTreeMap<_, _>>()
        };
        let files = without_folder(&default, "pam-demo");
        assert!(files.contains_key("report.html") && files.contains_key("diagnosis.json"));
        assert_eq!(files, without_folder(&again, text(&again)));
    }
}
