//! The template of a `pam` of one's own: its effect, activation and loss are known by name to every command, and the program
//! without them says what it lacks.

use pam_tests::{run, stdout_of, text};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

const PAM: &str = env!("CARGO_BIN_EXE_pam-under-test");
const OWN: &str = env!("CARGO_BIN_EXE_own-pam-under-test");

/// What a program without a part says to do.
const ADVICE: [&str; 2] = ["pam_cli::Registry", "templates/own-pam"];

fn json_of(program: &str, arguments: &[&str]) -> Value {
    let text = stdout_of(program, &[arguments, &["--json", "--quiet"]].concat());
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{arguments:?}: {e}: {text}"))
}

/// The program without the parts fails and names what it lacks, with advice.
fn lacks(part: &str, arguments: &[&str]) {
    let output = run(PAM, arguments);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(!output.status.success(), "{arguments:?}");
    for word in ADVICE.iter().chain([&part]) {
        assert!(errors.contains(word), "{arguments:?}: {word} is missing in: {errors}");
    }
}

/// Short recordings of the rig without sensor errors, and the model that the template's curriculum makes of them.
static TRAINED: LazyLock<(tempfile::TempDir, PathBuf, PathBuf)> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let protocol = folder.path().join("p.toml");
    let sine =
        "[[current]]\nkind = \"sine\"\namplitude_a = 1.5\nfrequency_hz = 1.0\nduration_s = 2.0\n";
    let conditions = "conditions = [[30, 60], [60, 30], [45, 45]]";
    std::fs::write(&protocol, format!("name = \"t\"\n{conditions}\n{sine}")).unwrap();
    let logs = folder.path().join("logs");
    let record =
        ["rig", "record", "--ideal", "all", "--no-truth", "--quiet", "--protocol", text(&protocol)];
    let _ = stdout_of(OWN, &[&record[..], &["--out", text(&logs)]].concat());
    let out = folder.path().join("run");
    let train = ["train", &curriculum(), "--data", text(&logs), "--out", text(&out), "--quiet"];
    let _ = stdout_of(OWN, &train);
    let model = out.join("model.safetensors");
    (folder, logs, model)
});

fn curriculum() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../templates/own-pam/curriculum.toml");
    text(&path).to_owned()
}

#[test]
fn a_curriculum_trains_the_activation_with_the_loss_and_the_model_is_read_again() {
    let (_, logs, model) = &*TRAINED;
    let inspected = json_of(OWN, &["inspect", text(model)]);
    let found = inspected.to_string();
    assert!(found.contains("\"activation\":\"snake\""), "{found}");
    let folder = tempfile::tempdir().unwrap();
    let evaluated = folder.path().join("evaluated");
    let _ = stdout_of(
        OWN,
        &[
            "evaluate",
            "--model",
            text(model),
            "--data",
            text(logs),
            "--out",
            text(&evaluated),
            "--quiet",
        ],
    );
    // The curriculum that the run keeps has the loss with its settings.
    let kept = std::fs::read_to_string(model.with_file_name("curriculum.toml")).unwrap();
    assert!(kept.contains("log_cosh") && kept.contains("snake"), "{kept}");
    let gradient = folder.path().join("gradient.npz");
    let data = ["--data", text(logs), "--out", text(&gradient), "--quiet"];
    let by_loss = |loss: &str| {
        let arguments = [&["gradient", "--model", text(model), "--loss", loss][..], &data].concat();
        run(OWN, &arguments)
    };
    assert!(by_loss("log_cosh:scales=0.1/1/5/5").status.success());
    let wrong = String::from_utf8_lossy(&by_loss("log_cosh:scale=1").stderr).into_owned();
    assert!(wrong.contains("no setting `scale`") && wrong.contains("scales"), "{wrong}");
}

#[test]
fn every_part_is_listed_and_marked() {
    let own = json_of(OWN, &["parts"]);
    let names = |program: &Value| -> Vec<String> {
        let parts = program.as_array().unwrap().iter().filter(|p| p["own"] == true);
        parts.map(|p| format!("{} {}", p["kind"], p["name"]).replace('"', "")).collect()
    };
    assert_eq!(names(&own), ["effect detent", "activation snake", "loss log_cosh"]);
    assert!(names(&json_of(PAM, &["parts"])).is_empty());
    let help = stdout_of(OWN, &["diagnose", "--help"]);
    assert!(help.contains("detent"), "{help}");
}

#[test]
fn the_program_without_the_parts_names_what_it_lacks() {
    let (folder, logs, model) = &*TRAINED;
    let out = folder.path().join("nothing");
    let (model, logs, out) = (text(model), text(logs), text(&out));
    lacks("snake", &["inspect", model]);
    lacks("snake", &["evaluate", "--model", model, "--data", logs, "--out", out]);
    lacks("snake", &["train", "--data", logs, "--set", "model.activation=snake", "--out", out]);
    lacks("log_cosh", &["train", &curriculum(), "--data", logs, "--out", out]);
    lacks("log_cosh", &["gradient", "--data", logs, "--loss", "log_cosh", "--out", out]);
    lacks("detent", &["diagnose", "--data", logs, "--effects", "detent", "--out", out]);
    let simulate = ["simulate", "--force", "sine:A=100,f=1", "--duration", "1", "--out", "x.csv"];
    lacks("detent", &[&simulate[..], &["--effect", "detent:force_n=20,position_mm=0.2"]].concat());
}

#[test]
fn a_sweep_varies_the_activation_and_a_comparison_trains_it() {
    let (_, logs, _) = &*TRAINED;
    let folder = tempfile::tempdir().unwrap();
    let sweep = folder.path().join("sweep.toml");
    let content = format!(
        "name = \"t\"\nseeds = 1\n[experiment]\ncurriculum = \"{}\"\nrecordings = [\"{}\"]\n\
         [[axis]]\nkey = \"model.activation\"\nvalues = [\"snake\", \"tanh\"]\n",
        curriculum(),
        text(logs)
    );
    std::fs::write(&sweep, content).unwrap();
    let swept = folder.path().join("swept");
    let _ = stdout_of(OWN, &["ablate", text(&sweep), "--quiet", "--out", text(&swept)]);
    let table = std::fs::read_to_string(swept.join("results.csv")).unwrap();
    assert!(table.contains("snake") && table.contains("tanh"), "{table}");

    let models = folder.path().join("models.toml");
    let content = format!(
        "name = \"t\"\n[data]\nrecordings = [\"{}\"]\ntrain = [\"3060\", \"6030\"]\n\
         [[model]]\nkind = \"hybrid\"\ncurriculum = \"{}\"\n",
        text(logs),
        curriculum()
    );
    std::fs::write(&models, content).unwrap();
    let compared = folder.path().join("compared");
    let arguments = ["compare", text(&models), "--out", text(&compared), "--quiet"];
    let _ = stdout_of(OWN, &arguments);
    assert!(compared.join("comparison.json").exists());
}

#[test]
fn an_effect_is_simulated_named_by_the_diagnosis_and_kept_in_the_model() {
    let folder = tempfile::tempdir().unwrap();
    let mut data = Vec::new();
    for (name, force) in [("a", "sine:A=90,f=0.5"), ("b", "sine:A=120,f=1"), ("c", "sine:A=60,f=1")]
    {
        let out = folder.path().join(format!("{name}.csv"));
        let simulate =
            ["simulate", "--model", "spring-damper", "--force", force, "--duration", "8"];
        let effect = ["--rate", "250", "--effect", "detent:force_n=20,position_mm=0.1", "--quiet"];
        let _ = stdout_of(OWN, &[&simulate[..], &effect, &["--out", text(&out)]].concat());
        data.push(text(&out).to_owned());
    }
    let out = folder.path().join("found");
    let mut diagnose =
        vec!["diagnose", "--no-law", "--model", "spring-damper", "--out", text(&out)];
    diagnose.extend([
        "--effects",
        "coulomb_friction,stiffness_scale,constant_load,detent",
        "--data",
    ]);
    diagnose.extend(data.iter().map(String::as_str));
    let found = json_of(OWN, &diagnose);
    assert_eq!(found["causes"][0]["effect"], "detent", "{}", found["verdict"]);
    let model = out.join("model.safetensors");
    let own = stdout_of(OWN, &["inspect", text(&model)]);
    assert!(own.contains("detent (force_n = 20"), "{own}");

    // The program without it reads the model, says what it cannot use, and predicts nothing with it.
    let stock = stdout_of(PAM, &["inspect", text(&model)]);
    for word in ADVICE.iter().chain([&"no effect `detent`"]) {
        assert!(stock.contains(word), "{stock}");
    }
    let evaluated = folder.path().join("evaluated");
    let evaluate =
        ["evaluate", "--model", text(&model), "--data", &data[0], "--out", text(&evaluated)];
    let _ = stdout_of(OWN, &[&evaluate[..], &["--quiet"]].concat());
    lacks("detent", &evaluate);
}
