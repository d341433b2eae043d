//! Planning, identification, tracking and receding-horizon MPC through the commands, on the virtual rig.

use pam_tests::{published_weights, run, stdout_of, text};
use serde_json::Value;
use std::path::Path;

const PAM: &str = env!("CARGO_BIN_EXE_pam-under-test");

fn json_of(arguments: &[&str]) -> Value {
    serde_json::from_str(&stdout_of(PAM, arguments)).expect("JSON")
}

/// The message of a command that ends with `code`: 1 for a task that cannot be met or a file that cannot be
/// read, 2 for wrong usage.
fn error_of(code: i32, arguments: &[&str]) -> String {
    let output = run(PAM, arguments);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}");
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn a_plan_is_written_in_every_form() {
    let folder = tempfile::tempdir().unwrap();
    let (model, out) = (published_weights(), folder.path().join("plan"));
    let plan = json_of(&[
        "plan",
        "--model",
        text(&model),
        "--motion",
        "sine:A=1,f=0.2,duration=6",
        "--stiffness",
        "150",
        "--json",
        "--out",
        text(&out),
    ]);
    let summary = &plan["summary"];
    assert_eq!(summary["samples"], 6001);
    assert!(number(&summary["largest_residual_mn"]) <= 1e-3);
    assert_eq!(summary["reached"], summary["samples"]);
    for name in ["table.csv", "table.h", "plan.json", "report.html", "run.json"] {
        assert!(out.join(name).exists(), "{name}");
    }
    let bytes = std::fs::read(out.join("table.bin")).unwrap();
    let table = pam_embedded::Table::new(&bytes).unwrap();
    assert_eq!((table.rows(), table.columns()), (6001, 8));
    let network = std::fs::read(out.join("network.bin")).unwrap();
    assert!(pam_embedded::Network::<f32>::new(&network).is_ok());
}

#[test]
fn the_reachable_range_is_the_published_one() {
    let folder = tempfile::tempdir().unwrap();
    let model = published_weights();
    let map = json_of(&[
        "stiffness",
        "--model",
        text(&model),
        "--velocities",
        "0",
        "--reach",
        "2",
        "--json",
        "--out",
        text(&folder.path().join("map")),
    ]);
    let middle = map["reachable"]
        .as_array()
        .unwrap()
        .iter()
        .find(|r| number(&r["displacement_mm"]).abs() < 1e-9)
        .unwrap();
    let range = &middle["stiffness_n_mm"];
    assert!((number(&range[0]) - 127.6).abs() < 0.1 && (number(&range[1]) - 174.2).abs() < 0.1);
}

fn identify(out: &Path, more: &[&str]) -> Value {
    json_of(&[&["identify", "--json", "--quiet", "--out", text(out)], more].concat())
}

#[test]
fn tracking_errors_grow_with_frequency() {
    let folder = tempfile::tempdir().unwrap();
    let found = json_of(&[
        "track",
        "--shapes",
        "sine",
        "--series",
        "frequency",
        "--json",
        "--quiet",
        "--out",
        text(&folder.path().join("track")),
    ]);
    let errors: Vec<f64> =
        found["results"].as_array().unwrap().iter().map(|r| number(&r["rmse_mm"])).collect();
    assert_eq!(errors.len(), 5);
    assert!(errors.windows(2).all(|e| e[1] > e[0]), "{errors:?}");
    assert!(errors[0] < 0.127, "0.1 Hz: {} mm, published 0.127", errors[0]);
}

/// Run by `cargo test --release --workspace --tests -- --ignored long::`.
mod long {
    use super::*;

    /// Identified stiffness rises with the commanded one from end to end, and a stiff joint gives way less
    /// under the same pulse, by about the published ratio (0.45 mm to 0.74 mm).
    #[test]
    #[ignore = "long"]
    fn the_staircase_is_climbed() {
        let folder = tempfile::tempdir().unwrap();
        let found = identify(&folder.path().join("stair"), &[]);
        let pulses = found["pulses"].as_array().unwrap();
        let mean = |level: f64, field: &str| {
            let of: Vec<f64> = pulses
                .iter()
                .filter(|p| (number(&p["commanded_n_mm"]) - level).abs() < 0.5)
                .map(|p| number(&p["estimate"][field]))
                .collect();
            assert_eq!(of.len(), 4);
            of.iter().sum::<f64>() / of.len() as f64
        };
        let levels = [126.0, 136.0, 146.0, 156.0, 166.0, 176.0];
        let k: Vec<f64> = levels.iter().map(|&l| mean(l, "stiffness_n_mm")).collect();
        assert!(k.windows(2).all(|k| k[1] > k[0]), "{k:?}");
        assert!(k.iter().zip(levels).all(|(k, l)| (k - l).abs() < 20.0), "{k:?}");
        let ratio = mean(176.0, "peak_mm") / mean(126.0, "peak_mm");
        assert!((ratio - 0.45 / 0.74).abs() < 0.08, "peaks in the ratio {ratio}");
    }

    #[test]
    #[ignore = "long"]
    fn what_cannot_be_reached_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let (model, out) = (published_weights(), folder.path().join("plan"));
        let base = ["plan", "--model", text(&model), "--out", text(&out)];
        let with = |more: &[&str]| run(PAM, &[&base, more].concat());
        let output = with(&["--motion", "hold:x=0", "--stiffness", "190"]);
        assert_eq!(output.status.code(), Some(3), "the nearest stiffness is no success");
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(told.contains("wanted 190.0") && told.contains("174."), "{told}");
        let table = std::fs::read_to_string(out.join("table.csv")).unwrap();
        assert!(table.lines().skip(1).all(|l| l.ends_with(",0,0")), "flagged in every row");

        let output =
            with(&["--motion", "hold:x=0", "--stiffness", "177", "--mass-bounds", "0.02,0.2"]);
        let told = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(told.contains("extrapolates"), "{told}");

        let fails = |code: i32, more: &[&str]| error_of(code, &[&base, more].concat());
        let message = fails(1, &["--motion", "sine:A=4,f=0.2", "--stiffness", "150"]);
        assert!(
            message.contains("cannot be reached at t =") && message.contains("N within"),
            "{message}"
        );
        for (motion, stiffness, expected, code) in [
            ("sine:A=1", "150", "`f` is missing", 2),
            ("sine:A=nan,f=1", "150", "A is not finite", 2),
            ("square:A=1,f=1", "150", "known are sine", 2),
            ("sine:A=1,f=0.1", "-3", "positive", 2),
            ("nowhere.csv", "150", "nowhere.csv", 1),
        ] {
            let message = fails(code, &["--motion", motion, "--stiffness", stiffness]);
            assert!(message.contains(expected), "{motion}: {message}");
        }
        let message = fails(2, &["--motion", "hold:x=0"]);
        assert!(message.contains("stiffness"), "{message}");
        let csv = folder.path().join("motion.csv");
        std::fs::write(&csv, "time_s,displacement_mm\n0,0\n0.1,abc\n0.2,0\n").unwrap();
        let message = fails(1, &["--motion", text(&csv), "--stiffness", "150"]);
        assert!(message.contains("motion.csv:3") && message.contains("abc"), "{message}");
    }

    /// Against a load step that neither knows, MPC misses by less than a third of the table's error.
    #[test]
    #[ignore = "long"]
    fn mpc_beats_the_table() {
        let folder = tempfile::tempdir().unwrap();
        let found =
            json_of(&["replan", "--json", "--quiet", "--out", text(&folder.path().join("replan"))]);
        let of = |stretch: &str| {
            let rows = found["rmse_mm"].as_array().unwrap();
            number(&rows.iter().find(|r| r["stretch"] == stretch).unwrap()["ratio"])
        };
        assert!(of("from the load on") > 3.0);
        assert!(number(&found["horizon_ms"]) >= 100.0);
        assert!(number(&found["decision_us"]["median"]) < 1000.0);
    }

    /// The same when the wanted displacement changes and the table does not know it.
    #[test]
    #[ignore = "long"]
    fn mpc_follows_changed_targets() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("replan");
        let found = json_of(
            &[
                &[
                    "replan",
                    "--json",
                    "--quiet",
                    "--load",
                    "0",
                    "--shift",
                    "0.5",
                    "--shift-at",
                    "4",
                ][..],
                &["--out", text(&out)],
            ]
            .concat(),
        );
        let rows = found["rmse_mm"].as_array().unwrap();
        let after = rows.iter().find(|r| r["stretch"] == "from the changed target on").unwrap();
        assert!(number(&after["ratio"]) > 3.0, "{rows:?}");
    }
}
