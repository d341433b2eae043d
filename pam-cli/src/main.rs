//! The `pam` command.

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    pam_cli::run(pam_cli::Arguments::parse())
}
