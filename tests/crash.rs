//! Ends every command that writes at random moments and in hostile surroundings, and checks that nothing is lost.
//!
//! ```sh
//! cargo build --release
//! cargo run --release -p pam-tests --features studies --example crash -- --rounds 10 --out results/hardening/crash.json
//! ```
//!
//! Each command runs once undisturbed. Then, in each round, it is ended by SIGKILL, SIGTERM or SIGINT at a random moment
//! and run again (with `--resume` where it has one): it must end well, its results must be those of the undisturbed run
//! to the bit, and no temporary file or lock may be left. Besides, two processes write to one place at the same time, the
//! disk is full after a kilobyte, the place cannot be written at all, and the standard output cannot be written.

use clap::Parser;
use pam_tests::{small_csv, text};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, ExitStatus, Output, Stdio};
use std::time::{Duration, Instant};

#[derive(Parser)]
struct Arguments {
    /// The program
    #[arg(long, default_value = "target/release/pam")]
    program: PathBuf,
    /// Rounds of each signal for each command
    #[arg(long, default_value_t = 1)]
    rounds: u32,
    /// Where the counts go
    #[arg(long)]
    out: Option<PathBuf>,
    /// Seed of the moments
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Only these commands, separated by commas
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
    /// Also the commands that take half a minute each time
    #[arg(long)]
    long: bool,
}

/// A command that writes.
struct Job {
    name: &'static str,
    arguments: Vec<String>,
    /// Files of the output that repeat to the bit; the output itself if it is a file.
    repeats: &'static [&'static str],
    /// What goes on with an interrupted run; the same command if empty.
    resume: &'static str,
    /// Exists once there is something to resume.
    resumable: &'static str,
    /// Several processes may work in one folder.
    shared: bool,
    /// It takes half a minute.
    long: bool,
}

const CURRICULUM: &str = "name = \"short\"\n[model]\nhidden = [16]\n[[stage]]\nkind = \"gas\"\nname = \"gas\"\n\
    [[stage]]\nkind = \"derivatives\"\nname = \"derivatives\"\nmatching = { steps = 100, mass_steps = 100, batch = 64 }\n\
    [[stage]]\nkind = \"solve\"\nname = \"whole\"\nepochs = 20\n";

/// The commands with their inputs in a folder; `OUT` stands for the output.
fn jobs(folder: &Path) -> Vec<Job> {
    let file = |name: &str, content: &str| {
        std::fs::write(folder.join(name), content).expect("an input can be written");
        text(&folder.join(name)).to_owned()
    };
    let logs = folder.join("logs");
    std::fs::create_dir_all(&logs).expect("a folder can be made");
    file("logs/a.csv", &small_csv(6000));
    file("logs/b.csv", &small_csv(5000));
    let (logs, data) = (text(&logs).to_owned(), text(&folder.join("logs/a.csv")).to_owned());
    let pulses = file("pulses.csv", &pulses());
    let curriculum = file("short.toml", CURRICULUM);
    let protocol = file(
        "protocol.toml",
        "name = \"p\"\nconditions = [[45, 45], [30, 60], [60, 30], [50, 50]]\n[[current]]\nkind = \"sine\"\n\
         amplitude_a = 1.0\nfrequency_hz = 1.0\nduration_s = 2.0\n",
    );
    let comparison = file(
        "comparison.toml",
        &format!(
            "name = \"c\"\n[data]\nrecordings = [{logs:?}]\ntrain = [\"a\"]\nheld_out = [\"b\"]\n\
             [[model]]\nname = \"A+\"\nkind = \"spring_damper\"\n[[model]]\nname = \"A-\"\nkind = \"koopman\"\n"
        ),
    );
    let sweep = file(
        "sweep.toml",
        &format!(
            "name = \"s\"\nseeds = 2\n[experiment]\nrecordings = [{logs:?}]\ncurriculum = {curriculum:?}\n\
             [[axis]]\nkey = \"model.activation\"\nvalues = [\"silu\", \"tanh\"]\n"
        ),
    );
    let job = |name, line: &str, repeats| Job {
        name,
        arguments: line
            .split(' ')
            .map(|part| match part {
                "LOGS" => logs.clone(),
                "DATA" => data.clone(),
                "PULSES" => pulses.clone(),
                "CURRICULUM" => curriculum.clone(),
                "PROTOCOL" => protocol.clone(),
                "COMPARISON" => comparison.clone(),
                "SWEEP" => sweep.clone(),
                other => other.to_owned(),
            })
            .collect(),
        repeats,
        resume: "",
        resumable: "",
        shared: false,
        long: false,
    };
    vec![
        job(
            "evaluate",
            "evaluate --accept --data LOGS --out OUT",
            &["evaluation.json", "predictions/a.csv", "run.json"],
        ),
        job("simulate", "simulate --force sine:A=60,f=1 --duration 20 --out OUT.csv", &[""]),
        job("gradient", "gradient --accept --data LOGS --out OUT.npz", &[]),
        job("convert", "convert DATA OUT.npz", &[""]),
        job(
            "stiffness",
            "stiffness --out OUT",
            &["map.csv", "range.csv", "stiffness.json", "run.json"],
        ),
        job(
            "plan",
            "plan --motion sine:A=1,f=0.5 --stiffness 150 --out OUT",
            &["table.csv", "table.bin", "plan.json", "run.json"],
        ),
        job("inspect", "inspect DATA --out OUT", &["report.html"]),
        job(
            "diagnose",
            "diagnose --accept --no-law --effects constant_load --data LOGS --out OUT",
            &["diagnosis.json", "report.html", "model.safetensors"],
        ),
        job(
            "identify",
            "identify --accept --data PULSES --out OUT",
            &["pulses.csv", "identify.json"],
        ),
        job(
            "track",
            "track --shapes triangle --series frequency --out OUT",
            &["tracking.csv", "tracking.json"],
        ),
        job(
            "replan",
            "replan --motion sine:A=0.5,f=0.5,duration=2 --load-at 1 --out OUT",
            // The other file holds the times of the decisions.
            &["replan.csv"],
        ),
        job("rig-file init", "rig-file init DATA --force --out OUT.toml", &[""]),
        job("man", "man --out OUT", &["pam.1", "pam-train.1"]),
        Job {
            long: true,
            ..job("demo", "demo --out OUT", &["diagnosis.json", "model.safetensors"])
        },
        job(
            "rig record",
            "rig record --protocol PROTOCOL --out OUT",
            &["nn_4545", "nn_5050.truth.npz", "truth.json"],
        ),
        Job {
            resume: "--resume",
            resumable: "checkpoint.json",
            ..job(
                "train",
                "train CURRICULUM --accept --checkpoint-s 0 --data LOGS --out OUT",
                &["model.safetensors"],
            )
        },
        Job {
            resume: "--resume",
            ..job(
                "compare",
                "compare COMPARISON --accept --out OUT",
                &["table.csv", "comparison.json", "models/a.npz", "models/a-2.npz"],
            )
        },
        Job {
            shared: true,
            ..job(
                "ablate",
                "ablate SWEEP --checkpoint-s 0 --out OUT",
                &["results.csv", "sweep.json"],
            )
        },
    ]
}

/// A mass on a spring with a damper, pushed by 90 N for 30 ms every second.
fn pulses() -> String {
    const STEP_S: f64 = 1e-4;
    let (mut x, mut v) = (0.0, 0.0);
    let mut out = String::from(
        "# mass_flexor_g = 0.0765\n# mass_extensor_g = 0.0763\n\
         time_s,displacement_mm,velocity_mm_s,pressure_flexor_kpa,pressure_extensor_kpa,force_n\n",
    );
    for k in 0..4000 {
        let t = 1e-3 * f64::from(k);
        let force_n = if (0.5..0.53).contains(&(t % 1.0)) { 90.0 } else { 0.0 };
        for _ in 0..10 {
            // N, mm and s: 304.6 kg, 150 N/mm, 1500 kg/s.
            v += (force_n - 150.0 * x - 1.5 * v) / 0.3046 * STEP_S;
            x += v * STEP_S;
        }
        out += &format!("{t},{x},{v},{},{},{force_n}\n", 412.0 - 13.0 * x, 412.0 + 13.0 * x);
    }
    out
}

impl Job {
    /// The output under a path without extension.
    fn output(&self, out: &Path) -> PathBuf {
        let file = self.arguments.iter().find(|a| a.starts_with("OUT")).expect("every job writes");
        PathBuf::from(file.replace("OUT", text(out)))
    }

    fn command(&self, program: &Path, out: &Path) -> Command {
        let mut command = Command::new(program);
        for argument in &self.arguments {
            if argument.starts_with("OUT") {
                command.arg(self.output(out));
            } else {
                command.arg(argument);
            }
        }
        if !self.resume.is_empty()
            && (self.resumable.is_empty() || out.join(self.resumable).exists())
        {
            command.arg(self.resume);
        }
        command.args(["--quiet", "--threads", "1"]).stdout(Stdio::null()).stderr(Stdio::piped());
        command
    }

    /// The files that repeat; the paths are those of the output in no result.
    fn results(&self, out: &Path) -> Vec<Option<Vec<u8>>> {
        let output = self.output(out);
        let path = |name: &&str| if name.is_empty() { output.clone() } else { output.join(name) };
        self.repeats.iter().map(|name| std::fs::read(path(name)).ok()).collect()
    }
}

/// Temporary files and locks below a folder.
fn leftovers(folder: &Path) -> usize {
    let Ok(entries) = std::fs::read_dir(folder) else { return 0 };
    entries
        .flatten()
        .map(|entry| match entry.file_type() {
            Ok(kind) if kind.is_dir() => leftovers(&entry.path()),
            _ => {
                usize::from(entry.file_name().to_string_lossy().starts_with(".pam-"))
                    + usize::from(entry.file_name().to_string_lossy().starts_with(".lock-pam"))
            }
        })
        .sum()
}

/// What was tried and what went wrong.
#[derive(Default)]
struct Tally {
    tried: BTreeMap<String, u32>,
    wrong: Vec<String>,
}

impl Tally {
    fn check(&mut self, what: &str, job: &Job, sound: bool, why: impl FnOnce() -> String) {
        *self.tried.entry(format!("{}, {what}", job.name)).or_default() += 1;
        if !sound {
            self.wrong.push(format!("{}, {what}: {}", job.name, why()));
        }
    }
}

/// Status and error stream of a command; its standard output goes where the command says.
fn finish(mut command: Command) -> (ExitStatus, String) {
    let child = command.spawn().expect("the program starts");
    let output = child.wait_with_output().expect("the program ends");
    (output.status, String::from_utf8_lossy(&output.stderr).into_owned())
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let program = std::path::absolute(&arguments.program).expect("the program has a path");
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mut random = ChaCha8Rng::seed_from_u64(arguments.seed);
    let mut tally = Tally::default();
    let begun = Instant::now();
    let wanted = |job: &Job| {
        let named = arguments.only.is_empty() || arguments.only.iter().any(|n| n == job.name);
        named && (arguments.long || !job.long || !arguments.only.is_empty())
    };
    for job in jobs(folder.path()).into_iter().filter(wanted) {
        let whole = folder.path().join(format!("whole {}", job.name));
        let start = Instant::now();
        let (status, errors) = finish(job.command(&program, &whole));
        let length = start.elapsed();
        if errors.contains("feature") && !status.success() {
            eprintln!("{}: not in this program: {}", job.name, errors.trim());
            continue;
        }
        tally.check("undisturbed", &job, status.success(), || errors.clone());
        if !status.success() {
            continue;
        }
        let expected = job.results(&whole);
        for round in 0..arguments.rounds {
            for signal in ["KILL", "TERM", "INT"] {
                let out = folder.path().join(format!("{} {round} {signal}", job.name));
                let share = random.random::<f64>();
                ended(&job, &program, &out, signal, length.mul_f64(share), &expected, &mut tally);
            }
            two_writers(
                &job,
                &program,
                &folder.path().join(format!("{} {round} two", job.name)),
                &expected,
                &mut tally,
            );
        }
        surroundings(&job, &program, folder.path(), &mut tally);
    }
    let value: Value = json!({
        "command": format!("cargo run --release -p pam-tests --features studies --example crash -- --rounds {} --seed {}", arguments.rounds, arguments.seed),
        "tried": tally.tried,
        "wrong": tally.wrong,
        "seconds": begun.elapsed().as_secs(),
    });
    let printed = format!("{value:#}\n");
    print!("{printed}");
    if let Some(path) = &arguments.out {
        pam_data::atomic::write_atomic(path, printed.as_bytes())
            .expect("the counts can be written");
    }
    if tally.wrong.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Ended by a signal after a time, then run again.
fn ended(
    job: &Job,
    program: &Path,
    out: &Path,
    signal: &str,
    after: Duration,
    expected: &[Option<Vec<u8>>],
    tally: &mut Tally,
) {
    let mut child = job.command(program, out).spawn().expect("the program starts");
    std::thread::sleep(after);
    let _ = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status();
    let _ = child.wait();
    // A file is whole or absent.
    let partial =
        job.results(out).iter().zip(expected).any(|(now, then)| {
            job.resume.is_empty() && !job.shared && now.is_some() && now != then
        });
    tally.check(signal, job, !partial, || {
        "a file of the ended run is not that of a whole one".into()
    });
    let (status, errors) = finish(job.command(program, out));
    let same = job.results(out) == expected;
    let left = leftovers(out);
    tally.check(&format!("after {signal}"), job, status.success() && same && left == 0, || {
        format!("exit {:?}, same results: {same}, leftovers: {left}; {errors}", status.code())
    });
}

/// Two processes write to one place: at least one ends well, the other well or with an error that says why.
fn two_writers(
    job: &Job,
    program: &Path,
    out: &Path,
    expected: &[Option<Vec<u8>>],
    tally: &mut Tally,
) {
    let [mut first, mut second] = [(); 2].map(|()| job.command(program, out));
    let (first, second) =
        (first.spawn().expect("the program starts"), second.spawn().expect("the program starts"));
    let outputs = [first, second].map(|child| child.wait_with_output().expect("the program ends"));
    // Of a shared folder, a process ends with 3 if the other still runs cells.
    let ended_well = |o: &&Output| o.status.success() || (job.shared && o.status.code() == Some(3));
    let well = outputs.iter().filter(ended_well).count();
    let told = outputs.iter().filter(|o| !ended_well(o)).all(|o| {
        let text = String::from_utf8_lossy(&o.stderr).into_owned();
        ["another program", "holds a run"].iter().any(|part| text.contains(part))
    });
    let same = job.results(out) == expected;
    tally.check("two writers", job, well > 0 && told && same, || {
        let errors: String =
            outputs.iter().map(|o| String::from_utf8_lossy(&o.stderr).into_owned()).collect();
        format!("{well} ended well, same results: {same}; {errors}")
    });
}

/// A disk that is full after a kilobyte, and a place that cannot be written.
fn surroundings(job: &Job, program: &Path, folder: &Path, tally: &mut Tally) {
    let out = folder.join(format!("{} full", job.name));
    let command = job.command(program, &out);
    // Writing past the limit is an error instead of a signal.
    let mut limited = Command::new("sh");
    limited
        .args(["-c", "trap '' XFSZ; ulimit -f 1; exec \"$0\" \"$@\""])
        .arg(program)
        .args(command.get_args());
    limited.stdout(Stdio::null()).stderr(Stdio::piped());
    let (status, errors) = finish(limited);
    let told = status.code().is_some_and(|code| code != 0) && errors.contains("error");
    tally.check("full disk", job, told && !errors.contains("panicked"), || {
        format!("exit {:?}: {errors}", status.code())
    });
    let blocker = folder.join("blocker");
    let _ = std::fs::write(&blocker, "x");
    let (status, errors) = finish(job.command(program, &blocker.join("out")));
    tally.check("unwritable", job, status.code() == Some(1) && errors.contains("blocker"), || {
        format!("exit {:?}: {errors}", status.code())
    });
    // What a command says is a result like its files.
    if let Ok(full) = std::fs::OpenOptions::new().write(true).open("/dev/full") {
        let out = folder.join(format!("{} said", job.name));
        let mut command = job.command(program, &out);
        command.arg("--json").stdout(full);
        let (status, errors) = finish(command);
        let told = status.code() == Some(1) && errors.contains("standard output");
        tally.check("standard output on a full device", job, told, || {
            format!("exit {:?}: {errors}", status.code())
        });
    }
}
