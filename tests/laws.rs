//! Study of the search for laws.
//!
//! ```sh
//! cargo build --release -p pam-tests --example laws --config 'profile.release.package.pam-tests.opt-level=3'
//! target/release/examples/laws run            # resumable; into results/laws
//! target/release/examples/laws run --only cubic
//! target/release/examples/laws tables         # criteria and tables, into results/laws
//! ```

use clap::{Parser, Subcommand};
use pam_data::atomic::write_atomic;
use pam_tests::laws::{LawOutcome, laws, nulls, run_law, run_null};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Number of null sets.
const NULLS: usize = 40;

#[derive(Parser)]
#[command(about = "Study of the search for laws: laws that stand in no list, and null sets")]
struct Arguments {
    #[command(subcommand)]
    command: Action,
}

#[derive(Subcommand)]
enum Action {
    /// Run cases that have no outcome yet.
    Run {
        /// Cases whose id contains this.
        #[arg(long, default_value = "")]
        only: String,
        /// Seeds of the noise of the laws, from 1 on.
        #[arg(long, default_value_t = 1)]
        seeds: u64,
        /// Folder of the outcomes.
        #[arg(long, default_value = "results/laws")]
        out: PathBuf,
    },
    /// Print and write the tables.
    Tables {
        /// Folder of the outcomes.
        #[arg(default_value = "results/laws")]
        folder: PathBuf,
    },
}

fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Action::Run { only, seeds, out } => run(&only, seeds, &out),
        Action::Tables { folder } => tables(&folder),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}

fn run(only: &str, seeds: u64, out: &Path) -> Result<(), String> {
    let store = |id: &str, outcome: &dyn Fn() -> LawOutcome| -> Result<(), String> {
        let path = out.join(format!("{id}.json"));
        if !id.contains(only) || path.exists() {
            return Ok(());
        }
        let outcome = outcome();
        println!("{}", line(&outcome));
        let text = serde_json::to_string(&outcome).map_err(|e| e.to_string())?;
        write_atomic(&path, format!("{text}\n").as_bytes()).map_err(|e| e.to_string())
    };
    for seed in 1..=seeds {
        for law in laws() {
            store(&format!("{}-{seed}", law.id), &|| run_law(&law, seed))?;
        }
    }
    for case in nulls(NULLS) {
        store(&case.id, &|| run_null(&case))?;
    }
    Ok(())
}

fn line(o: &LawOutcome) -> String {
    let law = o.law.as_deref().unwrap_or("no law");
    let reached =
        o.reached().map_or(String::new(), |r| format!(", {:.1} % of the law's own", 100.0 * r));
    format!(
        "{:<24} {} -> {}: {law}{reached}; CPU {:.0} + {:.0} s",
        o.id, o.diagnosis, o.verdict, o.cpu_s[0], o.cpu_s[1]
    )
}

fn tables(folder: &Path) -> Result<(), String> {
    let told = |e: std::io::Error| format!("{}: {e}", folder.display());
    let mut paths: Vec<PathBuf> =
        std::fs::read_dir(folder).map_err(told)?.flatten().map(|e| e.path()).collect();
    paths.retain(|p| p.extension().is_some_and(|e| e == "json"));
    paths.sort();
    let read = |p: &PathBuf| -> Result<LawOutcome, String> {
        let text = std::fs::read_to_string(p).map_err(told)?;
        serde_json::from_str(&text).map_err(|e| format!("{}: {e}", p.display()))
    };
    let all: Vec<LawOutcome> = paths.iter().map(read).collect::<Result<_, _>>()?;
    let (hidden, nulls): (Vec<_>, Vec<_>) = all.iter().partition(|o| o.hidden);
    let found = hidden.iter().filter(|o| o.is_found()).count();
    let wrongly = hidden.iter().filter(|o| o.verdict == "explained").count();
    let laws = nulls.iter().filter(|o| o.law.is_some() || o.outcome == "correction").count();
    let slowest =
        |of: &dyn Fn(&LawOutcome) -> f64| hidden.iter().map(|o| of(o)).fold(0.0, f64::max);
    let mut csv = String::from("criterion,k,n,required\n");
    let mut row = |criterion: &str, k: usize, n: usize, required: &str| {
        let _ = writeln!(csv, "{criterion},{k},{n},{required}");
    };
    let eight = format!("at least {:.0}", 0.8 * hidden.len() as f64);
    row(
        "laws found with the right variables and 80 % of their own error reduction",
        found,
        hidden.len(),
        &eight,
    );
    row("laws called explained by listed causes", wrongly, hidden.len(), "0");
    row("null sets with a law or a correction", laws, nulls.len(), "0");
    let mut cases = String::from(
        "case,diagnosis,verdict,law,numbers,depends on,found,share of the law's own error reduction,CPU of the remainder (s)\n",
    );
    for o in &hidden {
        let numbers: Vec<String> = o
            .parameters
            .iter()
            .map(|(n, [v, low, high])| format!("{n} = {v:.5} [{low:.5} {high:.5}]"))
            .collect();
        let depends: Vec<String> = o
            .depends_on
            .iter()
            .filter(|d| d.1 > 1.05)
            .map(|(n, r)| format!("{n} {r:.1}"))
            .collect();
        let _ = writeln!(
            cases,
            "{},{},{},\"{}\",\"{}\",\"{}\",{},{:.3},{:.0}",
            o.id,
            o.diagnosis,
            o.verdict,
            o.law.as_deref().unwrap_or(""),
            numbers.join("; "),
            depends.join("; "),
            if o.is_found() { "yes" } else { "no" },
            o.reached().unwrap_or(0.0),
            o.cpu_s[1]
        );
    }
    print!("{csv}\n{cases}");
    println!(
        "slowest remainder: {:.0} s of CPU, {:.0} s",
        slowest(&|o| o.cpu_s[1]),
        slowest(&|o| o.wall_s)
    );
    let write = |name: &str, text: &str| {
        write_atomic(folder.join(name), text.as_bytes()).map_err(|e| e.to_string())
    };
    write("criteria.csv", &csv)?;
    write("cases.csv", &cases)
}
