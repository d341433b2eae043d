//! The commands, one file each: its arguments, and what it does with the library.
//!
//! A new command is a file with a type that implements [`clap::Args`] and [`RunCommand`], and an entry of the
//! list below.

pub mod ablate;
pub mod certify;
pub mod compare;
pub mod completions;
pub mod control;
pub mod convert;
pub mod demo;
pub mod design;
pub mod detect;
pub mod diagnose;
pub mod doctor;
pub mod evaluate;
pub mod gradient;
pub mod inspect;
pub mod man;
pub mod parts;
pub mod rig;
pub mod rig_file;
pub mod simulate;
pub mod train;

use crate::arguments::GlobalOptions;
use crate::console::Console;
use crate::error::CliError;
use crate::output::Output;
use clap::Subcommand;
use std::process::ExitCode;

/// A command: its arguments, which can be run.
pub trait RunCommand {
    /// Outputs of the command. Folders are checked and locked, files checked, before it runs: what cannot be written
    /// is an error before anything is computed.
    fn outputs(&self) -> Vec<Output<'_>> {
        Vec::new()
    }

    /// Runs the command and returns its exit code: success, [`PARTIAL`](crate::PARTIAL) or
    /// [`INTERRUPTED`](crate::INTERRUPTED).
    ///
    /// # Errors
    /// [`CliError`] naming the file with its line and field, or the option.
    fn run(&self, global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError>;
}

/// Makes [`Command`] of a list of names and argument types.
macro_rules! commands {
    ($($(#[$attribute:meta])* $name:ident($arguments:ty),)*) => {
        /// The commands.
        #[derive(Debug, Subcommand)]
        pub enum Command {
            $($(#[$attribute])* $name($arguments),)*
        }

        impl RunCommand for Command {
            fn outputs(&self) -> Vec<Output<'_>> {
                match self {
                    $(Self::$name(arguments) => arguments.outputs(),)*
                }
            }

            fn run(&self, global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
                match self {
                    $(Self::$name(arguments) => arguments.run(global, console),)*
                }
            }
        }
    };
}

commands! {
    /// Describe a log, a recording, a model or another data file
    Inspect(inspect::InspectArguments),
    /// Convert a recording to CSV or .npz, a model to .safetensors or .eqx
    Convert(convert::ConvertArguments),
    /// Simulate the joint under a measured or synthetic force
    Simulate(simulate::SimulateArguments),
    /// Predict recordings with a model and score the predictions
    Evaluate(evaluate::EvaluateArguments),
    /// Compute the loss of a model on recordings and its gradient with respect to every parameter
    Gradient(gradient::GradientArguments),
    /// Train a model on recordings
    Train(train::TrainArguments),
    /// Find what a model gets wrong on recordings, name the cause, and measure the error reduction
    Diagnose(diagnose::DiagnoseArguments),
    /// Foretell which effects a diagnosis would find under a protocol, from which magnitude on, and which it would confuse
    Detect(detect::DetectArguments),
    /// Certify the diagnosis on your rig: hide effects in baseline recordings, diagnose, count, and calibrate its settings
    Certify(certify::CertifyArguments),
    /// Design what to measure next: the protocol that lowers detection limits, or distinguishes the live causes of a diagnosis
    Design(design::DesignArguments),
    /// Map stiffness and damping of a model, and the reachable stiffness
    Stiffness(control::stiffness::StiffnessArguments),
    /// Plan the pressures for a motion and a stiffness
    Plan(control::plan::PlanArguments),
    /// Run the published tracking tests on the virtual rig
    Track(control::track::TrackArguments),
    /// Identify stiffness and damping from pulses, on the virtual rig or in recordings
    Identify(control::identify::IdentifyArguments),
    /// Run receding-horizon MPC on the virtual rig, under a load step or a changed target
    Replan(control::replan::ReplanArguments),
    /// The virtual rig: simulate recordings with known ground truth
    #[command(subcommand)]
    Rig(rig::RigCommand),
    /// Write or check a rig file, which describes your recordings and the dimensions of your joint
    #[command(subcommand)]
    RigFile(rig_file::RigFileCommand),
    /// Run an ablation: train a model for every setting of a grid or random search, and compare seed by seed
    Ablate(ablate::AblateArguments),
    /// Compare baselines and the hybrid model on one split of the data
    Compare(compare::CompareArguments),
    /// List the names of effects, activations and losses
    Parts(parts::PartsArguments),
    /// Hide an effect in simulated recordings and find it; also runs without a command
    Demo(demo::DemoArguments),
    /// Check this machine: version, threads, vector instructions, write access
    Doctor(doctor::DoctorArguments),
    /// Print a completion script for a shell: `pam completions bash > /etc/bash_completion.d/pam`
    Completions(completions::CompletionsArguments),
    /// Write manual pages, one per command
    Man(man::ManArguments),
}
