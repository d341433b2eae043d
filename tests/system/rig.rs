//! The virtual rig through the program: what it writes, what it hides, what it refuses.

use pam_tests::{published_weights, run, stdout_of, text};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

const PAM: &str = env!("CARGO_BIN_EXE_pam-under-test");

/// A protocol of two recordings of four seconds.
const SHORT: &str = "name = \"short\"\nconditions = [[30, 60], [45, 45]]\n\n\
    [lead_in]\ninflate_s = 6.0\nrest_s = 0.5\n\n\
    [[current]]\nkind = \"sine\"\namplitude_a = 1.0\nfrequency_hz = 0.5\nduration_s = 4.0\n";

fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path());
    // A file that is still being written beside its place may be gone by the time it is read.
    entries
        .filter_map(|p| {
            let name = p.file_name().unwrap().to_string_lossy().into_owned();
            Some((name, std::fs::read(&p).ok()?))
        })
        .collect()
}

fn short_protocol(folder: &Path) -> String {
    let path = folder.join("short.toml");
    std::fs::write(&path, SHORT).unwrap();
    text(&path).to_owned()
}

fn record(protocol: &str, out: &Path, more: &[&str]) -> String {
    let mut arguments = vec!["rig", "record", "--protocol", protocol, "--out", text(out), "--json"];
    arguments.extend(more);
    stdout_of(PAM, &arguments)
}

#[test]
fn logs_name_no_effect_and_the_truth_names_all() {
    let folder = tempfile::tempdir().unwrap();
    let protocol = short_protocol(folder.path());
    let out = folder.path().join("logs");
    let report = folder.path().join("r.html");
    let hidden = ["--effect", "backlash:gap_mm=0.3", "--effect", "leak", "--report", text(&report)];
    let printed = record(&protocol, &out, &hidden);
    let all = files(&out);
    let names: Vec<&str> = all.keys().map(String::as_str).collect();
    assert_eq!(
        names,
        ["nn_3060", "nn_3060.truth.npz", "nn_4545", "nn_4545.truth.npz", "run.json", "truth.json"]
    );
    let says = |bytes: &[u8], word: &str| String::from_utf8_lossy(bytes).contains(word);
    for (name, bytes) in &all {
        assert_eq!(says(bytes, "backlash"), name == "truth.json", "{name}");
    }
    assert!(!says(&std::fs::read(&report).unwrap(), "backlash"));
    assert!(!says(printed.as_bytes(), "backlash"));
    let truth: Value = serde_json::from_slice(&all["truth.json"]).unwrap();
    assert_eq!(truth["rig"]["effect"][0]["gap_mm"], 0.3);
    let json: Value = serde_json::from_str(&printed).unwrap();
    assert_eq!(json["recordings"][0]["name"], "nn_3060");
    assert!(json["recordings"][0]["displacement_mm"][0].as_f64().unwrap() < -1.0);
}

#[test]
fn the_same_seed_gives_the_same_bytes_at_any_thread_count() {
    let folder = tempfile::tempdir().unwrap();
    let protocol = short_protocol(folder.path());
    let [a, b, c] = ["a", "b", "c"].map(|n| folder.path().join(n));
    record(&protocol, &a, &["--threads", "1"]);
    record(&protocol, &b, &["--threads", "2"]);
    record(&protocol, &c, &["--seed", "2"]);
    assert_eq!(files(&a), files(&b));
    assert_ne!(files(&a)["nn_3060"], files(&c)["nn_3060"]);
}

#[test]
fn a_folder_of_other_settings_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    let protocol = short_protocol(folder.path());
    let out = folder.path().join("logs");
    record(&protocol, &out, &[]);
    let before = files(&out);
    let other = ["rig", "record", "--protocol", &protocol, "--out", text(&out), "--seed", "9"];
    let output = run(PAM, &other);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1));
    assert!(message.contains("other settings") && message.contains("--overwrite"), "{message}");
    assert_eq!(files(&out), before);
    record(&protocol, &out, &["--seed", "9", "--overwrite", "--conditions", "30/60"]);
    let after = files(&out);
    assert_ne!(after["nn_3060"], before["nn_3060"]);
    assert!(!after.contains_key("nn_4545"), "a recording of other settings is left");
}

#[test]
fn the_truth_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let protocol = short_protocol(folder.path());
    let out = folder.path().join("logs");
    record(&protocol, &out, &["--conditions", "45/45"]);
    let truth = out.join("nn_4545.truth.npz");
    let scores = folder.path().join("scores");
    let arguments = ["evaluate", "--model", "spring-damper", "--data", text(&truth), "--out"];
    let output = run(PAM, &[&arguments[..], &[text(&scores)]].concat());
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && message.contains("sealed truth"), "{message}");
}

#[test]
fn what_is_wrong_is_said_with_file_and_line() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let file = folder.path().join("p.toml");
    let fails = |arguments: &[&str], code: i32, expected: &[&str]| {
        let base = ["rig", "record", "--out", text(&out)];
        let output = run(PAM, &[&base[..], arguments].concat());
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
        for part in expected {
            assert!(message.contains(part), "{arguments:?}: {message}");
        }
        assert!(!out.exists(), "{arguments:?} left something behind");
    };
    for (protocol, expected) in [
        (SHORT.replace("duration_s = 4.0", "duration_s = -4"), "p.toml:8: current[0].duration_s"),
        (SHORT.replace("amplitude_a = 1.0", "amplitude_a = 12"), "amplitude_a: 12 A is outside"),
        (SHORT.replace("\"sine\"", "\"sin\""), "unknown variant `sin`"),
        (SHORT.replace("[45, 45]", "[45, 450]"), "p.toml:2"),
        (SHORT.replace("inflate_s", "inflation_s"), "p.toml:5: unknown field `inflation_s`"),
        (SHORT.replace("conditions", "#conditions"), "neither conditions nor"),
        ("name =".into(), "p.toml:1"),
        (String::new(), "missing field `name`"),
    ] {
        std::fs::write(&file, protocol).unwrap();
        fails(&["--protocol", text(&file)], 1, &[expected]);
    }
    fails(&["--protocol", "nowhere.toml"], 1, &["nowhere.toml", "No such file"]);
    fails(&["--protocol", "papers"], 2, &["papers", "paper, validation, pulses, tracking"]);
    fails(&["--conditions", "30-60"], 2, &["--conditions", "30/60,45/45"]);
    fails(&["--conditions", "45/45", "--protocol", "tracking"], 2, &["drives the pressures"]);
    fails(&["--effect", "coulomb"], 2, &["no effect `coulomb`", "coulomb_friction"]);
    fails(&["--effect", "backlash:gap=1"], 2, &["no parameter `gap`", "gap_mm"]);
    fails(&["--effect", "added_inertia:mass_kg=-150"].repeat(3), 1, &["plant.mass_kg", "positive"]);
    fails(&["--ideal", "encoders"], 2, &["encoders", "encoder", "pressure-lag"]);
    std::fs::write(&file, "[plant]\nmass_kg = 0.0\n").unwrap();
    fails(&["--rig", text(&file)], 1, &["plant.mass_kg", "positive"]);
    std::fs::write(&file, "[plant]\nmass = 3\n").unwrap();
    fails(&["--rig", text(&file)], 1, &["p.toml:2: unknown field `mass`"]);
}

#[test]
fn what_it_can_do_is_listed() {
    let effects: Value =
        serde_json::from_str(&stdout_of(PAM, &["rig", "list-effects", "--json"])).unwrap();
    let effects = effects.as_array().unwrap();
    assert!(effects.iter().any(|e| e["id"] == "stribeck_friction" && e["listed"] == true));
    assert!(effects.iter().filter(|e| e["listed"] == false).count() >= 4);
    let printed = stdout_of(PAM, &["rig", "list-effects"]);
    assert!(printed.contains("time_constant_s"));
    // Phenomena outside the vocabulary can be hidden, and no diagnosis offers their names.
    let (_, outside) = printed.split_once("not in the vocabulary").unwrap();
    let record_help = stdout_of(PAM, &["rig", "record", "--help"]);
    let diagnose_help = stdout_of(PAM, &["diagnose", "--help"]);
    for effect in effects {
        let (id, listed) = (effect["id"].as_str().unwrap(), effect["listed"] == true);
        assert!(record_help.contains(id) && printed.contains(id), "{id}");
        assert!(diagnose_help.contains(id) == listed && outside.contains(id) != listed, "{id}");
    }
    // What is printed can be read back.
    let folder = tempfile::tempdir().unwrap();
    let [protocol, rig] = ["p.toml", "r.toml"].map(|n| folder.path().join(n));
    let text_of = |arguments: &[&str]| stdout_of(PAM, arguments);
    let printed =
        text_of(&["rig", "protocol", "paper"]).replace("duration_s = 20.0", "duration_s = 1.0");
    std::fs::write(&protocol, printed).unwrap();
    std::fs::write(&rig, text_of(&["rig", "parameters"])).unwrap();
    let out = folder.path().join("out");
    record(
        text(&protocol),
        &out,
        &["--rig", text(&rig), "--conditions", "20/20", "--ideal", "all"],
    );
    assert!(out.join("nn_2020").exists());
    assert!(text_of(&["rig", "protocol"]).contains("tracking"));
    assert!(text_of(&["rig", "observables"]).contains("stiffness"));
}

/// Run by `cargo test --release --workspace --tests -- --ignored long::`.
mod long {
    use super::*;

    /// Kills a session in the middle, several times if need be, and lets another finish it.
    #[test]
    #[ignore = "long"]
    fn a_killed_session_leaves_whole_logs_and_is_finished_by_another() {
        let folder = tempfile::tempdir().unwrap();
        let [whole, cut] = ["whole", "cut"].map(|n| folder.path().join(n));
        // Long enough to be killed in the middle.
        let protocol = folder.path().join("protocol.toml");
        let sine = "[[current]]\nkind = \"sine\"\namplitude_a = 1.5\nfrequency_hz = 1.0\nduration_s = 20.0\n";
        std::fs::write(&protocol, format!("name = \"killed\"\nconditions = [[45, 45]]\n{sine}"))
            .unwrap();
        let arguments = |out: &Path| {
            let more = ["--protocol", text(&protocol), "--out", text(out)];
            let all =
                [&["rig", "record", "--conditions", "symmetric", "--quiet"][..], &more].concat();
            all.into_iter().map(str::to_owned).collect::<Vec<_>>()
        };
        assert!(Command::new(PAM).args(arguments(&whole)).status().unwrap().success());
        let expected = files(&whole);
        let logs = || {
            let there = if cut.exists() { files(&cut) } else { BTreeMap::new() };
            there.into_iter().filter(|(n, _)| n.starts_with("nn_")).collect::<BTreeMap<_, _>>()
        };
        let mut child =
            Command::new(PAM).args(arguments(&cut)).stderr(Stdio::null()).spawn().unwrap();
        let begun = Instant::now();
        while logs().len() < 5 && begun.elapsed() < Duration::from_secs(60) {
            std::thread::sleep(Duration::from_millis(20));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        let left = logs();
        assert!(left.len() >= 5 && left.len() < 30, "{} files", left.len());
        for (name, bytes) in &left {
            assert!(bytes == &expected[name], "{name} is not whole");
        }
        assert!(Command::new(PAM).args(arguments(&cut)).status().unwrap().success());
        let there = files(&cut);
        assert!(there.keys().eq(expected.keys()), "{:?}", there.keys());
        assert!(there.iter().all(|(name, bytes)| bytes == &expected[name]));
    }

    #[test]
    #[ignore = "long"]
    fn the_published_weights_predict_the_rig() {
        let folder = tempfile::tempdir().unwrap();
        let [logs, out] = ["logs", "out"].map(|n| folder.path().join(n));
        let conditions = ["--conditions", "30/60,45/45,80/80,10/10"];
        record("paper", &logs, &conditions);
        let weights = published_weights();
        let arguments = ["--data", text(&logs), "--out", text(&out), "--json"];
        let printed =
            stdout_of(PAM, &[&["evaluate", "--model", text(&weights)], &arguments[..]].concat());
        let json: Value = serde_json::from_str(&printed).unwrap();
        let recordings = json["recordings"].as_array().unwrap();
        assert_eq!(recordings.len(), 4);
        for r in recordings {
            let r2 = r["r2"]["x"].as_f64().unwrap();
            assert!(r2 > 0.85, "{}: {r2}", r["name"]);
        }
    }
}
