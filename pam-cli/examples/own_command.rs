//! A command of one's own: the time that recordings cover.
//!
//! To call it as `pam duration`, put the part before `main` into `pam-cli/src/commands/duration.rs` and add two
//! lines to `mod.rs` there: `pub mod duration;` and, in the list, its entry with a line of help.

use clap::Args;
use pam_cli::arguments::GlobalOptions;
use pam_cli::commands::RunCommand;
use pam_cli::console::Console;
use pam_cli::error::CliError;
use pam_cli::options::DataOptions;
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

/// Arguments of `pam duration`.
#[derive(Debug, Args)]
pub struct DurationArguments {
    /// Recordings, or folders of them
    #[arg(required = true, value_name = "PATH")]
    pub recordings: Vec<PathBuf>,
    /// How recordings are read.
    #[command(flatten)]
    pub reading: DataOptions,
}

impl DurationArguments {
    /// Time from the first sample to the last, summed over the recordings, s.
    ///
    /// # Errors
    /// [`CliError`] naming file, line and column, or the option.
    pub fn duration_s(&self, global: &GlobalOptions, console: &Console) -> Result<f64, CliError> {
        let recordings = self.reading.recordings(&self.recordings, global.rig()?, console)?;
        let spans = recordings.iter().map(|r| r.time_s[r.time_s.len() - 1] - r.time_s[0]);
        Ok(spans.sum())
    }
}

impl RunCommand for DurationArguments {
    fn run(&self, global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        let duration_s = self.duration_s(global, console)?;
        console.text(format!("{duration_s:.3} s"));
        console.json(&json!({ "duration_s": duration_s }));
        Ok(ExitCode::SUCCESS)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// The options that every command has, and those of this one.
    #[derive(Debug, clap::Parser)]
    struct Program {
        #[command(flatten)]
        arguments: DurationArguments,
        #[command(flatten)]
        global: GlobalOptions,
    }

    let folder = tempfile::tempdir()?;
    let header =
        "time_s,displacement_mm,velocity_mm_s,pressure_flexor_kpa,pressure_extensor_kpa,force_n";
    for (name, last_s) in [("a.csv", 0.5), ("b.csv", 1.25)] {
        let text = format!("{header}\n0,0,0,412,412,0\n{last_s},0,0,412,412,0\n");
        std::fs::write(folder.path().join(name), text)?;
    }
    let path = folder.path().display().to_string();
    let program = <Program as clap::Parser>::try_parse_from(["duration", &path, "--quiet"])?;
    let console = Console::new(&program.global);
    assert_eq!(program.arguments.duration_s(&program.global, &console)?, 1.75);
    assert_eq!(program.arguments.run(&program.global, &console)?, ExitCode::SUCCESS);
    Ok(())
}
