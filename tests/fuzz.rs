//! Runs mutated inputs through every reader and every settings file, and counts what became of them.
//!
//! ```sh
//! cargo run --release -p pam-tests --features studies --example fuzz -- --inputs 1000000 --out results/hardening/fuzz.json
//! cargo run --release -p pam-tests --features studies --example fuzz -- --seconds 20
//! ```
//!
//! Inputs are run in processes of their own with little memory, so that one that aborts or never ends is counted, too. The
//! exit code is 1 if any input panics, aborts, hangs, or is refused without the name of its file.

use clap::Parser;
use pam_tests::fuzz::{self, Counts, LONGEST, Stopwatch, targets::TARGETS};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

#[derive(Parser)]
struct Arguments {
    /// Time to run, s
    #[arg(long, default_value_t = 20)]
    seconds: u64,
    /// Run so many inputs, rounded up to whole processes, instead of a time
    #[arg(long)]
    inputs: Option<u64>,
    /// Number of the first input
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Where the counts go
    #[arg(long)]
    out: Option<PathBuf>,
    /// Processes at the same time
    #[arg(long, default_value_t = 2)]
    jobs: u64,
    /// Run this one input, and say what becomes of it
    #[arg(long)]
    only: Option<u64>,
    /// Run so many inputs in this process, which the program asks itself for
    #[arg(long, hide = true)]
    count: Option<u64>,
}

/// Inputs of one process.
const CHUNK: u64 = 2000;
/// Address space of a process, KiB.
const MEMORY_KIB: u64 = 2 << 20;
/// Exit code of a process in which an input took too long.
const HUNG: i32 = 99;

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    if let Some(number) = arguments.only {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let case = fuzz::Case::of(number);
        println!("{}: {:?}", case.target.name, case.run(folder.path()));
        return ExitCode::SUCCESS;
    }
    match arguments.count {
        Some(count) => child(arguments.first, count),
        None => parent(&arguments),
    }
}

/// Runs inputs, tells each number before it runs on the error stream if it takes long, and the counts at the end.
fn child(first: u64, count: u64) -> ExitCode {
    static RUNNING: AtomicU64 = AtomicU64::new(u64::MAX);
    std::panic::set_hook(Box::new(|_| {}));
    std::thread::spawn(|| {
        let mut last = (u64::MAX, Stopwatch::start());
        loop {
            std::thread::sleep(Duration::from_millis(200));
            let now = RUNNING.load(Ordering::Relaxed);
            if now != last.0 {
                last = (now, Stopwatch::start());
            } else if last.1.elapsed() > LONGEST {
                println!("{}", json!({ "hung": now }));
                std::process::exit(HUNG);
            }
        }
    });
    let folder = tempfile::tempdir().expect("a temporary folder");
    let progress = std::env::var_os("PAM_FUZZ_PROGRESS").map(PathBuf::from);
    let counts = fuzz::run(first..first + count, folder.path(), |number| {
        RUNNING.store(number, Ordering::Relaxed);
        if let Some(path) = &progress {
            let _ = std::fs::write(path, number.to_string());
        }
        true
    });
    println!("{}", to_json(&counts));
    ExitCode::SUCCESS
}

fn to_json(counts: &Counts) -> Value {
    json!({
        "by_target": counts.by_target,
        "unsound": counts.unsound.iter().map(|(number, target, ending)| {
            json!({ "number": number, "target": target, "ending": format!("{ending:?}") })
        }).collect::<Vec<_>>(),
        "longest_s": counts.longest.as_secs_f64(),
        "peak_mib": peak_mib(),
    })
}

/// Largest memory of this process so far.
fn peak_mib() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kib| kib / 1024)
}

#[derive(Default)]
struct Totals {
    by_target: std::collections::BTreeMap<String, [u64; 2]>,
    unsound: Vec<Value>,
    peak_mib: u64,
    longest_s: f64,
}

impl Totals {
    fn add(&mut self, found: &Value) {
        for (name, counts) in found["by_target"].as_object().into_iter().flatten() {
            let sum = self.by_target.entry(name.clone()).or_default();
            (0..2).for_each(|k| sum[k] += counts[k].as_u64().unwrap_or(0));
        }
        self.unsound.extend(found["unsound"].as_array().into_iter().flatten().cloned());
        self.longest_s = self.longest_s.max(found["longest_s"].as_f64().unwrap_or(0.0));
        self.peak_mib = self.peak_mib.max(found["peak_mib"].as_u64().unwrap_or(0));
    }
}

fn parent(arguments: &Arguments) -> ExitCode {
    let begun = Instant::now();
    let next = AtomicU64::new(arguments.first);
    let totals = std::sync::Mutex::new(Totals::default());
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::thread::scope(|scope| {
        for job in 0..arguments.jobs {
            let (next, totals, folder) = (&next, &totals, folder.path());
            scope.spawn(move || {
                loop {
                    let first = next.fetch_add(CHUNK, Ordering::Relaxed);
                    let done = match arguments.inputs {
                        Some(inputs) => first - arguments.first >= inputs,
                        None => begun.elapsed() >= Duration::from_secs(arguments.seconds),
                    };
                    if done {
                        break;
                    }
                    chunk(first, job, folder, &mut |found| {
                        totals.lock().expect("no job panics").add(&found);
                    });
                }
            });
        }
    });
    let totals = totals.into_inner().expect("no job panics");
    let sound: u64 = totals.by_target.values().flatten().sum();
    let length = match arguments.inputs {
        Some(inputs) => format!("--inputs {inputs}"),
        None => format!("--seconds {}", arguments.seconds),
    };
    let value = json!({
        "command": format!("cargo run --release -p pam-tests --features studies --example fuzz -- {length} --first {}", arguments.first),
        "inputs": sound + totals.unsound.len() as u64,
        "targets": TARGETS.len(),
        "read_and_refused_by_target": totals.by_target,
        "unsound": totals.unsound,
        "longest_s": totals.longest_s,
        "largest_memory_mib": totals.peak_mib,
        "longest_allowed_s": LONGEST.as_secs(),
        "address_space_mib": MEMORY_KIB >> 10,
        "seconds": begun.elapsed().as_secs(),
    });
    let text = format!("{value:#}\n");
    print!("{text}");
    if let Some(path) = &arguments.out {
        pam_data::atomic::write_atomic(path, text.as_bytes()).expect("the counts can be written");
    }
    if totals.unsound.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// Runs a chunk in a process; after an abort or a hang another one goes on behind it.
fn chunk(first: u64, job: u64, folder: &Path, found: &mut dyn FnMut(Value)) {
    let end = first + CHUNK;
    let mut from = first;
    let progress = folder.join(format!("progress-{job}"));
    while from < end {
        let code = match process(from, end - from, &progress) {
            Ok(value) => return found(value),
            Err(code) => code,
        };
        let number = std::fs::read_to_string(&progress).ok().and_then(|t| t.parse().ok());
        let number: u64 = number.unwrap_or(from).max(from);
        // The counts of the inputs before are lost with the process: they are run again.
        if number > from
            && let Ok(again) = process(from, number - from, &progress)
        {
            found(again);
        }
        let how = if code == Some(HUNG) { "Hung" } else { "Aborted" };
        found(json!({ "unsound": [{
            "number": number,
            "target": fuzz::Case::of(number).target.name,
            "ending": how,
        }] }));
        from = number + 1;
    }
}

/// Runs so many inputs in a process with little memory: the counts, or the exit code of one that did not end well.
fn process(first: u64, count: u64, progress: &Path) -> Result<Value, Option<i32>> {
    let program = std::env::current_exe().expect("the program has a path");
    // The shell sets the limit of the address space.
    let output = Command::new("sh")
        .args([
            "-c",
            &format!("ulimit -v {MEMORY_KIB}; exec \"$0\" --first {first} --count {count}"),
        ])
        .arg(program)
        .env("PAM_FUZZ_PROGRESS", progress)
        .env("RAYON_NUM_THREADS", "1")
        .output()
        .expect("a process can be started");
    let last = String::from_utf8_lossy(&output.stdout).lines().last().map(str::to_owned);
    let value = last.and_then(|line| serde_json::from_str(&line).ok());
    value.filter(|_| output.status.success()).ok_or(output.status.code())
}
