use crate::options::DataOptions;
use clap::Args;
use std::path::PathBuf;

/// Arguments of `pam compare`.
#[derive(Debug, Args)]
pub struct CompareArguments {
    /// Configuration: recordings, split, models (docs/compare.md; `--print` shows one)
    #[arg(value_name = "CONFIG.toml", required_unless_present = "print")]
    pub config: Option<PathBuf>,
    /// Folder for comparison.json, times.json, table.csv, recordings.csv, table.tex, report.html, run.json
    /// and models/
    #[arg(long, value_name = "DIR", required_unless_present = "print")]
    pub out: Option<PathBuf>,
    /// Take over models that an earlier run of the same program into the same folder finished with the same
    /// data, settings and seed
    #[arg(long)]
    pub resume: bool,
    /// Print a configuration with every kind of model and its default settings, and stop
    #[arg(long)]
    pub print: bool,
    /// How recordings are read.
    #[command(flatten)]
    pub reading: DataOptions,
}
