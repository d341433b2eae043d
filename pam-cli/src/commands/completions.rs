//! `pam completions` (feature `completions`).

use super::RunCommand;
use crate::arguments::GlobalOptions;
use crate::console::Console;
use crate::error::CliError;
use clap::Args;
use std::process::ExitCode;

#[cfg(feature = "completions")]
use clap_complete::Shell;
#[cfg(not(feature = "completions"))]
type Shell = String;

/// Arguments of `pam completions`.
#[derive(Debug, Args)]
pub struct CompletionsArguments {
    /// The shell
    #[arg(value_name = "SHELL")]
    // The help is the same without the feature.
    #[cfg_attr(
        not(feature = "completions"),
        arg(value_parser = ["bash", "elvish", "fish", "powershell", "zsh"])
    )]
    pub shell: Shell,
}

impl RunCommand for CompletionsArguments {
    #[cfg(feature = "completions")]
    fn run(&self, _global: &GlobalOptions, _console: &Console) -> Result<ExitCode, CliError> {
        let mut program = crate::arguments::Arguments::with_exit_codes();
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut program, "pam", &mut script);
        crate::console::write_out(&script);
        Ok(ExitCode::SUCCESS)
    }

    #[cfg(not(feature = "completions"))]
    fn run(&self, _global: &GlobalOptions, _console: &Console) -> Result<ExitCode, CliError> {
        Err(CliError::without_feature("completions"))
    }
}
