//! Arguments of `pam rig`.

use crate::options::possible_values;
use clap::builder::{PossibleValue, PossibleValuesParser};
use clap::{Args, Subcommand};
use pam_core::NamedChoice;
use pam_rig::Protocol;
use pam_rig::protocol::ConditionSet;
use pam_rig::sensors::Part;
use std::path::PathBuf;

/// Commands of the virtual rig.
#[derive(Debug, Subcommand)]
pub enum RigCommand {
    /// Carry out a protocol and write raw logs and the sealed ground truth
    Record(RigRecordArguments),
    /// List the effects that can be hidden in the rig, with parameters and units
    ListEffects,
    /// Print a protocol as TOML, to start one's own from; without a name, list them
    Protocol(RigProtocolArguments),
    /// Print the rig's parameters as TOML, for --rig
    Parameters,
    /// Measure on the rig what is published about the joint
    Observables(RigObservablesArguments),
}

/// Arguments of `pam rig record`.
#[derive(Debug, Args)]
pub struct RigRecordArguments {
    /// Protocol.
    #[arg(long, default_value = "paper", value_name = "NAME|FILE", help = protocols())]
    pub protocol: String,
    /// Sealed pressures.
    #[arg(long, value_name = "SET|PAIRS", help = conditions())]
    pub conditions: Option<String>,
    /// Parameters of the rig, a TOML file; what it leaves out has its default
    #[arg(long, value_name = "FILE")]
    pub rig: Option<PathBuf>,
    /// Hidden effects.
    #[arg(long = "effect", value_name = "ID[:NAME=VALUE,…]", help = hidden_effects())]
    pub effects: Vec<String>,
    /// Parts to make ideal, separated by commas
    #[arg(long, value_delimiter = ',', value_name = "PARTS", value_parser = parts())]
    pub ideal: Vec<String>,
    /// Write no truth of the samples, only the settings
    #[arg(long)]
    pub no_truth: bool,
    /// Replace recordings that were made with other settings
    #[arg(long)]
    pub overwrite: bool,
    /// Folder for the logs; recordings of an interrupted run that are there are kept
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Also write a report with figures
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
}

/// Parser of `pam rig record --ideal`.
fn parts() -> PossibleValuesParser {
    possible_values::<Part>().chain([PossibleValue::new("all").help("all of them")]).into()
}

/// Help of `pam rig record --protocol`.
fn protocols() -> String {
    format!(
        "A protocol that comes with the rig ({}), or a TOML file",
        Protocol::BUILT_IN.join(", ")
    )
}

/// Help of `pam rig record --conditions`.
fn conditions() -> String {
    let sets = ConditionSet::ALL.iter().map(|(name, _, what)| format!("{name} ({what})"));
    format!(
        "Sealed pressures instead of the protocol's: {}, or pairs of psi gauge like 30/60,45/45 (flexor/extensor)",
        sets.collect::<Vec<_>>().join(", ")
    )
}

/// Help of `pam rig record --effect`.
fn hidden_effects() -> String {
    let ids = |listed: bool| {
        let some = pam_rig::effects::ALL.iter().filter(|e| e.is_listed() == listed);
        some.map(|e| e.info.id).collect::<Vec<_>>().join(", ")
    };
    format!(
        "Hide an effect, with or without its parameters: coulomb_friction:force_n=20. Can be repeated. Effects: \
         {}. Phenomena outside the vocabulary: {}",
        ids(true),
        ids(false)
    )
}

/// Arguments of `pam rig protocol`.
#[derive(Debug, Args)]
pub struct RigProtocolArguments {
    /// A protocol that comes with the rig
    #[arg(value_name = "NAME", value_parser = PossibleValuesParser::new(Protocol::BUILT_IN))]
    pub name: Option<String>,
}

/// Arguments of `pam rig observables`.
#[derive(Debug, Args)]
pub struct RigObservablesArguments {
    /// Parameters of the rig, a TOML file
    #[arg(long, value_name = "FILE")]
    pub rig: Option<PathBuf>,
}
