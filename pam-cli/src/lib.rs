//! The `pam` command, as a library: argument types and thin commands over the other crates.
//!
//! Exit codes: 0 for success, 1 for an error in input, model or output, 2 for wrong usage, 3 when
//! the command finished but some recordings, samples or cells failed, 130 when it was interrupted and
//! can be resumed.

pub mod arguments;
pub mod commands;
pub mod console;
pub mod demo;
pub mod error;
pub mod options;
pub mod rig_joint;
pub mod run_record;

pub use arguments::{Arguments, Command};
pub use console::Console;
pub use error::CliError;

use std::process::ExitCode;

/// Exit code for an error in input, model or output.
pub const FAILED: u8 = 1;

/// Exit code for wrong usage, the same as for arguments that cannot be parsed.
pub const USAGE: u8 = 2;

/// Exit code when some recordings could not be predicted to their end.
pub const PARTIAL: u8 = 3;

/// Exit code when a signal asked to stop, and what was reached is saved.
pub const INTERRUPTED: u8 = 130;

/// Runs a command line and reports its errors on the error stream.
#[must_use]
pub fn run(arguments: Arguments) -> ExitCode {
    match dispatch(&arguments) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(if error.is_usage() { USAGE } else { FAILED })
        }
    }
}

fn dispatch(arguments: &Arguments) -> Result<ExitCode, CliError> {
    let global = &arguments.global;
    if let Some(threads) = global.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build_global()
            .map_err(|e| CliError::Usage(format!("--threads {threads}: {e}")))?;
    }
    let console = Console::new(global);
    match &arguments.command {
        None => demo::run(&arguments::DemoArguments::default(), global, &console),
        Some(Command::Demo(a)) => demo::run(a, global, &console),
        Some(Command::Inspect(a)) => commands::inspect::run(a, &console),
        Some(Command::Convert(a)) => commands::convert::run(a, &console),
        Some(Command::Simulate(a)) => commands::simulate::run(a, global, &console),
        Some(Command::Gradient(a)) => commands::gradient::run(a, global, &console),
        Some(Command::Train(a)) => commands::train::run(a, global, &console),
        Some(Command::Diagnose(a)) => commands::diagnose::run(a, global, &console),
        Some(Command::Stiffness(a)) => commands::control::stiffness::run(a, global, &console),
        Some(Command::Plan(a)) => commands::control::plan::run(a, global, &console),
        Some(Command::Track(a)) => commands::control::track::run(a, global, &console),
        Some(Command::Identify(a)) => commands::control::identify::run(a, global, &console),
        Some(Command::Replan(a)) => commands::control::replan::run(a, global, &console),
        Some(Command::Rig(a)) => commands::rig::run(a, global, &console),
        Some(Command::Ablate(a)) => commands::ablate::run(a, global, &console),
        Some(Command::Compare(a)) => commands::compare::run(a, global, &console),
        Some(Command::Doctor(a)) => commands::doctor::run(a, &console),
        Some(Command::Completions(a)) => commands::shell::completions(a),
        Some(Command::Man(a)) => commands::shell::man(a, &console),
        Some(Command::Evaluate(a)) => commands::evaluate::run(a, global, &console),
    }
}
