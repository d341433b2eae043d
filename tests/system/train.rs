//! Training through the program: it learns, repeats to the bit, survives being killed, and says what is
//! wrong.

use pam_tests::{ended_within, run, stdout_of, text};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::LazyLock;
use std::time::Instant;

const PAM: &str = env!("CARGO_BIN_EXE_pam-under-test");

/// Five recordings of the rig, shortened, without sensor errors; four to train on, one held out.
static DATA: LazyLock<(tempfile::TempDir, PathBuf)> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let protocol = folder.path().join("p.toml");
    let sine = |f: f64, s: f64| {
        format!(
            "[[current]]\nkind = \"sine\"\namplitude_a = 1.5\nfrequency_hz = {f}\nduration_s = {s}\n"
        )
    };
    let conditions = "[[30, 60], [60, 30], [45, 45], [80, 80], [55, 40]]";
    let text_of =
        format!("name = \"t\"\nconditions = {conditions}\n{}{}", sine(0.5, 4.0), sine(2.0, 2.0));
    std::fs::write(&protocol, text_of).unwrap();
    let out = folder.path().join("logs");
    let arguments =
        ["rig", "record", "--ideal", "all", "--no-truth", "--quiet", "--protocol", text(&protocol)];
    let status = Command::new(PAM).args(arguments).arg("--out").arg(&out).status().unwrap();
    assert!(status.success());
    (folder, out)
});

/// The published excitation with 0.4 of its times: 28 s.
fn short_protocol(folder: &Path) -> PathBuf {
    let segments: String = [(0.5, 8.0), (1.0, 4.0), (2.0, 2.0)]
        .iter()
        .flat_map(|(f, s)| {
            [1.0, 1.5].map(|a| {
                format!(
                    "[[current]]\nkind = \"sine\"\namplitude_a = {a}\nfrequency_hz = {f}\nduration_s = {s}\n"
                )
            })
        })
        .collect();
    let path = folder.join("published.toml");
    std::fs::write(&path, format!("name = \"short\"\nconditions = [[45, 45]]\n{segments}"))
        .unwrap();
    path
}

/// Fewer steps of the stage that matches derivatives, all of them and those that fit the mass.
fn steps(all: usize, mass: usize) -> [String; 4] {
    let set = |name: &str, value: usize| format!("stage.1.matching.{name}={value}");
    ["--set".into(), set("steps", all), "--set".into(), set("mass_steps", mass)]
}

/// A short curriculum over them.
const SHORT: &str = "name = \"short\"\nrate = 1e-4\n[model]\nhidden = [32, 32]\n\
    [[stage]]\nkind = \"gas\"\nname = \"gas\"\n\
    [[stage]]\nkind = \"derivatives\"\nname = \"derivatives\"\nmatching = { steps = 600, batch = 256 }\n\
    [[stage]]\nkind = \"solve\"\nname = \"windows\"\nhorizon_s = 1.0\nbatch = 8\nepochs = 6\n\
    [[stage]]\nkind = \"solve\"\nname = \"shooting\"\nhorizon_s = 1.0\nshooting = {}\nepochs = 6\n\
    [[stage]]\nkind = \"solve\"\nname = \"whole\"\nepochs = 12\n";

/// Held-out scores appear in the epochs that `score_every` says, and nothing else changes.
#[test]
fn scores_while_training_change_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let short = curriculum(folder.path());
    let [plain, scored] = ["plain", "scored"].map(|n| folder.path().join(n));
    trained(&short, &plain, &[]);
    let json = trained(&short, &scored, &["--set", "score_every=4"]);
    assert!(model(&plain) == model(&scored));
    let metrics = std::fs::read_to_string(scored.join("metrics.csv")).unwrap();
    let mut lines = metrics.lines().map(|l| l.split(',').collect::<Vec<_>>());
    let header = lines.next().unwrap();
    let column = |name: &str| header.iter().position(|h| *h == name).unwrap();
    let (stage, epoch, x) = (column("stage"), column("epoch"), column("held_out_r2_x"));
    let whole: Vec<(usize, f64)> = lines
        .filter(|l| l[stage] == "4" && !l[x].is_empty())
        .map(|l| (l[epoch].parse().unwrap(), l[x].parse().unwrap()))
        .collect();
    assert_eq!(whole.iter().map(|s| s.0).collect::<Vec<_>>(), [4, 8, 12]);
    // The stage ends with its best epoch's parameters, which scores around it come close to.
    let last = json["stages"][4]["r2_held_out"][0].as_f64().unwrap();
    assert!(whole.iter().any(|s| (s.1 - last).abs() < 0.05), "{whole:?}, {last}");
}

fn curriculum(folder: &Path) -> String {
    let path = folder.join("short.toml");
    std::fs::write(&path, SHORT).unwrap();
    text(&path).to_owned()
}

fn train(curriculum: &str, out: &Path, more: &[&str]) -> std::process::Output {
    let base = ["train", curriculum, "--data", text(&DATA.1), "--out", text(out), "--json"];
    run(PAM, &[&base[..], more].concat())
}

fn trained(curriculum: &str, out: &Path, more: &[&str]) -> Value {
    let output = train(curriculum, out, more);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{errors}");
    serde_json::from_slice(&output.stdout).unwrap()
}

fn model(out: &Path) -> Vec<u8> {
    std::fs::read(out.join("model.safetensors")).unwrap()
}

/// The deformation coefficient with which an isothermal cylinder of the datasheet's size shows the
/// rig's relative change of volume at x = 0, from the rig's parameters as they are printed: strands of
/// length b in n turns enclose `(b² − L²) L/(4 π n²)` (Chou and Hannaford 1996), to which bore and dead
/// volume add, and the cylinder has `d ln V/dx = (2 ν − 1)/L₀`.
fn equivalent_deformation(rig: &toml::Table) -> f64 {
    let braid = rig["plant"]["flexor"]["braid"].as_table().unwrap();
    let of = |name: &str| braid[name].as_float().unwrap();
    let (length, angle) = (of("length_mm"), of("angle_deg").to_radians());
    // One turn of the braid is a right triangle: b = L/cos α, n π D = b sin α; then dV/dL at L₀ is that
    // of the braid, and the chamber at L₀ is bore and dead volume.
    let area = std::f64::consts::PI * (of("diameter_mm") / 2.0).powi(2);
    let slope = area * (3.0 - angle.cos().powi(-2)) / angle.tan().powi(2);
    let volume =
        std::f64::consts::PI * (of("bore_mm") / 2.0).powi(2) * length + of("dead_volume_mm3");
    0.5 * (1.0 + length * slope / volume)
}

#[test]
fn the_seed_decides_and_the_threads_do_not() {
    let folder = tempfile::tempdir().unwrap();
    let short = curriculum(folder.path());
    let [a, b, c] = ["a", "b", "c"].map(|n| folder.path().join(n));
    trained(&short, &a, &["--threads", "1"]);
    trained(&short, &b, &["--threads", "2"]);
    trained(&short, &c, &["--seed", "2"]);
    for stage in 1..=5 {
        let file = format!("stages/{stage:02}.safetensors");
        let read = |out: &Path| std::fs::read(out.join(&file)).unwrap();
        assert!(read(&a) == read(&b), "{file}");
    }
    assert!(model(&a) == model(&b));
    assert!(model(&a) != model(&c));
}

/// Kills a run at several moments, as `kill -9` does, and resumes it every time.
#[test]
fn a_run_that_is_killed_and_resumed_ends_with_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let short = curriculum(folder.path());
    let [whole, cut] = ["whole", "cut"].map(|n| folder.path().join(n));
    let begun = Instant::now();
    trained(&short, &whole, &["--checkpoint-s", "0"]);
    let time = begun.elapsed();
    let mut kills = 0;
    for part in 1..=40 {
        let mut command = Command::new(PAM);
        command.args(["train", &short, "--data", text(&DATA.1), "--out", text(&cut)]);
        command.args(["--checkpoint-s", "0", "--quiet"]);
        if cut.join("checkpoint.json").exists() {
            command.arg("--resume");
        } else if cut.exists() {
            std::fs::remove_dir_all(&cut).unwrap();
        }
        let mut child = command.stderr(Stdio::null()).spawn().unwrap();
        // Ever later, so that the run comes to its end.
        let patience = time.mul_f64(0.08 + 0.04 * f64::from(part));
        let ended = ended_within(&mut child, patience);
        if let Some(status) = ended {
            assert!(status.success());
            break;
        }
        child.kill().unwrap();
        child.wait().unwrap();
        kills += 1;
    }
    assert!(kills > 0, "nothing was killed");
    assert!(model(&whole) == model(&cut), "after {kills} kills");
    let rows = |out: &Path| {
        let metrics = std::fs::read_to_string(out.join("metrics.csv")).unwrap();
        // All but the time of the epoch.
        metrics.lines().map(|l| l.rsplit_once(',').unwrap().0.to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(rows(&whole), rows(&cut));
}

#[test]
fn a_rate_that_is_too_high_is_rolled_back_and_told() {
    let folder = tempfile::tempdir().unwrap();
    let short = curriculum(folder.path());
    let out = folder.path().join("run");
    let json = trained(&short, &out, &["--set", "stage.4.rate=0.3", "--set", "stage.4.epochs=30"]);
    let events = json["events"].as_array().unwrap();
    let told = events.iter().any(|e| {
        let e = e.as_str().unwrap();
        e.contains("stage `whole`") && e.contains("nn_") && e.contains("rolled back")
    });
    assert!(told, "{events:?}");
    let last = json["stages"].as_array().unwrap().last().unwrap();
    assert!(last["r2_train"][0].as_f64().unwrap() > 0.9, "{last}");
}

#[test]
fn what_is_wrong_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let fails = |curriculum: &str, more: &[&str], expected: &str| {
        let output = train(curriculum, &out, more);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success(), "{curriculum} {more:?}");
        assert!(message.contains(expected), "{curriculum} {more:?}: {message}");
    };
    fails("recomended", &[], "recommended, paper, horizons, shooting, joint");
    fails("recommended", &["--set", "rates=1"], "unknown field `rates`");
    fails("recommended", &["--set", "data.train=[\"9999\"]"], "no recording is called `9999`");
    fails("recommended", &["--resume"], "no run was begun");
    let file = folder.path().join("c.toml");
    std::fs::write(&file, "name = \"a\"\n\n[[stage]]\nkind = \"solved\"\n").unwrap();
    fails(text(&file), &[], "c.toml:4: unknown variant `solved`");
    let short = curriculum(folder.path());
    trained(&short, &out, &[]);
    fails(&short, &[], "holds a run");
    fails(&short, &["--resume", "--seed", "7"], "begun with --seed 1");
}

/// Effects are listed in a curriculum or stand in the model that is started from; they are trained along, saved,
/// and read by other commands.
#[test]
fn effects_are_trained_along_and_saved() {
    let folder = tempfile::tempdir().unwrap();
    let [first, second] = ["first", "second"].map(|n| folder.path().join(n));
    let start = Path::new(env!("CARGO_MANIFEST_DIR")).join("../pam-cli/models/default.safetensors");
    let short = ["--set", "stage.0.epochs=4", "--start"];
    let listed =
        "model.effects=[{ effect = \"viscous_damping\", values = { coefficient_ns_m = 0.0 } }]";
    let with = |effects: &'static str| [&short[..], &[text(&start), "--set", effects]].concat();
    let json = trained("joint", &first, &with(listed));
    let value = |json: &Value| {
        assert_eq!(json["effects"][0]["effect"], "viscous_damping");
        json["effects"][0]["values"]["coefficient_ns_m"].as_f64().unwrap()
    };
    let damping = value(&json);
    assert!(damping != 0.0);
    let saved = first.join("model.safetensors");
    assert!(stdout_of(PAM, &["inspect", text(&saved)]).contains("viscous_damping"));
    let metrics = std::fs::read_to_string(first.join("metrics.csv")).unwrap();
    assert!(metrics.lines().next().unwrap().ends_with(",viscous_damping.coefficient_ns_m"));
    let report = std::fs::read_to_string(first.join("report.html")).unwrap();
    assert!(report.contains("viscous_damping.coefficient_ns_m"));
    // On from that model: its effect comes along.
    let frozen = ["--set", "coordinates.frozen.effects=true"];
    let more = [&short[..], &[text(&saved)], &frozen[..]].concat();
    assert!((value(&trained("joint", &second, &more)) / damping - 1.0).abs() < 1e-12);
    let fails = |effects: &'static str, expected: &str| {
        let output = train("joint", &folder.path().join("none"), &with(effects));
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(!output.status.success() && message.contains(expected), "{effects}: {message}");
    };
    fails("model.effects=[{ effect = \"rust\", values = {} }]", "there is no effect `rust`");
    fails(
        "model.effects=[{ effect = \"coulomb_friction\", values = {} }]",
        "`coulomb_friction`: `force_n` is missing",
    );
    fails(
        "model.effects=[{ effect = \"coulomb_friction\", values = { force_n = -3.0 } }]",
        "`force_n` is -3; it may be 0 to 1000",
    );
}

#[test]
fn every_curriculum_can_be_printed_and_read_back() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["recommended", "paper", "horizons", "shooting", "joint"] {
        let printed = stdout_of(PAM, &["train", name, "--print"]);
        let file = folder.path().join(format!("{name}.toml"));
        std::fs::write(&file, &printed).unwrap();
        assert_eq!(stdout_of(PAM, &["train", text(&file), "--print"]), printed);
    }
    assert_eq!(stdout_of(PAM, &["train", "paper", "--print"]).matches("[[stage]]").count(), 16);
}

/// Run by `cargo test --release --workspace --tests -- --ignored long::`.
mod long {
    use super::*;

    #[test]
    #[ignore = "long"]
    fn random_weights_become_a_model_that_predicts_what_it_has_not_seen() {
        let folder = tempfile::tempdir().unwrap();
        let [logs, out] = ["logs", "run"].map(|n| folder.path().join(n));
        let conditions = "10/10,45/45,80/80,30/60,60/30,70/20,20/70,50/50,55/40";
        let recorded =
            ["rig", "record", "--ideal", "all", "--no-truth", "--conditions", conditions];
        let protocol = short_protocol(folder.path());
        let more = ["--protocol", text(&protocol), "--out", text(&logs)];
        let _ = stdout_of(PAM, &[&recorded[..], &more].concat());
        let arguments = ["train", "--data", text(&logs), "--out", text(&out), "--json"];
        let steps = steps(3000, 2500);
        let fewer = steps.each_ref().map(String::as_str);
        let shorter = [&["--set", "stage.2.epochs=12"], &fewer[..]].concat();
        let printed = stdout_of(PAM, &[&arguments[..], &shorter].concat());
        let json: Value = serde_json::from_str(&printed).unwrap();
        assert_eq!(json["trained_on"].as_array().unwrap().len(), 8);
        let last = json["stages"].as_array().unwrap().last().unwrap();
        for (key, least) in [("r2_train", 0.98), ("r2_held_out", 0.95)] {
            let x = last[key][0].as_f64().unwrap();
            assert!(x > least, "{key}: {x}");
        }
        // The rig's own inertia is 315 kg.
        let mass = json["parameters"]["mass_kg"].as_f64().unwrap();
        assert!((mass / 315.0 - 1.0).abs() < 0.03, "{mass} kg");
        for file in
            ["curriculum.toml", "run.json", "metrics.csv", "training.json", "stages/03.safetensors"]
        {
            assert!(out.join(file).exists(), "{file}");
        }
        // The model is one that every other command takes.
        let printed = stdout_of(PAM, &["inspect", text(&out.join("model.safetensors")), "--json"]);
        assert!(printed.contains("recommended"));
    }

    /// A rig whose air stays at room temperature and that has no dry friction is what the model's equations
    /// say: m and ν come out, and their standard errors say how well. With the rig's own heat exchange ν does
    /// not mean anything, and that is said.
    #[test]
    #[ignore = "long"]
    fn parameters_come_out_with_errors_where_the_data_identify_them() {
        let folder = tempfile::tempdir().unwrap();
        let printed = stdout_of(PAM, &["rig", "parameters"]);
        let mut rig: toml::Table = printed.parse().unwrap();
        let truth = (rig["plant"]["mass_kg"].as_float().unwrap(), equivalent_deformation(&rig));
        assert!((truth.1 - 3.42).abs() < 0.01, "docs/rig.md: {}", truth.1);
        let protocol = short_protocol(folder.path());
        let record = |rig: &toml::Table, name: &str| {
            let [file, out] = ["toml", "logs"].map(|e| folder.path().join(format!("{name}.{e}")));
            std::fs::write(&file, rig.to_string()).unwrap();
            let conditions = "10/10,45/45,80/80,30/60,60/30,40/50,50/40,20/20,60/60";
            let arguments =
                ["rig", "record", "--ideal", "all", "--no-truth", "--conditions", conditions];
            let _ = stdout_of(
                PAM,
                &[
                    &arguments[..],
                    &["--rig", text(&file), "--protocol", text(&protocol), "--out", text(&out)],
                ]
                .concat(),
            );
            out
        };
        let learn = |data: &Path, name: &str, epochs: usize, steps: [String; 4]| -> Value {
            let out = folder.path().join(name);
            let arguments = ["train", "--data", text(data), "--out", text(&out), "--json"];
            let epochs = format!("stage.2.epochs={epochs}");
            let fewer = ["--set", &epochs, "--set", "data.held_out=none"];
            let steps = steps.each_ref().map(String::as_str);
            let printed = stdout_of(PAM, &[&arguments[..], &fewer, &steps].concat());
            assert!(
                std::fs::read_to_string(out.join("report.html"))
                    .unwrap()
                    .contains("standard error")
            );
            serde_json::from_str(&printed).unwrap()
        };
        let conduction = record(&rig, "conduction");

        let plant = rig["plant"].as_table_mut().unwrap();
        plant.insert("heat".into(), "isothermal".into());
        for name in ["coulomb_n", "static_n"] {
            plant["friction"].as_table_mut().unwrap().insert(name.into(), 0.0.into());
        }
        for muscle in ["flexor", "extensor"] {
            let losses = plant[muscle]["losses"].as_table_mut().unwrap();
            for name in ["dry_n", "dry_n_per_kpa"] {
                losses.insert(name.into(), 0.0.into());
            }
        }
        let json = learn(&record(&rig, "isothermal"), "run", 6, steps(1500, 1000));
        let found = |pointer: &str| json.pointer(pointer).and_then(Value::as_f64).unwrap();
        let mass = (found("/parameters/mass_kg"), found("/identification/mass/standard_error_kg"));
        let nu =
            (found("/parameters/deformation"), found("/identification/deformation/standard_error"));
        for (what, (value, error), truth) in [("m", mass, truth.0), ("nu", nu, truth.1)] {
            let off = (value - truth).abs();
            assert!(off < 0.03 * truth, "{what}: {value} ± {error}, not {truth}");
            assert!(off < 4.0 * error, "{what}: {value} ± {error}, not {truth}");
            assert!(error < 0.02 * truth, "{what}: {value} ± {error}");
        }
        assert_eq!(json["identification"]["deformation_doubt"], Value::Null);

        // The first stage alone says so.
        let json = learn(&conduction, "warm", 1, steps(300, 200));
        let doubt = json["identification"]["deformation_doubt"].as_str().unwrap();
        assert!(doubt.starts_with("not identified") && doubt.contains("at 0.500 Hz"), "{doubt}");
        // Faster air is less isothermal, which an isothermal model takes for a larger ν.
        let by = json["identification"]["deformation"]["by_frequency"].as_array().unwrap();
        let nus: Vec<f64> = by.iter().map(|f| f["deformation"].as_f64().unwrap()).collect();
        assert!(nus.len() == 3 && nus.is_sorted() && nus[0] > truth.1, "{nus:?}");
    }
}
