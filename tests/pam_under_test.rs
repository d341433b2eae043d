//! The `pam` command with all its features, as the tests run it.

use std::process::ExitCode;

fn main() -> ExitCode {
    pam_cli::run(pam_cli::Registry::default())
}
