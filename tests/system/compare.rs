//! The comparison through the program: what it writes, that it repeats to the bit, survives being killed,
//! and says what is wrong.

use pam_tests::{run, stdout_of, text};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::LazyLock;
use std::time::Duration;

const PAM: &str = env!("CARGO_BIN_EXE_pam-under-test");

/// Six recordings of the rig, shortened, without sensor errors.
static DATA: LazyLock<(tempfile::TempDir, PathBuf)> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let protocol = folder.path().join("p.toml");
    let sine = |f: f64| {
        format!(
            "[[current]]\nkind = \"sine\"\namplitude_a = 1.5\nfrequency_hz = {f}\nduration_s = 3.0\n"
        )
    };
    let conditions = "[[30, 60], [60, 30], [45, 45], [80, 80], [55, 40], [40, 65]]";
    let content = format!("name = \"t\"\nconditions = {conditions}\n{}{}", sine(1.0), sine(2.0));
    std::fs::write(&protocol, content).unwrap();
    let out = folder.path().join("logs");
    let arguments = ["rig", "record", "--ideal", "all", "--no-truth", "--quiet", "--protocol"];
    let _ = stdout_of(PAM, &[&arguments[..], &[text(&protocol), "--out", text(&out)]].concat());
    (folder, out)
});

/// A model of every kind, small; the last ones take long enough to be killed.
const MODELS: &str = "
[[model]]
kind = \"spring_damper\"
[[model]]
kind = \"koopman\"
[[model]]
name = \"Koopman & linear_\"
kind = \"koopman\"
dictionary = \"linear\"
rollout = \"lifted\"
[[model]]
kind = \"equilibrium_point\"
[[model]]
kind = \"sparse_force\"
degree = 2
[[model]]
kind = \"kang\"
[[model]]
kind = \"hybrid\"
curriculum = \"CURRICULUM\"
[[model]]
kind = \"gru\"
hidden = 16
warm_up = 20
horizon = 20
rollout = 4
samples_per_step = 10
updates_per_epoch = 20
epochs = 2
[[model]]
kind = \"neural_ode\"
width = 16
updates = 60
steps_per_window = 50
";

const CURRICULUM: &str = "name = \"short\"\n[model]\nhidden = [32, 32]\n\
    [[stage]]\nkind = \"gas\"\nname = \"gas\"\n\
    [[stage]]\nkind = \"derivatives\"\nname = \"derivatives\"\nmatching = { steps = 800, batch = 256 }\n";

fn config(folder: &Path) -> String {
    let curriculum = folder.join("curriculum.toml");
    std::fs::write(&curriculum, CURRICULUM).unwrap();
    let path = folder.join("compare.toml");
    let data = format!(
        "name = \"small\"\n[data]\nrecordings = [\"{}\"]\ntrain = [\"3060\", \"6030\", \"4545\", \"8080\"]\n",
        text(&DATA.1)
    );
    std::fs::write(&path, data + &MODELS.replace("CURRICULUM", text(&curriculum))).unwrap();
    text(&path).to_owned()
}

/// The files that must repeat to the bit, numbers of the models included.
fn results(out: &Path) -> Vec<(String, Vec<u8>)> {
    let read = |name: &str| (name.to_owned(), std::fs::read(out.join(name)).unwrap());
    let mut all: Vec<_> =
        ["comparison.json", "table.csv", "recordings.csv", "run.json"].map(read).to_vec();
    let mut names: Vec<String> = std::fs::read_dir(out.join("models"))
        .unwrap()
        .map(|e| e.unwrap().file_name().into_string().unwrap())
        .filter(|n| n.ends_with(".npz"))
        .collect();
    names.sort();
    all.extend(names.iter().map(|n| read(&format!("models/{n}"))));
    all
}

/// Table, report and LaTeX hold every model; scores agree with each other.
fn the_files_say_the_same(out: &Path, models: &[Value]) {
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    let (table, tex, html) = (read("table.csv"), read("table.tex"), read("report.html"));
    let mut lines = table.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let column = |name: &str| header.iter().position(|h| *h == name).unwrap();
    let mean = column("cold_held_out_r2_x_mean");
    let recordings = read("recordings.csv");
    for (line, model) in lines.zip(models) {
        let name = model["name"].as_str().unwrap();
        assert!(line.starts_with(&format!("\"{name}\",")), "{line}");
        let cells: Vec<&str> = line.split(',').collect();
        // The title of one model holds a comma.
        let shift = name.matches(',').count();
        let own: Vec<f64> = recordings
            .lines()
            .filter(|l| l.starts_with(&format!("\"{name}\",cold,held_out,")))
            .filter_map(|l| l.split(',').nth(4 + shift).unwrap().parse().ok())
            .collect();
        if let Ok(mean) = cells[mean + shift].parse::<f64>() {
            assert!((mean - own.iter().sum::<f64>() / own.len() as f64).abs() < 1e-12, "{name}");
        }
        assert!(html.contains(&name.replace('&', "&amp;")), "{name}");
    }
    // Recordings without noise of a joint that is nearly linear at these pressures.
    let spring: f64 = models[0]["cold"]["held_out"]["displacement"]["mean"].as_f64().unwrap();
    assert!(spring > 0.9, "{spring}");

    // LaTeX: as many columns in every row, everything escaped that must be.
    assert!(tex.contains("Koopman \\& linear\\_ &"), "{tex}");
    let rows = tex.lines().filter(|l| l.ends_with("\\\\") && !l.contains("multicolumn{"));
    let columns: Vec<usize> = rows.map(|l| l.replace("\\&", "").matches('&').count() + 1).collect();
    assert_eq!(columns, vec![11; 1 + models.len()]);
    for (begin, end) in [("\\begin{tabular}", "\\end{tabular}"), ("\\toprule", "\\bottomrule")] {
        assert!(tex.matches(begin).count() == 1 && tex.matches(end).count() == 1);
    }
    assert_eq!(tex.matches('{').count(), tex.matches('}').count());
    assert!(tex.matches('$').count().is_multiple_of(2));
}

#[test]
fn mistakes_are_told_with_file_and_line() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let path = folder.path().join("wrong.toml");
    let data = "[data]\nrecordings = [\"nowhere\"]\n";
    for (content, place, part) in [
        (format!("{data}[[model]]\nkind = \"gruu\"\n"), "wrong.toml:3:", "gru"),
        (format!("{data}[[model]]\nkind = \"gru\"\nrate = -1.0\n"), "wrong.toml:3:", "rate"),
        (format!("{data}[[model]]\nkind = \"gru\"\nhidden = 90\n"), "wrong.toml:3:", "16"),
        (
            format!("{data}[[model]]\nkind = \"gru\"\nrest_share = 2.0\n"),
            "wrong.toml:3:",
            "rest_share",
        ),
        (format!("{data}[[model]\n"), "wrong.toml:3:", ""),
        (format!("{data}[[model]]\nkind = \"kang\"\n"), "nowhere", ""),
    ] {
        std::fs::write(&path, &content).unwrap();
        let output = run(PAM, &["compare", text(&path), "--out", text(&out)]);
        let message = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{message}");
        assert!(message.contains(place) && message.contains(part), "{message}");
        assert!(!message.contains("panicked") && !out.exists(), "{message}");
    }
}

/// Run by `cargo test --release --workspace --tests -- --ignored long::`.
mod long {
    use super::*;

    #[test]
    #[ignore = "long"]
    fn it_repeats_to_the_bit_at_any_number_of_threads_and_when_killed() {
        let folder = tempfile::tempdir().unwrap();
        let config = config(folder.path());
        let [one, two, other] = ["one", "two", "other"].map(|n| folder.path().join(n));
        let compare = |out: &Path, more: &[&str]| {
            stdout_of(PAM, &[&["compare", &config, "--out", text(out)], more].concat())
        };
        let printed = compare(&one, &["--threads", "1", "--json"]);
        let json: Value = serde_json::from_str(&printed).unwrap();
        let models = json["comparison"]["models"].as_array().unwrap();
        assert_eq!(models.len(), 9);

        // Killed as soon as the first models are kept, then resumed.
        let mut command = Command::new(PAM);
        command.args(["compare", &config, "--out", text(&two), "--threads", "2", "--quiet"]);
        let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        while !two.join("models/linear-spring-damper.json").exists() {
            assert!(child.try_wait().unwrap().is_none(), "it ended before it could be killed");
            std::thread::sleep(Duration::from_millis(2));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(!two.join("comparison.json").exists(), "it was killed too late");
        let printed = compare(&two, &["--threads", "2", "--resume"]);
        assert!(printed.contains("Linear spring–damper: was done"), "{printed}");
        assert!(!printed.contains("Black-box neural ODE: was done"), "{printed}");
        assert!(results(&one) == results(&two));

        // What is kept of one seed is not taken over for another one.
        std::fs::create_dir_all(&other).unwrap();
        let quick = folder.path().join("quick.toml");
        let whole = std::fs::read_to_string(&config).unwrap();
        let end = whole.find("[[model]]\nkind = \"equilibrium_point\"").unwrap();
        std::fs::write(&quick, &whole[..end]).unwrap();
        let again = |seed: &str| {
            let out = ["--out", text(&other), "--seed", seed, "--resume"];
            stdout_of(PAM, &[&["compare", text(&quick)], &out[..]].concat())
                .matches("was done")
                .count()
        };
        assert_eq!([again("1"), again("1"), again("2")], [0, 3, 0]);

        the_files_say_the_same(&one, models);
    }
}
