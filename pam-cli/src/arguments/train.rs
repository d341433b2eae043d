//! Arguments of `pam train`.

use crate::options::DataOptions;
use clap::Args;
use pam_solvers::Tableau;
use pam_train::curriculum::Curriculum;
use std::path::PathBuf;

/// Arguments of `pam train`.
#[derive(Debug, Args)]
pub struct TrainArguments {
    /// Curriculum.
    #[arg(default_value = "recommended", value_name = "NAME|FILE", help = curricula())]
    pub curriculum: String,
    /// Recordings, or folders of them; the curriculum selects training and validation recordings
    #[arg(long, num_args = 1.., required_unless_present = "print", value_name = "PATH")]
    pub data: Vec<PathBuf>,
    /// Folder of the run
    #[arg(long, required_unless_present = "print", value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// The model file to start from in place of the curriculum's. Its effects, if it is an extended model, are
    /// trained along with the network; --set coordinates.frozen.network=true trains them alone,
    /// --set coordinates.frozen.effects=true leaves them as they are
    #[arg(long, value_name = "FILE", conflicts_with = "resume")]
    pub start: Option<PathBuf>,
    /// Override a value of the curriculum: rate=3e-4, stage.2.epochs=50 (stages count from zero). Can be
    /// repeated
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub overrides: Vec<String>,
    /// Method.
    #[arg(long, value_name = "NAME", conflicts_with = "resume", help = methods())]
    pub method: Option<String>,
    /// Go on with the run in the folder, from its last checkpoint and with its curriculum
    #[arg(long, conflicts_with = "overrides")]
    pub resume: bool,
    /// Seconds between checkpoints
    #[arg(long, default_value_t = 10.0, value_name = "S")]
    pub checkpoint_s: f64,
    /// Print the curriculum as TOML and do nothing
    #[arg(long)]
    pub print: bool,
    /// How recordings are read.
    #[command(flatten)]
    pub reading: DataOptions,
}

/// Help of the curriculum of `pam train`.
fn curricula() -> String {
    format!("A curriculum: {}, or a TOML file", Curriculum::BUILT_IN.join(", "))
}

/// Help of `pam train --method`.
fn methods() -> String {
    format!(
        "How the equations are solved: exact (leaky_relu or relu), {}, or auto; the same as --set \
         solver.method=NAME",
        Tableau::NAMES.join(", ")
    )
}
