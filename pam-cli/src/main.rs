//! The `pam` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    pam_cli::run(pam_cli::Registry::default())
}
