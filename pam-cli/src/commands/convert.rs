//! `pam convert`.

use super::RunCommand;
use crate::arguments::GlobalOptions;
use crate::console::Console;
use crate::error::CliError;
use crate::options::DataOptions;
use crate::output::Output;
use clap::Args;
use pam_data::atomic::write_atomic;
use pam_data::formats::format::RecordingWriter;
use pam_data::models::save_model;
use pam_data::{Recording, format_of, load_model, open_recordings, writer_for};
use pam_effects::ExtendedModel;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Extension of the rig file beside converted recordings.
const RIG_EXTENSION: &str = "rig.toml";

/// Arguments of `pam convert`.
#[derive(Debug, Args)]
pub struct ConvertArguments {
    /// A recording (raw log, CSV, .npz, .mat) or a model (.eqx, .safetensors)
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// .csv or .npz for a recording, .safetensors or .eqx for a model
    #[arg(value_name = "OUT")]
    pub output: PathBuf,
    /// Write an extended model without its effects: those that the model's own numbers can hold become part
    /// of them, exactly
    #[arg(long)]
    pub plain: bool,
    /// How recordings are read.
    #[command(flatten)]
    pub data: DataOptions,
}

impl RunCommand for ConvertArguments {
    fn outputs(&self) -> Vec<Output<'_>> {
        vec![Output::File(&self.output)]
    }

    fn run(&self, global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        let (input, output) = (&self.input, &self.output);
        let rig = global.rig()?;
        // A table of the rig need not be of any format.
        let of_rig = rig.as_ref().is_some_and(|rig| rig.describes_file(input));
        let written = match if of_rig { None } else { Some(format_of(input)?) } {
            Some(format) if format.holds_model() => {
                let mut saved = load_model(input)?;
                if self.plain {
                    let plain = ExtendedModel::from_saved(saved)?.without_effects();
                    if let Some(sentence) = plain.sentence() {
                        console.text(sentence);
                    }
                    saved = plain.saved;
                }
                save_model(output, &saved)?;
                vec![output.clone()]
            }
            _ => {
                let recordings = open_recordings(input, &self.data.load_options(rig)?)?;
                convert_recordings(&recordings, output, console)?
            }
        };
        for path in &written {
            console.text(format!("{} -> {}", input.display(), path.display()));
        }
        console.json(&json!({ "input": input, "written": written }));
        Ok(ExitCode::SUCCESS)
    }
}

fn convert_recordings(
    recordings: &[Recording],
    output: &Path,
    console: &Console,
) -> Result<Vec<PathBuf>, CliError> {
    let write = recording_writer(output)?;
    let mut written = Vec::new();
    for (i, recording) in recordings.iter().enumerate() {
        console.notes(recording);
        let path = if recordings.len() == 1 { output.to_owned() } else { numbered(output, i + 1) };
        write(&path, recording)?;
        written.push(path);
    }
    // The recordings hold their rig themselves; for other programs and models it stands beside them as well.
    if let Some(rig) = recordings.iter().find_map(|r| r.rig.as_ref()) {
        let path = output.with_extension(RIG_EXTENSION);
        write_atomic(&path, rig.to_toml().as_bytes())?;
        written.push(path);
    }
    Ok(written)
}

/// The writer for the extension of an output file.
///
/// # Errors
/// [`CliError::Usage`] if recordings are not written with this extension.
pub(crate) fn recording_writer(output: &Path) -> Result<RecordingWriter, CliError> {
    writer_for(output).map_err(|e| CliError::Usage(e.to_string()))
}

/// `run.csv` to `run_2.csv`, for the parts of a run with gaps.
pub(crate) fn numbered(path: &Path, number: usize) -> PathBuf {
    let stem = path.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let extension = path.extension().map(|e| e.to_string_lossy().into_owned()).unwrap_or_default();
    path.with_file_name(format!("{stem}_{number}.{extension}"))
}
