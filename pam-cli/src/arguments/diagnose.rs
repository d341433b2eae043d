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
    /// Recordings that only judge [default: a third of the data, or of the only recording, is kept aside]
    #[arg(long, num_args = 1.., value_name = "PATH")]
    pub heldout: Vec<PathBuf>,
    /// Recordings on which the model was validated: its error there is ordinary and no fault
    #[arg(long, num_args = 1.., value_name = "PATH")]
    pub healthy: Vec<PathBuf>,
    /// Candidates.
    #[arg(long, value_delimiter = ',', value_name = "ID,…", help = candidates())]
    pub effects: Vec<String>,
    /// Most effects that are named together
    #[arg(long, default_value_t = 3, value_name = "N")]
    pub max_effects: usize,
    /// Also write a protocol for the rig that tells the named cause from those it is confusable with
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
