//! `pam evaluate` with the published weights on the real measured run.

use pam_tests::{published, published_weights, stdout_of, text};
use serde_json::Value;

const PAM: &str = env!("CARGO_BIN_EXE_pam-under-test");

/// Columns of a CSV below its header lines.
fn columns(csv: &str) -> Vec<Vec<f64>> {
    let rows: Vec<Vec<f64>> = csv
        .lines()
        .filter(|l| !l.starts_with('#'))
        .skip(1)
        .map(|l| l.split(',').map(|c| c.parse().unwrap()).collect())
        .collect();
    (0..rows[0].len()).map(|c| rows.iter().map(|r| r[c]).collect()).collect()
}

#[test]
fn the_published_model_predicts_the_real_run_and_the_report_is_honest() {
    let folder = tempfile::tempdir().unwrap();
    let (weights, data) = (published_weights(), published("data.mat"));
    let out = folder.path().join("out");
    let arguments =
        ["evaluate", "--model", text(&weights), "--data", text(&data), "--out", text(&out)];
    let _ = stdout_of(PAM, &arguments);

    let json: Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("evaluation.json")).unwrap())
            .unwrap();
    let r = &json["recordings"][0];
    assert_eq!(r["name"], "data");
    for channel in ["x", "v", "pf", "pe"] {
        assert!(r["r2"][channel].is_f64() && r["rmse"][channel].is_f64());
        assert_eq!(r["r2"][channel], json["mean"]["r2"][channel]);
    }

    // R² and RMSE again, from the files alone.
    let predicted = columns(&std::fs::read_to_string(out.join("predictions/data.csv")).unwrap());
    let measured_csv = folder.path().join("measured.csv");
    let _ = stdout_of(PAM, &["convert", text(&data), text(&measured_csv)]);
    let measured = columns(&std::fs::read_to_string(measured_csv).unwrap());
    assert_eq!(predicted[0].len(), 28_027);
    for (column, key) in [(1, "x"), (2, "v"), (3, "pf"), (4, "pe")] {
        assert_eq!(predicted[column][0], measured[column][0], "starts from the first row");
        let mean = measured[column].iter().sum::<f64>() / 28_027.0;
        let (mut residual, mut total) = (0.0, 0.0);
        for (m, p) in measured[column].iter().zip(&predicted[column]) {
            residual += (m - p).powi(2);
            total += (m - mean).powi(2);
        }
        assert!((r["r2"][key].as_f64().unwrap() - (1.0 - residual / total)).abs() < 1e-9);
        assert!((r["rmse"][key].as_f64().unwrap() - (residual / 28_027.0).sqrt()).abs() < 1e-9);
    }

    // The reference says: about ±45 N of dry friction. The missing force must show it.
    let balance = &r["force_balance"];
    let direction = balance["direction_n"].as_f64().unwrap();
    assert!((25.0..60.0).contains(&direction), "{direction} N");
    assert!(balance["direction_share"].as_f64().unwrap() > 0.7);
    let html = std::fs::read_to_string(out.join("report.html")).unwrap();
    for expected in [
        "dry friction",
        "pressures taken as absolute",
        "<svg",
        "Excitation at 0.101 Hz",
        "P–F, extensor",
    ] {
        assert!(html.contains(expected), "the report lacks `{expected}`");
    }
    assert!(!html.contains("http://") || !html.contains("src="), "the report needs nothing else");
    let run: Value =
        serde_json::from_str(&std::fs::read_to_string(out.join("run.json")).unwrap()).unwrap();
    assert_eq!(run["configuration"]["solver"]["input"], "zoh");
    assert!(run["git"].is_string() && run["seed"].is_u64());
}

/// Another tolerance, another method, another way: the same prediction.
#[test]
fn solvers_agree_on_the_real_run() {
    let folder = tempfile::tempdir().unwrap();
    let (weights, data) = (published_weights(), published("data.mat"));
    let mut results = Vec::new();
    let variants: [&[&str]; 4] = [
        &["--rtol", "1e-9", "--atol", "1e-9"],
        &["--step-ms", "1"],
        &["--method", "rk4", "--step-ms", "0.5"],
        &["--method", "dp5"],
    ];
    for (i, extra) in variants.iter().enumerate() {
        let out = folder.path().join(i.to_string());
        let mut arguments =
            vec!["evaluate", "--model", text(&weights), "--data", text(&data), "--out", text(&out)];
        arguments.extend_from_slice(extra);
        let _ = stdout_of(PAM, &arguments);
        let csv = std::fs::read_to_string(out.join("predictions/data.csv")).unwrap();
        results.push(columns(&csv));
    }
    for other in &results[1..] {
        for (a, b) in results[0][1].iter().zip(&other[1]) {
            assert!((a - b).abs() < 1e-4, "{a} and {b} mm");
        }
    }
}
