//! Runs the notebooks without their kernel: the build script makes one function of each, and this program runs
//! it in a process of its own and reads what its cells print.
//!
//! The outputs are held against those stored in the notebooks: the same kinds, the same words, numbers within 5 %.
//! `cargo test` does so with the first notebook, `cargo test -- --ignored` with the others, `--store` stores all.

use serde_json::{Value, json};
use std::path::PathBuf;
use std::process::{Command, ExitCode};

type Ran = Result<(), Box<dyn std::error::Error>>;

#[allow(clippy::all, unused, missing_docs)]
mod cells {
    pub(super) use super::{Ran, begin};
    include!(concat!(env!("OUT_DIR"), "/notebooks.rs"));
    pub(super) fn all() -> &'static [(&'static str, fn() -> Ran)] {
        NOTEBOOKS
    }
}

/// The notebook that every test run checks; the others take half a minute.
const QUICK: &str = "first_simulation";

/// A line that no cell prints, before the outputs of each.
const MARK: char = '\u{1}';

/// Tells that a cell begins.
fn begin(cell: usize) {
    println!("{MARK}{cell}");
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let result = match arguments.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["--cells", name] => run_cells(name),
        ["--store"] => each(|_| true, true),
        ["--ignored", ..] => each(|name| name != QUICK, false),
        _ => each(|name| name == QUICK, false),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn run_cells(name: &str) -> Ran {
    let (_, run) = cells::all().iter().find(|(n, _)| *n == name).ok_or("no such notebook")?;
    run()
}

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn each(wanted: fn(&str) -> bool, store: bool) -> Ran {
    for (name, _) in cells::all().iter().filter(|(name, _)| wanted(name)) {
        let started = std::time::Instant::now();
        let output = Command::new(std::env::current_exe()?)
            .args(["--cells", name])
            .current_dir(folder())
            .output()?;
        if !output.status.success() {
            return Err(format!("{name}: {}", String::from_utf8_lossy(&output.stderr)).into());
        }
        let path = folder().join(format!("{name}.ipynb"));
        let mut notebook: Value = serde_json::from_str(&std::fs::read_to_string(&path)?)?;
        let printed = String::from_utf8(output.stdout)?;
        for (cell, text) in by_cell(&printed) {
            let outputs = outputs(&text);
            let stored = &mut notebook["cells"][cell];
            if store {
                stored["outputs"] = json!(outputs);
                stored["execution_count"] = json!(cell + 1);
            } else if let Some(difference) = difference(&stored["outputs"], &outputs) {
                return Err(format!(
                    "{name}, cell {cell}: {difference}; `notebooks/run` stores anew"
                )
                .into());
            }
        }
        if store {
            std::fs::write(&path, serde_json::to_string_pretty(&notebook)? + "\n")?;
        }
        println!("{name}: {:.1} s", started.elapsed().as_secs_f64());
    }
    Ok(())
}

/// What each cell printed.
fn by_cell(printed: &str) -> Vec<(usize, String)> {
    printed
        .split(MARK)
        .filter_map(|piece| {
            let (number, text) = piece.split_once('\n')?;
            Some((number.parse().ok()?, text.to_owned()))
        })
        .collect()
}

/// Text and figures in the form of a notebook.
fn outputs(text: &str) -> Vec<Value> {
    let mut all = Vec::new();
    let lines = |text: &str| text.split_inclusive('\n').map(str::to_owned).collect::<Vec<_>>();
    let stream = |text: &str, all: &mut Vec<Value>| {
        if !text.is_empty() {
            all.push(json!({ "name": "stdout", "output_type": "stream", "text": lines(text) }));
        }
    };
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("EVCXR_BEGIN_CONTENT image/svg+xml\n") {
        stream(before, &mut all);
        let (svg, next) = after.split_once("\nEVCXR_END_CONTENT\n").unwrap_or((after, ""));
        let data = json!({ "image/svg+xml": lines(svg) });
        all.push(json!({ "data": data, "metadata": {}, "output_type": "display_data" }));
        rest = next;
    }
    stream(rest, &mut all);
    all
}

/// Kind and text of outputs; figures have no text.
fn words(outputs: &[Value]) -> Vec<String> {
    let mut words = Vec::new();
    for output in outputs {
        match output["text"].as_array() {
            Some(lines) => words.extend(
                lines
                    .iter()
                    .filter_map(Value::as_str)
                    .flat_map(str::split_whitespace)
                    .map(str::to_owned),
            ),
            None => words.push("[figure]".into()),
        }
    }
    words
}

fn difference(stored: &Value, now: &[Value]) -> Option<String> {
    let (was, is) = (words(stored.as_array().map_or(&[], Vec::as_slice)), words(now));
    if was.len() != is.len() {
        return Some(format!("{} words and figures are stored, {} come now", was.len(), is.len()));
    }
    let number =
        |w: &str| w.trim_matches(|c: char| !c.is_ascii_digit() && c != '-').parse::<f64>().ok();
    was.iter().zip(&is).find_map(|(a, b)| {
        let same = match (number(a), number(b)) {
            (Some(x), Some(y)) => (x - y).abs() <= 0.05 * x.abs().max(y.abs()) + 1e-6,
            _ => a == b,
        };
        (!same).then(|| format!("`{a}` is stored, `{b}` comes now"))
    })
}
