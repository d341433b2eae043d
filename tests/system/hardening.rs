//! Hostile inputs and surroundings: nothing is lost or replaced without a word, nothing panics, aborts or runs for ever.

use pam_data::load_model;
use pam_data::models::save_model;
use pam_data::output_folder::{LOCK_FILE, OutputFolder, Sharing};
use pam_tests::{ended_within, published, published_weights, small_csv, text};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

const PAM: &str = env!("CARGO_BIN_EXE_pam-under-test");

/// Longest time that a refusal or an answer takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(10);

/// The end of a run, which must come soon.
fn ended(arguments: &[&str]) -> Output {
    let mut child = Command::new(PAM)
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    if ended_within(&mut child, PATIENCE).is_none() {
        child.kill().unwrap();
        panic!("{arguments:?} does not end");
    }
    child.wait_with_output().unwrap()
}

/// The message of a run that must end with this code and without a panic.
#[track_caller]
fn message(arguments: &[&str], code: i32) -> String {
    let output = ended(arguments);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {message}");
    assert!(!message.contains("panicked"), "{message}");
    message
}

#[track_caller]
fn refused(arguments: &[&str], parts: &[&str]) {
    let message = message(arguments, 1);
    for part in parts {
        assert!(message.contains(part), "`{part}` is missing in: {message}");
    }
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn file(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        std::fs::write(self.at(name), content).unwrap();
        self.at(name)
    }
}

/// A curriculum of some tenths of a second.
const CURRICULUM: &str = "name = \"short\"\n[model]\nhidden = [8]\n[[stage]]\nkind = \"gas\"\nname = \"gas\"\n\
    [[stage]]\nkind = \"derivatives\"\nname = \"derivatives\"\nmatching = { steps = 30, mass_steps = 30, batch = 64 }\n";

#[test]
fn two_programs_do_not_write_to_one_folder() {
    let f = Folder::new();
    let (out, data) = (f.at("out"), f.file("run.csv", small_csv(300)));
    let evaluate = &["evaluate", "--accept", "-q", "--data", text(&data), "--out", text(&out)][..];
    let held = OutputFolder::claim(&out, "evaluate", Sharing::Exclusive).unwrap();
    refused(evaluate, &["out", "another program"]);
    assert_eq!(std::fs::read_dir(&out).unwrap().count(), 1, "the lock alone");
    drop(held);
    // Temporary files of a killed program are removed, even from the deepest output folder.
    let (predictions, stages) = (out.join("predictions"), out.join("cells/5f/work/stages"));
    [&predictions, &stages].iter().for_each(|at| std::fs::create_dir_all(at).unwrap());
    let left = [
        out.join(".pam-1234"),
        predictions.join(".pam-5"),
        stages.join(".pam-6"),
        out.join(LOCK_FILE),
    ];
    left.iter().for_each(|path| std::fs::write(path, "half").unwrap());
    let _ = message(evaluate, 0);
    assert!(left.iter().all(|path| !path.exists()));
    assert!(out.join("evaluation.json").exists());
}

#[test]
fn results_of_another_command_are_not_replaced() {
    let f = Folder::new();
    let data = f.file("run.csv", small_csv(3000));
    let curriculum = f.file("short.toml", CURRICULUM);
    let (out, other) = (f.at("trained"), f.at("other"));
    let train = ["train", text(&curriculum), "--accept", "-q", "--data", text(&data), "--out"];
    let _ = message(&[&train[..], &[text(&out)]].concat(), 0);
    let before = std::fs::read(out.join("run.json")).unwrap();
    for command in [
        ["evaluate", "--accept", "--data", text(&data)].as_slice(),
        &["rig", "record", "--conditions", "45/45"],
        &["stiffness"],
        &["inspect", text(&data)],
    ] {
        refused(&[command, &["--out", text(&out)]].concat(), &["trained", "pam train"]);
    }
    assert_eq!(std::fs::read(out.join("run.json")).unwrap(), before);
    assert!(!out.join(LOCK_FILE).exists());

    // A sweep begins in an empty folder.
    std::fs::create_dir(&other).unwrap();
    std::fs::write(other.join("thesis.txt"), "years").unwrap();
    let sweep = format!(
        "name = \"t\"\n[experiment]\nrecordings = [{:?}]\n[[axis]]\nkey = \"model.activation\"\nvalues = [\"silu\"]\n",
        text(&data)
    );
    let sweep = f.file("sweep.toml", sweep);
    refused(&["ablate", text(&sweep), "--out", text(&other)], &["thesis.txt", "no sweep"]);

    // A checkpoint that was edited is none; one whose arrays were cut neither.
    let path = out.join("checkpoint.json");
    let sound = std::fs::read_to_string(&path).unwrap();
    let resume = [&train[..], &[text(&out), "--resume"]].concat();
    let mut edited: serde_json::Value = serde_json::from_str(&sound).unwrap();
    edited["state"]["scaling"]["centre"][0] = 1e18.into();
    std::fs::write(&path, edited.to_string()).unwrap();
    refused(&resume, &["checkpoint.json", "checksum"]);
    edited["state"]["at"].as_array_mut().unwrap().truncate(5);
    std::fs::write(&path, edited.to_string()).unwrap();
    refused(&resume, &["checkpoint.json", "checksum"]);
    // Recordings that differ by the sign of the force are others, and so is another curriculum.
    std::fs::write(&path, &sound).unwrap();
    let turned = small_csv(3000).lines().map(negated_force).collect::<Vec<_>>().join("\n");
    std::fs::write(&data, turned).unwrap();
    refused(&resume, &["other recordings"]);
    std::fs::write(&data, small_csv(3000)).unwrap();
    let own = out.join("curriculum.toml");
    let longer = std::fs::read_to_string(&own).unwrap().replace("steps = 30", "steps = 31");
    std::fs::write(&own, longer).unwrap();
    refused(&resume, &["another curriculum"]);
}

fn negated_force(line: &str) -> String {
    match line.rsplit_once(',') {
        Some((rest, force)) if force.parse::<f64>().is_ok() => {
            format!("{rest},{}", -force.parse::<f64>().unwrap())
        }
        _ => line.to_owned(),
    }
}

#[test]
fn output_that_cannot_be_written_is_noticed_before_anything_is_computed() {
    let f = Folder::new();
    let blocker = f.file("file", "x");
    let out = blocker.join("out");
    // The model does not exist: it would be the next error.
    for command in [&["stiffness"][..], &["plan", "--motion", "hold:x=0"], &["replan"]] {
        let more = ["--model", "/nowhere.eqx", "--out", text(&out)];
        refused(&[command, &more].concat(), &["file/out"]);
    }
    for (command, name) in [("evaluate", "o"), ("diagnose", "o"), ("gradient", "o.npz")] {
        let out = blocker.join(name);
        refused(
            &[command, "--model", "/nowhere.eqx", "--data", "/none.csv", "--out", text(&out)],
            &["file/o"],
        );
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_lost_standard_output_is_an_error() {
    for arguments in [&["parts", "--json"][..], &["doctor"], &["--help"]] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let output = Command::new(PAM).args(arguments).stdout(full).output().unwrap();
        assert_eq!(output.status.code(), Some(1), "{arguments:?}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn readers_know_a_largest_size_and_take_regular_files_only() {
    let f = Folder::new();
    for name in ["large.csv", "large.mat", "large.npz", "nn_3060"] {
        let file = std::fs::File::create(f.at(name)).unwrap();
        // Sparse: it takes no room.
        file.set_len(3 << 30).unwrap();
        refused(&["inspect", text(&f.at(name))], &[name, "too large", "--max-read-mib"]);
    }
    let pipe = f.at("pipe.csv");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    refused(&["inspect", text(&pipe)], &["pipe.csv", "not a regular file"]);
    refused(&["inspect", "/dev/zero"], &["/dev/zero", "not a regular file"]);
    refused(
        &["evaluate", "--model", text(&pipe), "--data", "x.csv", "--out", text(&f.at("o"))],
        &["pipe.csv"],
    );
    // An archive that unpacks to more than is read.
    let run = f.file("run.csv", small_csv(60_000));
    let (packed, plain) = (f.at("packed.npz"), f.at("run.npz"));
    let _ = message(&["convert", text(&run), text(&plain), "-q"], 0);
    pack(&plain, &packed);
    refused(&["inspect", text(&packed), "--max-read-mib", "2"], &["packed.npz", "too large"]);
    assert!(std::fs::metadata(&packed).unwrap().len() < 2 << 20);
}

/// The archive, compressed, with a constant array besides.
fn pack(from: &Path, to: &Path) {
    use std::io::Write;
    let mut from = zip::ZipArchive::new(std::fs::File::open(from).unwrap()).unwrap();
    let mut to = zip::ZipWriter::new(std::fs::File::create(to).unwrap());
    let options = zip::write::SimpleFileOptions::default()
        .compression_method(zip::CompressionMethod::Deflated);
    let mut file = from.by_name("time_s.npy").unwrap();
    let mut content = Vec::new();
    std::io::copy(&mut file, &mut content).unwrap();
    content.truncate(128);
    content.resize(128 + 8 * 60_000, 0);
    for name in ["a", "b", "c", "d", "e"] {
        to.start_file(format!("{name}.npy"), options).unwrap();
        to.write_all(&content).unwrap();
    }
    to.finish().unwrap();
}

#[test]
fn impossible_settings_and_names_are_refused() {
    let f = Folder::new();
    let data = f.file("run.csv", small_csv(3000));
    let curriculum = f.file("short.toml", CURRICULUM);
    let out = f.at("out");
    let train = |more: &[&str]| {
        let first = ["train", text(&curriculum), "--accept", "--data", text(&data), "--out"];
        let all = [&first[..], &[text(&out)], more].concat();
        let output = ended(&all);
        assert!(matches!(output.status.code(), Some(1 | 2)), "{more:?}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    for (set, part) in [
        ("stage.1.matching.spacing_s=nan", "spacing_s"),
        ("stage.1.matching.cutoff_hz=nan", "cutoff_hz"),
        ("stage.1.matching.batch=0", "batch"),
        ("stage.1.matching.rate=inf", "rate"),
        ("model.hidden=[9223372036854775807]", "model.hidden"),
        ("model.hidden=[20000, 20000]", "model.hidden"),
        ("data.train=[\"run\", \"nobody\"]", "nobody"),
    ] {
        let message = train(&["--set", set]);
        assert!(message.contains(part) && !message.contains("panicked"), "{set}: {message}");
    }
    assert!(train(&["--checkpoint-s", "1e300"]).contains("--checkpoint-s"));
    assert!(train(&["--timeout", "-1"]).contains("--timeout"));
    assert!(train(&["--threads", "100000000"]).contains("at most"));
    assert!(!out.exists(), "nothing is left behind");

    let clock = f.file("clock.toml", "[sensors.clock]\nrate_hz = 1e9\n");
    let rig = ["rig", "record", "--conditions", "45/45", "--out", text(&out), "--rig"];
    refused(&[&rig[..], &[text(&clock)]].concat(), &["rate_hz", "samples"]);
    let absurd = f.file("absurd.toml", "[pneumatics.valve]\ninflate_conductance = 1e300\n");
    refused(&[&rig[..], &[text(&absurd)]].concat(), &["nn_4545", "finite"]);
    let sweep = f.file(
        "sweep.toml",
        format!(
            "name = \"t\"\n[experiment]\nrecordings = [{:?}]\n[search]\ndraws = 100000000\n[[axis]]\nkey = \"rate\"\n\
             uniform = [1e-4, 1e-3]\n",
            text(&data)
        ),
    );
    let message = String::from_utf8(ended(&["ablate", text(&sweep), "--list"]).stderr).unwrap();
    assert!(message.contains("100000000") && message.contains("cells"), "{message}");

    let longer = f.file("run.csv", small_csv(4000));
    let diagnose =
        ["diagnose", "--accept", "--no-law", "--data", text(&longer), "--out", text(&out)];
    for (settings, part) in [
        ("burn_out_s = 1e12", "validation"),
        ("points_per_row = 1000000", "training"),
        ("kept_share = 0.05\nburn_out_s = 0.3", "test"),
    ] {
        let file = f.file("settings.toml", format!("[data]\n{settings}\n"));
        refused(&[&diagnose[..], &["--settings", text(&file)]].concat(), &["run", "row", part]);
    }
}

/// The limit on the wall clock ends whatever runs.
#[test]
fn a_time_limit_ends_the_program() {
    let f = Folder::new();
    let out = f.at("out");
    let output = ended(&["demo", "-q", "--timeout", "0.2", "--out", text(&out)]);
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(1) && message.contains("--timeout 0.2"), "{message}");
}

/// Run by `cargo test --release --workspace --tests -- --ignored long::`.
mod long {
    use super::*;

    /// Models of any finite numbers give an answer or an error in time.
    #[test]
    #[ignore = "long"]
    fn models_of_any_finite_numbers_end() {
        let f = Folder::new();
        let data = published("data.mat");
        let out = f.at("out");
        let saved = load_model(published_weights()).unwrap();
        let made = |change: &dyn Fn(&mut pam_data::SavedModel)| {
            let mut saved = saved.clone();
            change(&mut saved);
            let path = f.at("model.safetensors");
            save_model(&path, &saved).unwrap();
            path
        };
        let with = |command: &[&str], model: &Path| {
            ended(&[command, &["-q", "--model", text(model), "--out", text(&out)]].concat())
        };
        for (raw, quantity) in [([-50.0, 1.0, 1.0], "mass"), ([300.0, 8e7, 1e6], "deformation")] {
            let model = made(&|s| {
                s.model.raw = pam_core::RawParameters {
                    mass: raw[0],
                    gas_coefficient: raw[1],
                    deformation: raw[2],
                };
            });
            let output = with(&["replan"], &model);
            let message = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(output.status.code() == Some(1) && message.contains(quantity), "{message}");
        }
        // A joint of a thousand tons hardly moves: the search for its stiffness ends.
        let heavy = made(&|s| s.model.raw.mass = 1e6);
        let code = with(&["identify"], &heavy).status.code();
        assert!(matches!(code, Some(0 | 1)), "{code:?}");
        let _ = std::fs::remove_dir_all(&out);
        // Weights × 10⁶: the equations are a trillion times too stiff for any step.
        let steep = made(&|s| {
            let pam_core::AnyForce::Network(network) = &mut s.model.force else { panic!() };
            use pam_core::ParametricForce;
            let weights: Vec<f64> = network.parameters().iter().map(|w| 1e6 * w).collect();
            *network = network.with_parameters(&weights);
        });
        // No search for masses along a curve of kinks without end.
        let motion = ["plan", "--motion", "sine:A=1,f=0.5", "--stiffness", "150"];
        for command in [&motion[..], &["replan"]] {
            let output = with(command, &steep);
            let message = String::from_utf8_lossy(&output.stderr).into_owned();
            assert!(
                output.status.code() == Some(1) && message.contains("reasonable time"),
                "{message}"
            );
        }
        let evaluate = ["evaluate", "--accept", "--data", text(&data)];
        assert_eq!(with(&evaluate, &steep).status.code(), Some(3));
        let tsit5 = [&evaluate[..], &["--method", "tsit5"]].concat();
        assert_eq!(with(&tsit5, &steep).status.code(), Some(3));
        // Hundreds of simulations in steps of an eighth of a millisecond are none that anybody waits for.
        let found = f.at("found");
        let diagnose = ["diagnose", "--accept", "--data", text(&data), "--out", text(&found)];
        refused(
            &[&diagnose[..], &["--model", text(&steep)]].concat(),
            &["substeps", "data.most_substeps"],
        );
        let gradient = ["gradient", "--accept", "--data", text(&data), "--out"];
        let npz = f.at("g.npz");
        refused(
            &[&gradient[..], &[text(&npz), "--model", text(&steep)]].concat(),
            &["no recording could be predicted"],
        );
        // No force at all: the joint runs away, and a gradient means nothing.
        let free = made(&|s| {
            let pam_core::AnyForce::Network(network) = &mut s.model.force else { panic!() };
            use pam_core::ParametricForce;
            *network = network.with_parameters(&vec![0.0; network.parameter_len()]);
        });
        refused(
            &[&gradient[..], &[text(&npz), "--model", text(&free)]].concat(),
            &["no volume left"],
        );
        assert!(!npz.exists());
    }

    /// Seconds that are no seconds, and channels that do not change.
    #[test]
    #[ignore = "long"]
    fn recordings_of_other_units_end() {
        let f = Folder::new();
        let scaled = |by: f64| -> String {
            let row = |line: &str| match line.split_once(',') {
                Some((t, rest)) if t.parse::<f64>().is_ok() => {
                    format!("{},{rest}", by * t.parse::<f64>().unwrap())
                }
                _ => line.to_owned(),
            };
            small_csv(2000).lines().map(row).collect::<Vec<_>>().join("\n")
        };
        let data = f.file("e9.csv", scaled(1e12));
        let out = f.at("out");
        let model = published_weights();
        let with = |command: &str, code: i32| {
            message(
                &[
                    command,
                    "--accept",
                    "--data",
                    text(&data),
                    "--model",
                    text(&model),
                    "--out",
                    text(&out),
                ],
                code,
            )
        };
        assert!(with("diagnose", 1).contains("time_s in seconds"));
        assert!(with("evaluate", 3).contains("could not be predicted"));
        // Nor are there steps without end where their size is given.
        let run = f.file("run.csv", small_csv(300));
        let command = ["evaluate", "--accept", "--method", "rk4", "--step-ms", "1e-9", "--model"];
        let rest = [text(&model), "--data", text(&run), "--out", text(&out)];
        assert!(message(&[&command[..], &rest].concat(), 3).contains("could not be predicted"));
        // Without a force there is nothing to learn, and nothing to fail on.
        let still: Vec<String> = small_csv(3000)
            .lines()
            .map(|line| match line.rsplit_once(',') {
                Some((rest, force)) if force.parse::<f64>().is_ok() => format!("{rest},0"),
                _ => line.to_owned(),
            })
            .collect();
        let still = f.file("still.csv", still.join("\n"));
        let curriculum = f.file("short.toml", CURRICULUM);
        let trained = f.at("trained");
        let train = ["train", text(&curriculum), "--accept", "-q", "--data", text(&still), "--out"];
        let code = ended(&[&train[..], &[text(&trained)]].concat()).status.code();
        assert!(matches!(code, Some(0 | 1)), "{code:?}");
        let flat = f.at("flat");
        let stiffness = ["stiffness", "--model", "spring-damper", "-q", "--out", text(&flat)];
        let _ = message(&stiffness, 0);
    }
}
