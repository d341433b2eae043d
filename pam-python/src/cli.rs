//! The program `pam`.

use pam_cli::Registry;
use pyo3::prelude::*;
use std::process::ExitCode;

/// Runs a command line, the name of the program first, and returns its exit code.
#[pyfunction]
pub(crate) fn run_program(py: Python<'_>, arguments: Vec<String>) -> u8 {
    py.detach(|| {
        let code = pam_cli::run_from(Registry::default(), arguments);
        // An exit code does not show its number.
        (0..=u8::MAX).find(|n| ExitCode::from(*n) == code).unwrap_or(pam_cli::FAILED)
    })
}
