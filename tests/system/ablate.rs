//! Sweeps through the program: killed at any moment they go on without repeating or losing a cell, two
//! processes never run the same one, what fails is recorded, shards merge to the same bytes.

use pam_ablate::prelude::*;
use pam_tests::{ended_within, run, stdout_of, text};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

const PAM: &str = env!("CARGO_BIN_EXE_pam-under-test");

/// Five short recordings of the rig without sensor errors: four to train on, one held out.
static DATA: LazyLock<(tempfile::TempDir, PathBuf)> = LazyLock::new(|| {
    let folder = tempfile::tempdir().unwrap();
    let protocol = folder.path().join("p.toml");
    let conditions = "[[30, 60], [60, 30], [45, 45], [80, 80], [55, 40]]";
    let sine = |f: f64, s: f64| {
        format!(
            "[[current]]\nkind = \"sine\"\namplitude_a = 1.5\nfrequency_hz = {f}\nduration_s = {s}\n"
        )
    };
    let currents = sine(0.5, 4.0) + &sine(2.0, 2.0);
    std::fs::write(&protocol, format!("name = \"t\"\nconditions = {conditions}\n{currents}"))
        .unwrap();
    let out = folder.path().join("logs");
    let arguments =
        ["rig", "record", "--ideal", "all", "--no-truth", "--quiet", "--protocol", text(&protocol)];
    let status = Command::new(PAM).args(arguments).arg("--out").arg(&out).status().unwrap();
    assert!(status.success());
    (folder, out)
});

/// Six cells of some tenths of a second.
fn sweep(folder: &Path, more: &str) -> String {
    let path = folder.join("sweep.toml");
    let logs = text(&DATA.1);
    let text_of = format!(
        "name = \"t\"\nseeds = 2\n[experiment]\nrecordings = [\"{logs}\"]\n[set]\n\"model.hidden\" = [32, 32]\n\
         \"stage.1.matching\" = {{ steps = 300, batch = 256 }}\n\"stage.2.epochs\" = 30\n\
         [[axis]]\nkey = \"model.activation\"\nvalues = [\"silu\", \"leaky_relu\", \"tanh\"]\n{more}"
    );
    std::fs::write(&path, text_of).unwrap();
    text(&path).to_owned()
}

fn spawn(sweep: &str, out: &Path, more: &[&str]) -> Child {
    let mut command = Command::new(PAM);
    command
        .args(["ablate", sweep, "--quiet", "--checkpoint-s", "0", "--out", text(out)])
        .args(more);
    command.stderr(Stdio::null()).stdout(Stdio::null()).spawn().unwrap()
}

fn finish(sweep: &str, out: &Path, more: &[&str]) {
    assert!(spawn(sweep, out, more).wait().unwrap().success());
}

fn read(out: &Path, file: &str) -> Vec<u8> {
    std::fs::read(out.join(file)).unwrap()
}

/// The events of each cell, in order.
fn events(out: &Path) -> BTreeMap<String, Vec<String>> {
    let Ok(cells) = std::fs::read_dir(out.join("cells")) else { return BTreeMap::new() };
    let of = |path: PathBuf| {
        let claim = std::fs::read_to_string(path.join("claim")).unwrap_or_default();
        let event =
            |l: &str| Some(serde_json::from_str::<Value>(l).ok()?["event"].as_str()?.to_owned());
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        (name, claim.lines().filter_map(event).collect())
    };
    cells.map(|c| of(c.unwrap().path())).collect()
}

fn count(events: &BTreeMap<String, Vec<String>>, name: &str) -> usize {
    events.values().flatten().filter(|e| *e == name).count()
}

/// Rows of a cell's `metrics.csv`, with the time that each epoch took: made again, they would differ.
fn rows(out: &Path, cell: &str) -> Vec<String> {
    let path = out.join("cells").join(cell).join("work/metrics.csv");
    let text = std::fs::read_to_string(path).unwrap_or_default();
    text.lines().map(str::to_owned).collect()
}

/// Epochs that a cell's checkpoint holds.
fn saved_epochs(out: &Path, cell: &str) -> usize {
    let path = out.join("cells").join(cell).join("work/checkpoint.json");
    let checkpoint =
        std::fs::read(path).ok().and_then(|b| serde_json::from_slice::<Value>(&b).ok());
    checkpoint.and_then(|c| c["state"]["epochs"].as_u64()).map_or(0, |n| n as usize)
}

/// A cell is what its data are, not where: moved, mounted elsewhere or named otherwise, a sweep goes on; with
/// one other sample it is another one.
#[test]
fn cells_do_not_depend_on_where_the_data_are() {
    let folder = tempfile::tempdir().unwrap();
    let [old, new, mount] = ["old", "new/place", "mount"].map(|n| folder.path().join(n));
    std::fs::create_dir_all(old.join("logs")).unwrap();
    for file in std::fs::read_dir(&DATA.1).unwrap().flatten() {
        std::fs::copy(file.path(), old.join("logs").join(file.file_name())).unwrap();
    }
    // Paths from the sweep's folder, and the program from the folder above it.
    let text_of = std::fs::read_to_string(sweep(&old, "")).unwrap();
    let relative = text_of.replace(text(&DATA.1), "logs");
    assert_ne!(relative, text_of);
    std::fs::write(old.join("sweep.toml"), relative).unwrap();
    let ablate = |at: &Path, more: &[&str]| {
        let set = ["--set", "stage.2.epochs=2", "--quiet", "--json"];
        let mut command = Command::new(PAM);
        command.current_dir(at).arg("ablate").args(more).args(set).output().unwrap()
    };
    let ran = |output: &std::process::Output| -> Value {
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let value: Value = serde_json::from_slice(&output.stdout).unwrap();
        value["this_process"]["done"].clone()
    };
    let first = ablate(folder.path(), &["old/sweep.toml", "--out", "old/out", "--shard", "1/2"]);
    assert_eq!(ran_in_part(&first), 3);
    std::fs::create_dir_all(new.parent().unwrap()).unwrap();
    std::fs::rename(&old, &new).unwrap();

    // The other shard finds the data under another name, through --data.
    std::os::unix::fs::symlink(new.join("logs"), &mount).unwrap();
    let second = ["new/place/sweep.toml", "--out", "new/place/out", "--data", text(&mount)];
    assert_eq!(ran(&ablate(folder.path(), &second)), 3);
    let again = ablate(&new, &["sweep.toml", "--out", "out"]);
    assert_eq!(ran(&again), 0);

    // What was found is gathered without the data.
    std::fs::rename(new.join("logs"), new.join("kept")).unwrap();
    let merged = Command::new(PAM)
        .args(["ablate", "merge", text(&new.join("out")), "--quiet", "--out"])
        .arg(folder.path().join("merged"))
        .output()
        .unwrap();
    assert!(merged.status.success(), "{}", String::from_utf8_lossy(&merged.stderr));
    let table = read(&folder.path().join("merged"), "results.csv");
    assert!(table == read(&new.join("out"), "results.csv"));
    std::fs::rename(new.join("kept"), new.join("logs")).unwrap();

    let log = std::fs::read_dir(new.join("logs")).unwrap().flatten().next().unwrap().path();
    let mut lines: Vec<String> =
        std::fs::read_to_string(&log).unwrap().lines().map(str::to_owned).collect();
    let last = lines.len() - 1;
    lines.remove(last);
    std::fs::write(&log, lines.join("\n") + "\n").unwrap();
    let other = ablate(&new, &["sweep.toml", "--out", "out"]);
    let said = String::from_utf8_lossy(&other.stderr);
    assert!(!other.status.success() && said.contains("on other recordings"), "{said}");
}

/// Cells that a process ran, of a sweep that is not through.
fn ran_in_part(output: &std::process::Output) -> u64 {
    assert_eq!(output.status.code(), Some(3), "{}", String::from_utf8_lossy(&output.stderr));
    let value: Value = serde_json::from_slice(&output.stdout).unwrap();
    value["this_process"]["done"].as_u64().unwrap()
}

#[test]
#[cfg(unix)]
fn a_signal_saves_and_the_same_command_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let file = sweep(folder.path(), "");
    let out = folder.path().join("run");
    let mut child = spawn(&file, &out, &["--jobs", "1", "--set", "stage.2.epochs=2000"]);
    let begun = Instant::now();
    while !events(&out).keys().any(|cell| saved_epochs(&out, cell) > 5) {
        assert!(begun.elapsed() < Duration::from_secs(50), "no checkpoint");
        std::thread::sleep(Duration::from_millis(20));
    }
    let pid = child.id().to_string();
    assert!(run("kill", &["-TERM", &pid]).status.success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    let events = events(&out);
    assert_eq!(count(&events, "stopped"), 1);
    assert_eq!(count(&events, "began"), 1 + count(&events, "over"));
    // Another sweep has no place in the folder unless it is said to.
    let output = run(PAM, &["ablate", &file, "--out", text(&out)]);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains("it holds another sweep"), "{message}");
    finish(&file, &out, &["--extend"]);
}

#[test]
fn a_cell_that_fails_is_recorded_and_ends_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let file = sweep(folder.path(), "[[axis]]\nkey = \"subset\"\nvalues = [2, 40]\n");
    let out = folder.path().join("run");
    let output = run(PAM, &["ablate", &file, "--out", text(&out), "--json"]);
    assert_eq!(output.status.code(), Some(3));
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((&json["summary"]["done"], &json["summary"]["failed"]), (&6.into(), &6.into()));
    let results = String::from_utf8(read(&out, "results.csv")).unwrap();
    assert_eq!(results.matches("data.train selects 4 recordings").count(), 6, "{results}");
    let before = events(&out);
    // They are over, and not run again unless asked for.
    let again = |more: &[&str]| {
        run(PAM, &[&["ablate", &file, "--quiet", "--out", text(&out)], more].concat())
    };
    assert_eq!(again(&[]).status.code(), Some(3));
    assert_eq!(events(&out), before);
    assert_eq!(again(&["--retry-failed"]).status.code(), Some(3));
    assert_eq!(count(&events(&out), "began"), 12 + 6);
}

#[test]
fn mistakes_are_told_with_file_and_line() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("run");
    let head = "[experiment]\nrecordings = [\"logs\"]\n";
    let fails = |body: &str, expected: &str| {
        let file = folder.path().join("s.toml");
        std::fs::write(&file, body).unwrap();
        let output = run(PAM, &["ablate", text(&file), "--out", text(&out)]);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{message}");
        assert!(message.contains(expected), "{body}: {message}");
    };
    fails(
        &format!("{head}[[axis]]\nkey = \"model.activation\"\nvalues = [\n\"silu\",\n\"sinus\"]\n"),
        "s.toml:7: model.activation = \"sinus\"",
    );
    fails(&format!("{head}[set]\n\"rates\" = 1\n"), "s.toml:4: rates = 1: unknown field `rates`");
    fails(&format!("{head}[set]\n\"stage.9.epochs\" = 1\n"), "places 0 to 2");
    fails(&format!("{head}[set]\n\"stiffness.scheme\" = \"best\"\n"), "s.toml:4: stiffness.scheme");
    fails(
        &format!("{head}[[axis]]\nkey = \"curriculum\"\nvalues = [\"paper\", \"papr\"]\n"),
        "s.toml:5: curriculum",
    );
    fails("seeds = 1\n[experiment]\nrecording = []\n", "s.toml:2:");
    fails("[experiment]\n", "there are no recordings");
    fails("seeds = [1, 2\n", "s.toml:");
    let variants = "[[axis.variant]]\nname = \"a\"\n[[axis.variant]]\nname = \"b\"\n";
    fails(&format!("{head}[[axis]]\nname = \"how\"\n{variants}"), "are the same");
    let output = run(PAM, &["ablate", "activation", "--out", text(&out)]);
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(
        message.contains("activations, stiffness, gradients, curricula, data-size"),
        "{message}"
    );
    let output = run(PAM, &["ablate", "activations", "--out", text(&out), "--shard", "3/2"]);
    assert!(String::from_utf8_lossy(&output.stderr).contains("no shard"));
}

/// All sweeps that come with the program make sense.
#[test]
fn every_shipped_sweep_can_be_planned() {
    for name in Sweep::BUILT_IN {
        let printed = stdout_of(PAM, &["ablate", name, "--list", "--json"]);
        let json: Value = serde_json::from_str(&printed).unwrap();
        let cells = json["cells"].as_array().unwrap().len();
        assert!(cells >= 15 && cells.is_multiple_of(5), "{name}: {cells}");
    }
}

/// Counts the runs of each cell; one panics, one fails.
struct Own {
    runs: [AtomicUsize; 4],
}

impl Experiment for Own {
    fn configuration(&self, cell: &Cell) -> Result<Value, Problem> {
        Ok(serde_json::json!({ "k": cell.choices[0].label }))
    }

    fn run(&self, cell: &Cell, at: &Workplace<'_>) -> Result<Outcome, Problem> {
        let k = cell.choices[0].number.unwrap_or_default() as usize;
        self.runs[k].fetch_add(1, Ordering::Relaxed);
        (at.progress)(0.5);
        match k {
            2 => panic!("out of range"),
            3 => Err(Problem::new("no such k")),
            k => Ok(Outcome::Finished(Measurements {
                metrics: vec![("twice".into(), 2.0 * k as f64), ("odd".into(), f64::NAN)],
                ..Measurements::default()
            })),
        }
    }
}

#[test]
fn an_experiment_of_ones_own_is_swept_and_a_panic_ends_one_cell_only() {
    let folder = tempfile::tempdir().unwrap();
    let sweep = Sweep::new("own").with_axis("k", [0, 1, 2, 3]);
    let own = Own { runs: Default::default() };
    let planned = plan(&sweep, &own).unwrap();
    let at = SweepFolder::begin(folder.path(), &sweep, false).unwrap();
    let stop = AtomicBool::new(false);
    for _ in 0..2 {
        run_cells(&planned, &own, &at, &RunOptions::default(), &stop, &|_| {}).unwrap();
    }
    assert!(own.runs.iter().all(|n| n.load(Ordering::Relaxed) == 1));
    let summary = write_results(&at, &sweep, &planned, "a test").unwrap();
    assert_eq!((summary.done, summary.failed), (2, 2));
    let records = at.records(&planned).unwrap();
    let error = |k: usize| records[k].as_ref().unwrap().error.clone().unwrap_or_default();
    assert_eq!((error(2).as_str(), error(3).as_str()), ("panic: out of range", "no such k"));
    let csv = std::fs::read_to_string(folder.path().join("results.csv")).unwrap();
    assert!(csv.lines().nth(2).unwrap().contains(",1,1,done,2,,"), "{csv}");
}

/// Run by `cargo test --release --workspace --tests -- --ignored long::`.
mod long {
    use super::*;

    #[test]
    #[ignore = "long"]
    fn threads_and_jobs_change_no_byte() {
        let folder = tempfile::tempdir().unwrap();
        let file = sweep(folder.path(), "");
        let [one, two] = ["one", "two"].map(|n| folder.path().join(n));
        finish(&file, &one, &["--threads", "1"]);
        finish(&file, &two, &["--threads", "2", "--jobs", "1"]);
        for name in ["results.csv", "summary.csv", "summary.json", "run.json"] {
            assert!(read(&one, name) == read(&two, name), "{name}");
        }
        let report = String::from_utf8(read(&one, "report.html")).unwrap();
        assert!(report.contains("<svg") && report.contains("Wilcoxon"));
    }

    #[test]
    #[ignore = "long"]
    fn processes_that_share_a_folder_never_run_the_same_cell() {
        let folder = tempfile::tempdir().unwrap();
        let file = sweep(folder.path(), "");
        let [alone, shared, left, right, merged] =
            ["alone", "shared", "left", "right", "merged"].map(|n| folder.path().join(n));
        finish(&file, &alone, &["--jobs", "2"]);
        let mut children: Vec<Child> = [
            ["--shard", "1/2", "--steal", "--jobs", "1"].as_slice(),
            &["--shard", "2/2", "--steal", "--jobs", "1"],
            &["--jobs", "2"],
        ]
        .iter()
        .map(|more| spawn(&file, &shared, more))
        .collect();
        for child in &mut children {
            child.wait().unwrap();
        }
        let events = events(&shared);
        assert_eq!(events.len(), 6);
        for (cell, list) in &events {
            assert_eq!(list, &["began", "over"], "{cell}");
        }
        let printed = stdout_of(PAM, &["ablate", "merge", text(&shared), "--json"]);
        let json: Value = serde_json::from_str(&printed).unwrap();
        assert_eq!(json["summary"]["done"], 6);
        assert!(read(&alone, "results.csv") == read(&shared, "results.csv"));

        // Shards that share nothing, merged. Alone, each says that it is not all there is.
        for (out, shard) in [(&left, "1/2"), (&right, "2/2")] {
            let status = spawn(&file, out, &["--shard", shard]).wait().unwrap();
            assert_eq!(status.code(), Some(3));
        }
        let both =
            ["ablate", "merge", text(&left), text(&right), "--out", text(&merged), "--quiet"];
        assert!(run(PAM, &both).status.success());
        for name in ["results.csv", "summary.csv", "summary.json"] {
            assert!(read(&merged, name) == read(&alone, name), "{name}");
        }
        // Nothing is left to do there.
        let printed = stdout_of(PAM, &["ablate", &file, "--out", text(&merged), "--json"]);
        let json: Value = serde_json::from_str(&printed).unwrap();
        assert_eq!(json["this_process"]["done"], 0);

        // Numbers that differ for the same cell are not merged silently.
        let cell = std::fs::read_dir(left.join("cells")).unwrap().next().unwrap().unwrap().path();
        let result = cell.join("result.json");
        let mut record: Value = serde_json::from_slice(&std::fs::read(&result).unwrap()).unwrap();
        record["metrics"]["loss"] = 1.25.into();
        std::fs::write(&result, record.to_string()).unwrap();
        let output =
            run(PAM, &["ablate", "merge", text(&merged), text(&left), "--out", text(&merged)]);
        let message = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && message.contains("for the same cell"), "{message}");
    }

    #[test]
    #[ignore = "long"]
    fn a_sweep_that_is_killed_goes_on_without_repeating_or_losing_a_cell() {
        let folder = tempfile::tempdir().unwrap();
        let file = sweep(folder.path(), "");
        let [whole, cut] = ["whole", "cut"].map(|n| folder.path().join(n));
        let begun = Instant::now();
        finish(&file, &whole, &[]);
        let time = begun.elapsed();
        let (mut kills, mut kept) = (0, 0);
        for part in 1..=40 {
            // What is over or saved now must still be there at the end.
            let before: Vec<(String, Vec<String>, usize)> = events(&cut)
                .into_keys()
                .map(|cell| (cell.clone(), rows(&cut, &cell), saved_epochs(&cut, &cell)))
                .collect();
            let results: BTreeMap<String, Vec<u8>> = before
                .iter()
                .filter_map(|(c, ..)| {
                    let path = cut.join("cells").join(c).join("result.json");
                    Some((c.clone(), std::fs::read(path).ok()?))
                })
                .collect();
            let mut child = spawn(&file, &cut, &[]);
            // Ever later, so that the sweep comes to its end.
            let patience = time.mul_f64(0.15 + 0.04 * f64::from(part));
            let ended = ended_within(&mut child, patience);
            if ended.is_none() {
                child.kill().unwrap();
                child.wait().unwrap();
                kills += 1;
            }
            for (cell, old, epochs) in before {
                let new = rows(&cut, &cell);
                let same = old.iter().zip(&new).take(1 + epochs);
                assert!(
                    same.clone().all(|(a, b)| a == b),
                    "{cell}: {epochs} epochs were done again"
                );
                kept += epochs;
            }
            for (cell, old) in results {
                assert!(
                    read(&cut, &format!("cells/{cell}/result.json")) == old,
                    "{cell} ran again"
                );
            }
            if let Some(status) = ended {
                assert!(status.success());
                break;
            }
        }
        assert!(kills > 0 && kept > 0, "{kills} kills, {kept} epochs kept");
        assert!(read(&whole, "results.csv") == read(&cut, "results.csv"), "after {kills} kills");
        let events = events(&cut);
        assert_eq!(events.len(), 6);
        for (cell, list) in &events {
            let over: Vec<usize> = (0..list.len()).filter(|i| list[*i] == "over").collect();
            assert_eq!(over, [list.len() - 1], "{cell}: {list:?}");
        }
        // Each kill interrupts at most as many cells as run at a time.
        let jobs = std::thread::available_parallelism().map_or(1, usize::from);
        assert!(count(&events, "began") <= 6 + jobs * kills, "{events:?}");
    }

    /// The gradient of the steps is the same however it is found, and so is what training makes of it.
    #[test]
    #[ignore = "long"]
    fn exact_gradients_train_alike_by_whatever_method() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("g.toml");
        let logs = text(&DATA.1);
        std::fs::write(
            &file,
            format!(
                "[experiment]\nrecordings = [\"{logs}\"]\n[set]\n\"model.hidden\" = [8]\n\"model.activation\" = \
                 \"silu\"\n\"solver.method\" = \"rk4\"\n\"solver.step_ms\" = 10.0\n\"solver.precision\" = \"f64\"\n\
                 \"stage.1.matching\" = {{ steps = 600, batch = 256 }}\n\"stage.2.horizon_s\" = 0.5\n\
                 \"stage.2.epochs\" = 3\n[[axis]]\nkey = \"solver.gradient\"\n\
                 values = [\"adjoint\", \"tape\", \"dual\", \"forward\", \"fd\", \"interpolating\"]\n"
            ),
        )
        .unwrap();
        let out = folder.path().join("run");
        finish(text(&file), &out, &[]);
        let mut reader = csv::Reader::from_path(out.join("results.csv")).unwrap();
        let header = reader.headers().unwrap().clone();
        let column = |name: &str| header.iter().position(|h| h == name).unwrap();
        let (method, loss) = (column("solver.gradient"), column("loss"));
        let losses: Vec<(String, f64)> = reader
            .records()
            .map(|r| r.map(|r| (r[method].to_owned(), r[loss].parse().unwrap())).unwrap())
            .collect();
        assert_eq!(losses.len(), 6);
        let of = |name: &str| losses.iter().find(|(n, _)| n == name).expect("a method").1;
        for (name, value) in &losses {
            // The fast path has the pressures in closed form, the others solve for them too.
            let (to, bound) = match &name[..] {
                "tape" | "dual" | "forward" => ("tape", 1e-6),
                "interpolating" => ("tape", 1e-2),
                _ => ("tape", 1e-3),
            };
            let off = (value / of(to) - 1.0).abs();
            assert!(off < bound, "{name}: {value}, not {}", of(to));
            // Another method did run: its rounding is another.
            assert!(name == "adjoint" || *value != of("adjoint"), "{name}");
        }
    }
}
