//! The `pam` command, as a library: argument types and thin commands over the other crates.
//!
//! Exit codes: 0 for success, 1 for an error in input, model or output, 2 for wrong usage, 3 when
//! the command finished but some recordings, samples or cells failed, 130 when it was interrupted and
//! can be resumed.

pub mod arguments;
pub mod commands;
pub mod console;
pub mod error;
pub mod options;
pub mod rig_joint;
pub mod run_record;

pub use arguments::{Arguments, Command};
pub use console::Console;
pub use error::CliError;

use commands::RunCommand;
use commands::demo::DemoArguments;
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
        None => DemoArguments::default().run(global, &console),
        Some(command) => command.run(global, &console),
    }
}
