//! `pam rig`.

pub mod list;
pub mod record;

pub use list::{RigObservablesArguments, RigParametersArguments, RigProtocolArguments};
pub use record::RigRecordArguments;

use crate::arguments::GlobalOptions;
use crate::commands::RunCommand;
use crate::console::Console;
use crate::error::CliError;
use crate::output::Output;
use clap::Subcommand;
use std::process::ExitCode;

/// Commands of the virtual rig.
#[derive(Debug, Subcommand)]
pub enum RigCommand {
    /// Run a protocol and write raw logs and the sealed ground truth
    Record(RigRecordArguments),
    /// List the effects that can be hidden in the rig, with parameters and units
    ListEffects,
    /// Print a protocol as TOML, as a template for your own; without a name, list them
    Protocol(RigProtocolArguments),
    /// Print the rig's parameters as TOML, for --rig
    Parameters(RigParametersArguments),
    /// Measure the published observables on the rig
    Observables(RigObservablesArguments),
}

impl RunCommand for RigCommand {
    fn outputs(&self) -> Vec<Output<'_>> {
        let RigCommand::Record(record) = self else { return Vec::new() };
        let report = record.report.as_deref().map(Output::File);
        [Output::Folder("rig record", &record.out)].into_iter().chain(report).collect()
    }

    fn run(&self, global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        match self {
            RigCommand::Record(arguments) => record::run(arguments, global, console)?,
            RigCommand::ListEffects => list::effects(console),
            RigCommand::Protocol(arguments) => list::protocol(arguments, console)?,
            RigCommand::Parameters(arguments) => list::parameters(arguments, console)?,
            RigCommand::Observables(arguments) => list::observables_of(arguments, console)?,
        }
        Ok(ExitCode::SUCCESS)
    }
}
