//! `results`: measures studies again and writes their numbers into README, book and changelog.

use clap::Parser;
use pam_bench::results::{Results, ResultsError, measure::measure, page};
use pam_data::DataError;
use pam_data::atomic::write_atomic;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Numbers and tables of README, book and changelog from the files of results/.
#[derive(Debug, Parser)]
#[command(
    name = "results",
    version,
    after_help = "Exit codes: 0 success, 1 error or a page that differs, 2 wrong usage."
)]
struct Arguments {
    /// Studies to measure again with their commands (minutes to hours): `peers` is results/peers.json
    names: Vec<String>,
    /// Write the numbers into the pages; without it, pages that differ are listed
    #[arg(long)]
    write: bool,
    /// List studies with date, commit and commands
    #[arg(long)]
    list: bool,
    /// Root of the repository
    #[arg(long, value_name = "DIR", default_value = ".")]
    root: PathBuf,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(1)
        }
    }
}

fn run(arguments: &Arguments) -> Result<bool, ResultsError> {
    let folder = arguments.root.join("results");
    let mut results = Results::read(&folder)?;
    if arguments.list {
        for (name, study) in &results.studies {
            println!("{name}: {} ({}, {})", study.title, study.date, study.commit);
            study.commands.iter().for_each(|command| println!("    {command}"));
        }
        return Ok(true);
    }
    for name in &arguments.names {
        let study = results.studies.get(name).ok_or_else(|| ResultsError::Unknown {
            name: name.clone(),
            hint: "`--list` shows the studies".into(),
        })?;
        let (measured, untouched) = measure(study, &arguments.root)?;
        measured.write(&folder.join(format!("{name}.json")))?;
        if !untouched.is_empty() {
            println!("{name}: no command writes {}; they are as before", untouched.join(", "));
        }
        results.studies.insert(name.clone(), measured);
    }
    let mut same = true;
    for path in page::pages(&arguments.root)? {
        same &= update(&path, &results, arguments.write)?;
    }
    Ok(same)
}

/// Compares the page with the results, or writes it; `true` if it is up to date afterwards.
fn update(path: &Path, results: &Results, write: bool) -> Result<bool, ResultsError> {
    let text = std::fs::read_to_string(path).map_err(|e| DataError::io(path, e))?;
    let filled = page::fill(&text, results).map_err(|e| DataError::file(path, e.to_string()))?;
    if text == filled {
        return Ok(true);
    }
    if write {
        write_atomic(path, filled.as_bytes())?;
        println!("{}: written", path.display());
    } else {
        println!("{}: differs from results/; `results --write` writes it again", path.display());
    }
    Ok(write)
}
