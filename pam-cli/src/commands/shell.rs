//! `pam completions` and `pam man`.

use crate::arguments::{Arguments, CompletionsArguments, ManArguments};
use crate::console::Console;
use crate::error::{CliError, failed};
use pam_data::atomic::write_atomic;
use serde_json::json;
use std::io::Write;
use std::process::ExitCode;

/// Prints the completion script of a shell.
///
/// # Errors
/// None; a closed pipe ends the output.
pub fn completions(arguments: &CompletionsArguments) -> Result<ExitCode, CliError> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Arguments::with_exit_codes(), "pam", &mut script);
    let _ = std::io::stdout().lock().write_all(&script);
    Ok(ExitCode::SUCCESS)
}

/// Writes `pam.1` and one page a command, `pam-train.1`, `pam-rig-record.1`, ….
///
/// # Errors
/// [`CliError`] if a page cannot be written.
pub fn man(arguments: &ManArguments, console: &Console) -> Result<ExitCode, CliError> {
    let mut command = Arguments::with_exit_codes();
    command.build();
    let mut pages = Vec::new();
    write_pages(&command, "pam", arguments, &mut pages)?;
    console.text(format!("{} pages in {}", pages.len(), arguments.out.display()));
    console.json(&json!({ "pages": pages }));
    Ok(ExitCode::SUCCESS)
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
