//! `pam man` (feature `man`).

use super::RunCommand;
use crate::arguments::GlobalOptions;
use crate::console::Console;
use crate::error::CliError;
use crate::output::Output;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `pam man`.
#[derive(Debug, Args)]
pub struct ManArguments {
    /// Folder for pam.1 and one page per command
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

impl RunCommand for ManArguments {
    fn outputs(&self) -> Vec<Output<'_>> {
        vec![Output::Folder("man", &self.out)]
    }

    #[cfg(feature = "man")]
    fn run(&self, _global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        let mut command = crate::arguments::Arguments::with_exit_codes();
        command.build();
        let mut pages = Vec::new();
        write_pages(&command, "pam", self, &mut pages)?;
        console.text(format!("{} pages in {}", pages.len(), self.out.display()));
        console.json(&serde_json::json!({ "pages": pages }));
        Ok(ExitCode::SUCCESS)
    }

    #[cfg(not(feature = "man"))]
    fn run(&self, _global: &GlobalOptions, _console: &Console) -> Result<ExitCode, CliError> {
        Err(CliError::without_feature("man"))
    }
}

#[cfg(feature = "man")]
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
    clap_mangen::Man::new(named)
        .render(&mut page)
        .map_err(|e| crate::error::failed(format!("{file}: {e}")))?;
    pam_data::atomic::write_atomic(arguments.out.join(&file), &page)?;
    pages.push(file);
    for sub in command.get_subcommands().filter(|c| c.get_name() != "help" && !c.is_hide_set()) {
        write_pages(sub, &format!("{name}-{}", sub.get_name()), arguments, pages)?;
    }
    Ok(())
}
