//! `pam rig-file`.

use super::RunCommand;
use crate::arguments::GlobalOptions;
use crate::console::{Console, table};
use crate::error::CliError;
use crate::output::Output;
use clap::{Args, Subcommand};
use pam_data::RigFile;
use pam_data::atomic::{write_atomic, write_new};
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

/// Commands of rig files.
#[derive(Debug, Subcommand)]
pub enum RigFileCommand {
    /// Write a draft of a rig file from a recording
    Init(RigFileInitArguments),
    /// Check a rig file and print its contents
    Check(RigFileCheckArguments),
}

/// Arguments of `pam rig-file init`.
#[derive(Debug, Args)]
pub struct RigFileInitArguments {
    /// A recording: text with any separator, .npz or .mat
    #[arg(value_name = "FILE")]
    pub recording: PathBuf,
    /// The rig file to write
    #[arg(long, default_value = "rig.toml", value_name = "RIG.toml")]
    pub out: PathBuf,
    /// Replace an existing file
    #[arg(long)]
    pub force: bool,
}

/// Arguments of `pam rig-file check`.
#[derive(Debug, Args)]
pub struct RigFileCheckArguments {
    /// The rig file
    #[arg(value_name = "RIG.toml")]
    pub file: PathBuf,
}

impl RunCommand for RigFileCommand {
    fn outputs(&self) -> Vec<Output<'_>> {
        match self {
            Self::Init(arguments) => arguments.outputs(),
            Self::Check(arguments) => arguments.outputs(),
        }
    }

    fn run(&self, global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        match self {
            Self::Init(arguments) => arguments.run(global, console),
            Self::Check(arguments) => arguments.run(global, console),
        }
    }
}

impl RunCommand for RigFileInitArguments {
    fn outputs(&self) -> Vec<Output<'_>> {
        vec![Output::File(&self.out)]
    }

    fn run(&self, _global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        if self.out.exists() && !self.force {
            return Err(CliError::Usage(format!(
                "{} exists; name another file with --out, or replace it with --force",
                self.out.display()
            )));
        }
        let guessed = RigFile::guess(&self.recording)?;
        let toml = guessed.to_toml();
        if self.force {
            write_atomic(&self.out, toml.as_bytes())?;
        } else {
            // Another program may have written it since.
            write_new(&self.out, toml.as_bytes())?;
        }
        let mut rows = vec![["key", "", "reason"].map(str::to_owned).to_vec()];
        rows.extend(guessed.guesses.iter().map(|g| {
            let mark = if g.to_confirm { "confirm" } else { "" };
            vec![g.key.clone(), mark.to_owned(), g.reason.clone()]
        }));
        console.text(table(&rows));
        if !guessed.missing.is_empty() {
            let lines: Vec<String> =
                guessed.missing.iter().map(|(key, what)| format!("  {key}: {what}")).collect();
            console.text(format!("\nTo be filled in, for no file tells it:\n{}", lines.join("\n")));
        }
        console.text(format!(
            "\nwritten: {}\nThen: pam inspect --rig-file {} {}",
            self.out.display(),
            self.out.display(),
            self.recording.display()
        ));
        console.json(&json!({
            "written": self.out,
            "rig": guessed.rig,
            "guesses": guessed.guesses.iter().map(|g| json!({
                "key": g.key, "reason": g.reason, "to_confirm": g.to_confirm,
            })).collect::<Vec<_>>(),
            "missing": guessed.missing.iter().map(|(key, what)| json!({ "key": key, "what": what }))
                .collect::<Vec<_>>(),
            "unused": guessed.unused,
        }));
        Ok(ExitCode::SUCCESS)
    }
}

impl RunCommand for RigFileCheckArguments {
    fn run(&self, _global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        let rig = RigFile::read(&self.file)?;
        let (geometry, p) = (rig.geometry(), rig.physical());
        console.text(format!(
            "{}: muscles {} x {} mm (radius x length), m = {:.4} kg, C = {:.4e} kPa mm3/g, deformation {:.3}",
            if rig.name.is_empty() { "rig" } else { &rig.name },
            geometry.radius_mm,
            geometry.length_mm,
            p.mass_kg,
            p.gas_coefficient,
            p.deformation
        ));
        console.json(&json!({
            "rig": rig,
            "radius_mm": geometry.radius_mm,
            "length_mm": geometry.length_mm,
            "mass_kg": p.mass_kg,
            "gas_coefficient_kpa_mm3_per_g": p.gas_coefficient,
            "deformation": p.deformation,
        }));
        Ok(ExitCode::SUCCESS)
    }
}
