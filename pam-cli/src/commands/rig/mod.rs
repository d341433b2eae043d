//! `pam rig`.

mod list;
mod record;

use crate::arguments::{GlobalOptions, RigCommand};
use crate::console::Console;
use crate::error::CliError;
use pam_rig::RigParameters;
use std::path::Path;
use std::process::ExitCode;

/// Runs the command.
///
/// # Errors
/// [`CliError`] naming file and line, or the option.
pub fn run(
    command: &RigCommand,
    global: &GlobalOptions,
    console: &Console,
) -> Result<ExitCode, CliError> {
    match command {
        RigCommand::Record(arguments) => record::run(arguments, global, console)?,
        RigCommand::ListEffects => list::effects(console),
        RigCommand::Protocol(arguments) => list::protocol(arguments, console)?,
        RigCommand::Parameters => list::parameters(console),
        RigCommand::Observables(arguments) => list::observables_of(arguments, console)?,
    }
    Ok(ExitCode::SUCCESS)
}

/// The rig of a file, or the default one.
fn rig(path: Option<&Path>) -> Result<RigParameters, CliError> {
    Ok(path.map_or_else(|| Ok(RigParameters::default()), RigParameters::read)?)
}
