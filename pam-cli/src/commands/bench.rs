//! `pam bench`.

use crate::arguments::{BenchCommand, BenchGradientsArguments, GlobalOptions};
use crate::console::{Console, table};
use crate::error::CliError;
use crate::run_record::{self, made_by};
use pam_bench::gradients::{StudyResult, findings, output, parts};
use pam_core::{AnyForce, JointModel, NetworkForce};
use pam_data::load_model;
use serde_json::{Value, json};
use std::path::Path;
use std::process::ExitCode;

/// Runs the command.
///
/// # Errors
/// [`CliError`] naming the option, or the file that cannot be written.
pub fn run(
    command: &BenchCommand,
    global: &GlobalOptions,
    console: &Console,
) -> Result<ExitCode, CliError> {
    match command {
        BenchCommand::Gradients(arguments) => gradients(arguments, global, console),
    }
}

fn gradients(
    arguments: &BenchGradientsArguments,
    global: &GlobalOptions,
    console: &Console,
) -> Result<ExitCode, CliError> {
    let study = if arguments.quick { parts::quick() } else { parts::full() };
    let study = match &arguments.model {
        Some(path) => parts::with_model(study, network(path)?),
        None => study,
    };
    let study = study
        .with_problems(&arguments.problems)?
        .with_methods(&arguments.methods)?
        .with_repeat(arguments.repeat as usize);
    if study.is_empty() {
        return Err(CliError::Usage(
            "no problem of --problems is solved with a method of --methods".into(),
        ));
    }
    let bar = console.progress(study.len(), "differentiating");
    let result = study.run(|_| bar.inc(1));
    bar.finish_and_clear();
    output::write(&arguments.out, &result, &made_by())?;
    let configuration = json!({
        "quick": arguments.quick,
        "methods": arguments.methods,
        "problems": arguments.problems,
        "model": arguments.model,
        "repeat": arguments.repeat,
    });
    run_record::write(&arguments.out, "bench gradients", global.seed, &configuration)?;
    console.json(&serde_json::to_value(&result).unwrap_or(Value::Null));
    console.text(summary(&result, arguments));
    Ok(ExitCode::SUCCESS)
}

/// The model of a file whose force is a network.
fn network(path: &Path) -> Result<JointModel<f64, NetworkForce<f64>>, CliError> {
    let saved = load_model(path)?;
    if !saved.info.effects.is_empty() {
        return Err(CliError::Usage(format!(
            "--model {} is extended by effects; `pam convert --plain` makes a plain one of it",
            path.display()
        )));
    }
    let model = saved.model;
    match &model.force {
        AnyForce::Network(force) => Ok(model.map(|v| v, |_| force.clone())),
        _ => Err(CliError::Usage(format!("--model {} holds no network", path.display()))),
    }
}

fn summary(result: &StudyResult, arguments: &BenchGradientsArguments) -> String {
    let mut text = output::about(result) + "\n";
    for finding in findings::findings(result) {
        text += &format!("\n- {finding}");
    }
    let files = ["report.html", "table.md", "gradients.csv", "gradients.json"];
    let rows: Vec<Vec<String>> =
        files.iter().map(|name| vec![arguments.out.join(name).display().to_string()]).collect();
    text + "\n\n" + &table(&rows)
}
