//! Arguments of `pam ablate`.

use crate::options::DataOptions;
use clap::{Args, Subcommand};
use pam_ablate::run::Shard;
use pam_ablate::sweep::Sweep;
use std::path::PathBuf;

/// Arguments of `pam ablate`.
#[derive(Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct AblateArguments {
    /// Subcommand.
    #[command(subcommand)]
    pub command: Option<AblateCommand>,
    /// Sweep.
    #[arg(value_name = "NAME|FILE", required_unless_present = "out", help = sweeps())]
    pub sweep: Option<String>,
    /// Folder of the sweep: cells, tables, report. A sweep that was stopped or killed goes on there
    #[arg(long, value_name = "DIR", required_unless_present_any = ["print", "list"])]
    pub out: Option<PathBuf>,
    /// Recordings, or folders of them, in place of the sweep's
    #[arg(long, num_args = 1.., value_name = "PATH")]
    pub data: Vec<PathBuf>,
    /// Set a value in all cells, before the axes: stage.2.epochs=5. Can be repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
    /// Seeds of the cells, in place of the sweep's: 1,2,3
    #[arg(long, value_name = "N,N", value_delimiter = ',')]
    pub seeds: Vec<u64>,
    /// Run the cells of one of n shards: 3/8
    #[arg(long, value_name = "I/N", value_parser = Shard::parse, default_value = "1/1")]
    pub shard: Shard,
    /// After the shard's own cells run those of other shards that nobody works on
    #[arg(long)]
    pub steal: bool,
    /// Cells at a time, which share the threads [default: as many as threads]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub jobs: Option<u16>,
    /// Run cells that failed again
    #[arg(long)]
    pub retry_failed: bool,
    /// Let this sweep take the place of the folder's: cells that are in both are kept
    #[arg(long)]
    pub extend: bool,
    /// Seconds between checkpoints of a cell
    #[arg(long, default_value_t = 10.0, value_name = "S")]
    pub checkpoint_s: f64,
    /// List the cells and how they stand, and run nothing
    #[arg(long)]
    pub list: bool,
    /// Print the text of a sweep that comes with the program, and stop
    #[arg(long, conflicts_with = "list")]
    pub print: bool,
    /// How recordings are read.
    #[command(flatten)]
    pub reading: DataOptions,
}

/// Help of the sweep of `pam ablate`.
fn sweeps() -> String {
    format!(
        "A sweep: {}, or a TOML file (docs/ablations.md) [default: the one that the folder of --out was begun with]",
        Sweep::BUILT_IN.join(", ")
    )
}

/// Subcommands of `pam ablate`.
#[derive(Debug, Subcommand)]
pub enum AblateCommand {
    /// Gather the cells of one or several folders of a sweep and write tables and report
    Merge(MergeArguments),
    /// Print a batch script that runs a sweep as a job array of Slurm
    Template,
}

/// Arguments of `pam ablate merge`.
#[derive(Debug, Args)]
pub struct MergeArguments {
    /// Folders of the sweep
    #[arg(required = true, value_name = "DIR")]
    pub folders: Vec<PathBuf>,
    /// Where cells, tables and report go [default: the folder, if there is only one]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}
