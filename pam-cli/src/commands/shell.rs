//! `pam completions` and `pam man`.

use super::RunCommand;
use crate::arguments::{Arguments, GlobalOptions};
use crate::console::Console;
use crate::error::{CliError, failed};
use clap::Args;
use pam_data::atomic::write_atomic;
use serde_json::json;
use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `pam completions`.
#[derive(Debug, Args)]
pub struct CompletionsArguments {
    /// The shell
    #[arg(value_name = "SHELL")]
    pub shell: clap_complete::Shell,
}

/// Arguments of `pam man`.
#[derive(Debug, Args)]
pub struct ManArguments {
    /// Folder for pam.1 and one page a command
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

impl RunCommand for CompletionsArguments {
    fn run(&self, _global: &GlobalOptions, _console: &Console) -> Result<ExitCode, CliError> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut Arguments::with_exit_codes(), "pam", &mut script);
        let _ = std::io::stdout().lock().write_all(&script);
        Ok(ExitCode::SUCCESS)
    }
}

impl RunCommand for ManArguments {
    fn run(&self, _global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        let mut command = Arguments::with_exit_codes();
        command.build();
        let mut pages = Vec::new();
        write_pages(&command, "pam", self, &mut pages)?;
        console.text(format!("{} pages in {}", pages.len(), self.out.display()));
        console.json(&json!({ "pages": pages }));
        Ok(ExitCode::SUCCESS)
    }
}

fn write_pages(
    command: &clap::Command,
    name: &str,
    arguments: &ManArguments,
    pages: &mut Vec<String>,
) -> Result<(), CliError> {
    let file = format!("{name}.1");
    let mut page = Vec::new();
    // A page is named by the whole command, `pam-rig-record`.
    let named = command.clone().name(name.to_owned());
    clap_mangen::Man::new(named).render(&mut page).map_err(|e| failed(format!("{file}: {e}")))?;
    write_atomic(&arguments.out.join(&file), &page)?;
    pages.push(file);
    for sub in command.get_subcommands().filter(|c| c.get_name() != "help" && !c.is_hide_set()) {
        write_pages(sub, &format!("{name}-{}", sub.get_name()), arguments, pages)?;
    }
    Ok(())
}
