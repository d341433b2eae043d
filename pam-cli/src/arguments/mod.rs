//! The command line.

mod ablate;
mod compare;
mod control;
mod diagnose;
mod rig;
mod train;

pub use ablate::{AblateArguments, AblateCommand, MergeArguments};
pub use compare::CompareArguments;
pub use control::{
    BoundsOptions, IdentifyArguments, IdentifySchedule, PlanArguments, PlanMethod, ReplanArguments,
    StiffnessArguments, TrackArguments,
};
pub use diagnose::DiagnoseArguments;
pub use rig::{RigCommand, RigObservablesArguments, RigProtocolArguments, RigRecordArguments};

pub use train::TrainArguments;

use crate::options::{DataOptions, ModelOptions, SolverOptions, StepOptions, choice};
use clap::builder::PossibleValuesParser;
use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand};
use pam_effects::engine::EXACT;
use pam_solvers::Tableau;
use pam_trajectory::engine::Precision;
use pam_trajectory::{AnyLoss, GradientChoice, SettingsError};
use std::path::PathBuf;

/// Hybrid neural ODEs of an antagonistic pneumatic-muscle joint.
///
/// Without a command, the virtual rig records a joint in which an effect is hidden, and the diagnosis of
/// the default model names it; the report is ./pam-demo/report.html.
#[derive(Debug, Parser)]
#[command(name = "pam", version, max_term_width = 100, after_help = format!("{EXAMPLES}\n\n{EXIT_CODES}"))]
pub struct Arguments {
    /// Command.
    #[command(subcommand)]
    pub command: Option<Command>,
    /// Options of every command.
    #[command(flatten)]
    pub global: GlobalOptions,
}

const EXAMPLES: &str = "\
Examples:
  pam                                           hide an effect in rig data, find it, report it
  pam inspect nn_3060 model.eqx                 what is in these files
  pam evaluate --model model.eqx --data logs/ --out out
                                                predict all logs, score them, write out/report.html
  pam simulate --model model.eqx --force sine:A=120,f=0.5 --duration 10 \\
      --pressures 412,412 --out run.csv         a run that was never measured
  pam gradient --model model.eqx --data logs/ --out gradient.npz
                                                loss and exact gradient, for checking others
  pam rig record --conditions 30/60,45/45 --effect coulomb_friction:force_n=20 --out logs
                                                made-up recordings with a hidden effect
  pam diagnose --model model.eqx --data logs --out found
                                                name what the model gets wrong there
  pam train --data logs --out run               train on recordings; run/model.safetensors
  pam plan --model model.eqx --motion sine:A=1,f=0.1 --stiffness 150 --out plan
                                                pressures for a motion and a stiffness
  pam identify --schedule staircase --out id    is the stiffness what was commanded?
  pam compare models.toml --out compared        baselines and the hybrid model on one split
  pam ablate activations --data logs --out sweep
                                                ablations: train many, compare seed by seed
  pam convert model.eqx model.safetensors       published weights to the framework's format";

const EXIT_CODES: &str = "\
Exit codes: 0 success, 1 an error in files, data or the work, 2 wrong usage, 3 finished, but some
recordings, samples or cells failed, 130 interrupted and can be resumed.";

impl Arguments {
    /// The commands, each with the exit codes in its help.
    #[must_use]
    pub fn with_exit_codes() -> clap::Command {
        fn documented(command: clap::Command) -> clap::Command {
            command.after_help(EXIT_CODES).mut_subcommands(documented)
        }
        Self::command().mut_subcommands(documented)
    }

    /// The arguments of the process; ends it with a message and exit code 2 if they are wrong.
    #[must_use]
    pub fn of_process() -> Self {
        let matches = Self::with_exit_codes().get_matches();
        Self::from_arg_matches(&matches).unwrap_or_else(|error| error.exit())
    }
}

/// Options of every command.
#[derive(Debug, Clone, Args)]
pub struct GlobalOptions {
    /// Print results as JSON on the standard output instead of text
    #[arg(long, global = true)]
    pub json: bool,
    /// Seed of everything random; the same seed gives the same bytes at any number of threads
    #[arg(long, global = true, default_value_t = 1, value_name = "N")]
    pub seed: u64,
    /// Number of threads [default: all cores]
    #[arg(long, global = true, value_name = "N", value_parser = parse_threads)]
    pub threads: Option<usize>,
    /// No progress and no text, only errors and, with --json, results
    #[arg(long, short, global = true)]
    pub quiet: bool,
}

fn parse_threads(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(0) => Err("there must be at least one thread".into()),
        Ok(n) => Ok(n),
        Err(e) => Err(format!("{e}")),
    }
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Say what is in a log, a recording, a model or another data file
    Inspect(InspectArguments),
    /// Turn a recording into CSV or .npz, a model into .safetensors or .eqx
    Convert(ConvertArguments),
    /// Simulate the joint under a measured or a made-up force
    Simulate(SimulateArguments),
    /// Predict recordings with a model and score the predictions
    Evaluate(EvaluateArguments),
    /// Loss of a model on recordings, and its gradient with respect to every parameter
    Gradient(GradientArguments),
    /// Train a model on recordings by a curriculum
    Train(TrainArguments),
    /// Show what a model gets wrong on recordings, name the cause, and measure what naming gains
    Diagnose(DiagnoseArguments),
    /// Stiffness and damping of a model over its inputs, and what stiffness can be reached
    Stiffness(StiffnessArguments),
    /// Find the air and the pressures for a motion and a stiffness
    Plan(PlanArguments),
    /// Carry plans out on the virtual rig: the published tracking tests
    Track(TrackArguments),
    /// Identify stiffness and damping from pulses, on the virtual rig or in recordings
    Identify(IdentifyArguments),
    /// Receding-horizon MPC on the virtual rig, under a load step or a changed target
    Replan(ReplanArguments),
    /// The virtual rig: make recordings whose truth is known
    #[command(subcommand)]
    Rig(RigCommand),
    /// Run a sweep: train a model in every cell of a grid or search, and compare seed by seed
    Ablate(AblateArguments),
    /// Compare models on one split of the data: baselines and the hybrid model
    Compare(CompareArguments),
    /// Hide an effect in recordings of the rig and find it: what runs without a command
    Demo(DemoArguments),
    /// Check this machine: version, threads, vector instructions, write access, reference data
    Doctor(DoctorArguments),
    /// Print a completion script for a shell: `pam completions bash > /etc/bash_completion.d/pam`
    Completions(CompletionsArguments),
    /// Write manual pages, one a command
    Man(ManArguments),
}

/// Arguments of `pam doctor`.
#[derive(Debug, Args)]
pub struct DoctorArguments {
    /// Folder of the reference data [default: PAM_SHARED, or ../shared]
    #[arg(long, value_name = "DIR")]
    pub shared: Option<PathBuf>,
    /// A folder in which runs are to be written [default: the current one]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Arguments of `pam completions`.
#[derive(Debug, Args)]
pub struct CompletionsArguments {
    /// The shell
    #[arg(value_name = "SHELL")]
    pub shell: clap_complete::Shell,
}

/// Arguments of `pam man`.
#[derive(Debug, Args)]
pub struct ManArguments {
    /// Folder for pam.1 and one page a command
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// Arguments of `pam inspect`.
#[derive(Debug, Args)]
pub struct InspectArguments {
    /// Files of any kind, or folders of recordings
    #[arg(required = true, value_name = "FILE")]
    pub files: Vec<PathBuf>,
    /// How recordings are read.
    #[command(flatten)]
    pub data: DataOptions,
    /// Model whose gas law gives the masses [default: datasheet parameters]
    #[arg(long, value_name = "MODEL")]
    pub model: Option<PathBuf>,
}

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

/// Arguments of `pam simulate`.
#[derive(Debug, Args)]
pub struct SimulateArguments {
    /// The model.
    #[command(flatten)]
    pub model: ModelOptions,
    /// Recording whose measured force drives the joint, from its first sample
    #[arg(long, value_name = "PATH", conflicts_with_all = ["force", "pressures", "air_masses", "duration"])]
    pub data: Option<PathBuf>,
    /// Made-up force on the joint at rest: constant:A=N, step:A=N,t=S, sine:A=N,f=HZ or
    /// chirp:A=N,f0=HZ,f1=HZ (A in N)
    #[arg(long, value_name = "SPEC", required_unless_present = "data")]
    pub force: Option<String>,
    /// Length of a made-up run, s
    #[arg(long, value_name = "S", default_value_t = 10.0, allow_negative_numbers = true)]
    pub duration: f64,
    /// Samples per second of a made-up run
    #[arg(long, value_name = "HZ", default_value_t = 1000.0, allow_negative_numbers = true)]
    pub rate: f64,
    /// Sealed pressures of flexor and extensor at x = 0, kPa absolute [default: 412,412]
    #[arg(
        long,
        value_name = "PF,PE",
        value_delimiter = ',',
        num_args = 1,
        allow_hyphen_values = true,
        conflicts_with = "air_masses"
    )]
    pub pressures: Option<Vec<f64>>,
    /// Sealed air masses of flexor and extensor, g
    #[arg(
        long,
        value_name = "MF,ME",
        value_delimiter = ',',
        num_args = 1,
        allow_hyphen_values = true
    )]
    pub air_masses: Option<Vec<f64>>,
    /// Where the trajectory goes: .csv or .npz
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Also write a report with figures
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// How recordings are read.
    #[command(flatten)]
    pub reading: DataOptions,
    /// How the equations are solved.
    #[command(flatten)]
    pub solver: SolverOptions,
}

/// Arguments of `pam evaluate`.
#[derive(Debug, Args)]
pub struct EvaluateArguments {
    /// The model.
    #[command(flatten)]
    pub model: ModelOptions,
    /// Recordings, or folders of them
    #[arg(long, required = true, num_args = 1.., value_name = "PATH")]
    pub data: Vec<PathBuf>,
    /// Folder for evaluation.json, report.html, run.json and predictions/
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// How recordings are read.
    #[command(flatten)]
    pub reading: DataOptions,
    /// How the equations are solved.
    #[command(flatten)]
    pub solver: SolverOptions,
}

/// Arguments of `pam gradient`.
#[derive(Debug, Args)]
pub struct GradientArguments {
    /// The model.
    #[command(flatten)]
    pub model: ModelOptions,
    /// Recordings, or folders of them; each is predicted from its first row
    #[arg(long, required = true, num_args = 1.., value_name = "PATH")]
    pub data: Vec<PathBuf>,
    /// Loss, averaged over the recordings.
    #[arg(long, default_value = "paper", value_name = "NAME[:KEY=VALUE,…]", value_parser = NamedLoss::parse, help = losses())]
    pub loss: NamedLoss,
    /// Gradient method, by its name.
    #[arg(long, default_value = "auto", value_name = "NAME", help = gradient_methods())]
    pub method: String,
    /// Runge–Kutta method [default: tsit5]
    #[arg(long, value_name = "NAME", value_parser = tableaux())]
    pub solver: Option<String>,
    /// Float of the network; f32 goes with the adjoint of a network
    #[arg(long, value_parser = choice::<Precision>(), default_value = "f64", value_name = "FLOAT")]
    pub precision: Precision,
    /// Number of timed repeats; their median is reported
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub repeat: u32,
    /// .npz with true displacements (mm), for the largest error: `x` [recordings, samples] in the order of
    /// --data or of an array `names`, or one array a recording, x_0, x_1, … or named as the recordings
    #[arg(long, value_name = "FILE.npz")]
    pub reference: Option<PathBuf>,
    /// Where loss, gradient and time go
    #[arg(long, value_name = "FILE.npz")]
    pub out: PathBuf,
    /// Also write a report with figures
    #[arg(long, value_name = "FILE.html")]
    pub report: Option<PathBuf>,
    /// How recordings are read.
    #[command(flatten)]
    pub reading: DataOptions,
    /// Steps and input.
    #[command(flatten)]
    pub steps: StepOptions,
}

/// Parser of `pam gradient --solver`.
fn tableaux() -> PossibleValuesParser {
    Tableau::NAMES.iter().copied().chain([EXACT]).into()
}

/// A loss with the text that names it.
#[derive(Debug, Clone)]
pub struct NamedLoss {
    /// The text as given.
    pub text: String,
    /// The loss.
    pub loss: AnyLoss,
}

impl NamedLoss {
    fn parse(text: &str) -> Result<Self, SettingsError> {
        Ok(Self { text: text.to_owned(), loss: text.parse()? })
    }
}

/// Help of `pam gradient --loss`.
fn losses() -> String {
    let named = AnyLoss::ALL.iter().map(|(name, description)| format!("{name} ({description})"));
    format!(
        "Loss, averaged over the recordings: {}. Fields as in a curriculum, lists with slashes: \
         squared:weights=100/100/1/1, huber:thresholds=0.5/5/2/2,weights=1/1/1/1, \
         masked:every=4,intervals_s=0..10/20..30,of=normalised",
        named.collect::<Vec<_>>().join(", ")
    )
}

/// Help of `pam gradient --method`.
fn gradient_methods() -> String {
    let named = GradientChoice::ALL.iter().map(|(name, c)| format!("{name} ({})", c.describe()));
    format!(
        "Gradient method: exact (closed form, for networks of leaky_relu or relu), {}, or auto: exact where \
         it applies, else adjoint",
        named.collect::<Vec<_>>().join(", ")
    )
}

/// Arguments of `pam demo`.
#[derive(Debug, Args)]
pub struct DemoArguments {
    /// Folder for the recording, the predictions and the report
    #[arg(long, value_name = "DIR", default_value = "pam-demo")]
    pub out: PathBuf,
}

impl Default for DemoArguments {
    fn default() -> Self {
        Self { out: PathBuf::from("pam-demo") }
    }
}
