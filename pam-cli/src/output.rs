//! Outputs of a command, checked and locked before it runs.

use crate::error::CliError;
use pam_data::output_folder::{OutputFolder, Sharing, check_file};
use std::path::Path;

/// A folder or file that a command writes.
#[derive(Debug, Clone, Copy)]
pub enum Output<'a> {
    /// A folder of results of the command of this name (`evaluate`, `rig record`), of one process at a time.
    Folder(&'static str, &'a Path),
    /// A folder that several processes of the command of this name may work in.
    SharedFolder(&'static str, &'a Path),
    /// One file.
    File(&'a Path),
}

/// Checks, claims and locks outputs; they are released when the result is dropped.
///
/// # Errors
/// [`CliError::Data`] if one cannot be written, another program writes there, or it holds the results of another
/// command.
pub fn claim(outputs: &[Output<'_>]) -> Result<Vec<OutputFolder>, CliError> {
    let mut claimed = Vec::new();
    for output in outputs {
        match *output {
            Output::Folder(command, path) => {
                claimed.push(OutputFolder::claim(path, command, Sharing::Exclusive)?);
            }
            Output::SharedFolder(command, path) => {
                claimed.push(OutputFolder::claim(path, command, Sharing::Shared)?);
            }
            Output::File(path) => check_file(path)?,
        }
    }
    Ok(claimed)
}
