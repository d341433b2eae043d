use crate::options::{DataOptions, ModelOptions};
use clap::Args;
use std::path::PathBuf;

/// Arguments of `pam diagnose`.
#[derive(Debug, Args)]
pub struct DiagnoseArguments {
    /// The model.
    #[command(flatten)]
    pub model: ModelOptions,
    /// Recordings, or folders of them, in which something may be wrong
    #[arg(long, required = true, num_args = 1.., value_name = "PATH")]
    pub data: Vec<PathBuf>,
    /// Test set, which no decision sees [default: a third of the data, or of the only recording]
    #[arg(long, num_args = 1.., value_name = "PATH")]
    pub heldout: Vec<PathBuf>,
    /// Baseline recordings, on which the model was validated: its error there counts as no fault
    #[arg(long, num_args = 1.., value_name = "PATH")]
    pub healthy: Vec<PathBuf>,
    /// Candidates.
    #[arg(long, value_delimiter = ',', value_name = "ID,…", help = candidates())]
    pub effects: Vec<String>,
    /// Most effects that are named together: the setting `search.max_causes` [default: 3]
    #[arg(long, value_name = "N")]
    pub max_effects: Option<usize>,
    /// Settings of the diagnosis (see docs/diagnosis.md)
    #[arg(long, value_name = "FILE.toml")]
    pub settings: Option<PathBuf>,
    /// Change one setting, like `search.beam_width=4`; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
    /// Also write a protocol for the rig that distinguishes the named cause from those it is confusable with
    #[arg(long)]
    pub design: bool,
    /// How recordings are read.
    #[command(flatten)]
    pub reading: DataOptions,
    /// Folder for diagnosis.json, report.html and model.safetensors
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// Help of `pam diagnose --effects`.
fn candidates() -> String {
    let ids: Vec<&str> = pam_effects::effects::ALL.iter().map(|e| e.info().id).collect();
    format!("Effects that may be named, separated by commas [default: all of {}]", ids.join(", "))
}
