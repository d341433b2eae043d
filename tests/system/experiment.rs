//! `pam certify` and diagnoses with certified settings, through the commands.

use crate::diagnose::read_json;
use pam_tests::{run, stdout_of, text};
use std::path::Path;

const PAM: &str = env!("CARGO_BIN_EXE_pam-under-test");
const PROTOCOL: &str = "name = \"short\"\nconditions = [[45, 45], [60, 35]]\n\
                        [[current]]\nkind = \"sine\"\namplitude_a = 0.6\nfrequency_hz = 1.0\nduration_s = 6.0\n";

/// Run by `cargo test --release --workspace --tests -- --ignored long::`.
mod long {
    use super::*;

    /// Certified settings carry the baseline recordings: a diagnosis reads them, quotes the trials, and says what is missing if the
    /// recordings are gone.
    #[test]
    #[ignore = "long"]
    fn certified_settings_carry_the_baseline() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let protocol = at("protocol.toml");
        std::fs::write(&protocol, PROTOCOL).unwrap();
        let record = |out: &Path, seed: &str| {
            let arguments = ["rig", "record", "--protocol", text(&protocol), "--seed", seed];
            let _ = stdout_of(PAM, &[&arguments[..], &["--out", text(out), "--quiet"]].concat());
        };
        let (baseline, data) = (at("baseline"), at("data"));
        record(&baseline, "31");
        record(&data, "32");
        let certificate = at("certificate");
        let arguments = [
            "certify",
            "--data",
            text(&baseline),
            "--effects",
            "viscous_damping",
            "--magnitudes",
            "3",
            "--repeats",
            "1",
            "--nulls",
            "2",
            "--out",
            text(&certificate),
            "--quiet",
        ];
        let _ = stdout_of(PAM, &arguments);
        let certified = certificate.join("certified.toml");
        let diagnose = |out: &Path| {
            let arguments = ["diagnose", "--data", text(&data), "--settings", text(&certified)];
            run(PAM, &[&arguments[..], &["--no-law", "--quiet", "--out", text(out)]].concat())
        };
        let found = at("found");
        let output = diagnose(&found);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let d = read_json(&found.join("diagnosis.json"));
        let sentence = d["certificate"]["sentence"].as_str().unwrap();
        assert!(sentence.contains("of 2 null sets"), "{sentence}");
        // Of the two recordings, one trains and the other tests the baseline.
        assert_eq!(d["baseline"]["recordings"].as_array().unwrap().len(), 1);
        std::fs::rename(&baseline, at("elsewhere")).unwrap();
        let output = diagnose(&at("again"));
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && message.contains("--healthy"), "{message}");
    }
}
