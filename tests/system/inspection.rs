//! `pam inspect`: the report of recordings.

use pam_tests::{published, run, stdout_of, text};
use serde_json::Value;

const PAM: &str = env!("CARGO_BIN_EXE_pam-under-test");

/// The report stands alone and shows every channel and every sentence.
#[test]
fn the_report_shows_every_channel_and_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("a/b");
    let file = published("data.mat");
    let said = stdout_of(PAM, &["inspect", text(&file), "--out", text(&out), "--json"]);
    let json: Value = serde_json::from_str(&said).unwrap();
    let html = std::fs::read_to_string(out.join("report.html")).unwrap();
    assert!(html.starts_with("<!DOCTYPE html>") && html.trim_end().ends_with("</html>"));
    // Nothing is fetched: no scripts, style sheets, images or fonts from elsewhere. The policy of the page forbids it, too.
    for outside in ["<script src", "<link", "<img", "@import", "url(http", "src=", "href=\"http"] {
        assert!(!html.contains(outside), "{outside}");
    }
    assert!(html.len() < 400_000, "{} bytes", html.len());
    // Five channels in time; time steps, velocity, force and both pressures against what they follow.
    assert_eq!(html.matches("class=\"figure\"").count(), 10);
    assert!(html.contains("Content-Security-Policy\" content=\"default-src 'none'"));
    for label in [
        "force (N)",
        "displacement x (mm)",
        "velocity v (mm/s)",
        "flexor pressure (kPa abs)",
        "extensor pressure (kPa abs)",
        "time step (ms)",
    ] {
        assert!(html.contains(label), "{label}");
    }
    let quality = &json[0]["recordings"][0]["quality"];
    let sentences = quality["can_be_told"].as_array().unwrap().iter();
    let findings = quality["findings"].as_array().unwrap().iter().map(|f| &f["message"]);
    let all: Vec<&str> = sentences.chain(findings).map(|s| s.as_str().unwrap()).collect();
    assert!(all.len() >= 4, "{quality}");
    for sentence in all {
        assert!(html.contains(sentence), "{sentence}");
    }
    for column in ["displacement_mm", "velocity_mm_s", "pressure_flexor_kpa", "force_n"] {
        assert!(html.contains(&format!("<td>{column}</td>")), "{column}");
    }
    // A folder that cannot be made is named.
    let blocked = folder.path().join("file");
    std::fs::write(&blocked, "").unwrap();
    let failed = run(PAM, &["inspect", text(&file), "--out", text(&blocked)]);
    assert!(!failed.status.success());
    assert!(String::from_utf8_lossy(&failed.stderr).contains("file"));
}
