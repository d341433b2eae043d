//! The `pam` command.

use clap::Parser;
use std::process::ExitCode;

/// Counts while `pam bench` measures memory, and costs nothing to speak of otherwise.
#[global_allocator]
static MEMORY: pam_cli::CountingAllocator = pam_cli::CountingAllocator;

fn main() -> ExitCode {
    pam_cli::run(pam_cli::Arguments::parse())
}
