//! The `pam` command, as a library: argument types and thin commands over the other crates.
//!
//! A custom program is the whole `pam` with your own effects, activations and losses, known by their names: see
//! [`Registry`].
//!
//! Exit codes: 0 for success, 1 for an error in input, model or output, 2 for wrong usage, 3 when
//! the command finished but some recordings, samples or cells failed, 130 when it was interrupted and
//! can be resumed.

pub mod arguments;
pub mod commands;
pub mod console;
pub mod error;
pub mod interrupt;
mod memory;
pub mod options;
pub mod output;
pub mod registry;
pub mod rig_joint;
pub mod run_record;

pub use arguments::{Arguments, Command};
pub use console::Console;
pub use error::CliError;
pub use registry::Registry;

use clap::FromArgMatches;
use commands::RunCommand;
use commands::demo::DemoArguments;
use pam_data::read_limit;
use std::ffi::OsString;
use std::process::ExitCode;

/// The traits and types from which a custom part is made; see [`Registry`].
pub mod own {
    pub use pam_core::activation::NamedActivation;
    pub use pam_core::{ActivationFunction, Scalar, units};
    pub use pam_data::{Channel, Recording};
    pub use pam_effects::effects::{
        Absorbed, ChamberLaw, Command, DataScales, Effect, EffectInfo, Group, Observed,
        ParameterInfo, Point, Rest, Switch, entry,
    };
    pub use pam_trajectory::loss::{
        NamedLoss, Pointwise, SampleErrors, TrajectoryLoss, loss_fn, pointwise,
    };
    pub use pam_trajectory::settings::SettingsError;
}

/// Exit code for an error in input, model or output.
pub const FAILED: u8 = 1;

/// Exit code for wrong usage, the same as for arguments that cannot be parsed.
pub const USAGE: u8 = 2;

/// Exit code when some recordings could not be predicted to their end.
pub const PARTIAL: u8 = 3;

/// Exit code when a signal asked to stop, and what was reached is saved.
pub const INTERRUPTED: u8 = 130;

/// Runs the command line of the process with the parts of a registry: the whole of a `main`.
///
/// ```no_run
/// fn main() -> std::process::ExitCode {
///     pam_cli::run(pam_cli::Registry::default())
/// }
/// ```
///
/// Errors go to the error stream.
#[must_use]
pub fn run(registry: Registry) -> ExitCode {
    // Help and parsers list the known parts, so they are registered first.
    match registry.install() {
        Ok(()) => run_arguments(&Arguments::of_process()),
        Err(error) => report(&error),
    }
}

/// As [`run`] with the arguments `arguments`, the name of the program first, for programs that host this one. Wrong
/// arguments and requests for help are printed and end in an exit code, not the process.
#[must_use]
pub fn run_from<T: Into<OsString> + Clone>(
    registry: Registry,
    arguments: impl IntoIterator<Item = T>,
) -> ExitCode {
    if let Err(error) = registry.install() {
        return report(&error);
    }
    let parsed = Arguments::with_exit_codes()
        .try_get_matches_from(arguments)
        .and_then(|matches| Arguments::from_arg_matches(&matches));
    match parsed {
        Ok(arguments) => run_arguments(&arguments),
        Err(error) => {
            // A closed output is no reason to fail.
            let _ = error.print();
            ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(USAGE))
        }
    }
}

/// Runs a command line and reports its errors on the error stream. Custom parts must have been
/// [installed](Registry::install) before the arguments were parsed.
#[must_use]
pub fn run_arguments(arguments: &Arguments) -> ExitCode {
    let code = dispatch(arguments).unwrap_or_else(|error| report(&error));
    match console::lost_output() {
        Some(error) if [ExitCode::SUCCESS, ExitCode::from(PARTIAL)].contains(&code) => report(
            &CliError::Failed(format!("standard output: {error}; what was printed is incomplete")),
        ),
        _ => code,
    }
}

fn report(error: &CliError) -> ExitCode {
    eprintln!("error: {error}");
    ExitCode::from(if error.is_usage() { USAGE } else { FAILED })
}

fn dispatch(arguments: &Arguments) -> Result<ExitCode, CliError> {
    let global = &arguments.global;
    if let Some(threads) = global.threads {
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build_global()
            .map_err(|e| CliError::Usage(format!("--threads {threads}: {e}")))?;
    }
    if let Some(mib) = global.max_read_mib {
        read_limit::set_largest_bytes(mib.saturating_mul(1 << 20));
    }
    if let Some(limit_s) = global.timeout {
        interrupt::limit(interrupt::seconds("--timeout", limit_s, false)?);
    }
    global.load_effects()?;
    let console = Console::new(global);
    let demo = DemoArguments::default();
    let command: &dyn RunCommand = match &arguments.command {
        None => &demo,
        Some(command) => command,
    };
    let _claimed = output::claim(&command.outputs())?;
    command.run(global, &console)
}
