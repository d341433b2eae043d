//! The command line.

pub use crate::commands::Command;

use crate::error::CliError;
use clap::{Args, CommandFactory, FromArgMatches, Parser};
use pam_data::{RigFile, rig_of};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// Hybrid neural ODEs of an antagonistic pneumatic-muscle joint.
///
/// Without a command, pam simulates recordings with a hidden effect and diagnoses them with the default model; the
/// report is ./pam-demo/report.html.
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
      --pressures 412,412 --out run.csv         a synthetic run
  pam gradient --model model.eqx --data logs/ --out gradient.npz
                                                loss and exact gradient
  pam rig record --conditions 30/60,45/45 --effect coulomb_friction:force_n=20 --out logs
                                                simulated recordings with a hidden effect
  pam diagnose --model model.eqx --data logs --out found
                                                name what the model gets wrong there
  pam train --data logs --out run               train on recordings; run/model.safetensors
  pam plan --model model.eqx --motion sine:A=1,f=0.1 --stiffness 150 --out plan
                                                pressures for a motion and a stiffness
  pam identify --schedule staircase --out id    identified against commanded stiffness
  pam compare models.toml --out compared        baselines and the hybrid model on one split
  pam ablate activations --data logs --out sweep
                                                train one model per setting, compare
  pam convert model.eqx model.safetensors       published weights to the framework's format";

const EXIT_CODES: &str = "\
Exit codes: 0 success, 1 error in files, data or computation, 2 wrong usage, 3 finished, but some
recordings, samples or cells failed, 130 interrupted, can be resumed.";

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
        let matches = Self::with_exit_codes().try_get_matches().unwrap_or_else(|error| {
            let printed = error.print().is_ok() && std::io::stdout().flush().is_ok();
            let code = if printed { error.exit_code() } else { i32::from(crate::FAILED) };
            std::process::exit(code)
        });
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
    /// Stop after this many seconds with an error; training, comparisons and sweeps are saved first and can be resumed
    #[arg(long, global = true, value_name = "S", allow_negative_numbers = true)]
    pub timeout: Option<f64>,
    /// Refuse files larger than this many MiB, and archives that unpack to more [default: a sixth of the free memory, at
    /// most 512]
    #[arg(long, global = true, value_name = "MIB", value_parser = clap::value_parser!(u64).range(1..))]
    pub max_read_mib: Option<u64>,
    /// Rig file: describes the columns and units of your recordings and the dimensions of your joint
    /// (docs/own-rig.md); `pam rig-file init FILE` writes a draft [default: the one saved in the model, if any]
    #[arg(long, global = true, value_name = "RIG.toml")]
    pub rig_file: Option<PathBuf>,
    /// The contents of `rig_file` once it was read: a command needs them in several places.
    #[arg(skip)]
    rig: OnceLock<RigFile>,
    /// File of effects that are defined by expressions (docs/own-effects.md), which are then known by their ids like
    /// built-in ones; may be repeated
    #[arg(long = "effects-file", global = true, value_name = "FILE.toml")]
    pub effects_files: Vec<PathBuf>,
    /// Use recordings that contradict the physics of the joint (wrong units, swapped columns, flipped signs) all the
    /// same
    #[arg(long, alias = "allow-implausible", global = true)]
    pub accept: bool,
    /// No progress and no text, only errors and, with --json, results
    #[arg(long, short, global = true)]
    pub quiet: bool,
}

impl GlobalOptions {
    /// Makes the effects of `--effects-file` known to models, diagnoses and the virtual rig, each of which evaluates them
    /// on its own.
    ///
    /// # Errors
    /// [`CliError`] with file, line and column.
    pub fn load_effects(&self) -> Result<(), CliError> {
        for path in &self.effects_files {
            for effect in pam_effects::expression::load(path)? {
                pam_effects::effects::register(effect)?;
            }
            pam_rig::effects::expression::load(path)?;
        }
        Ok(())
    }

    /// The rig file of `--rig-file`, which is read once.
    ///
    /// # Errors
    /// [`CliError::Data`] naming the invalid line or key.
    pub fn rig(&self) -> Result<Option<RigFile>, CliError> {
        let Some(path) = self.rig_file.as_deref() else { return Ok(None) };
        if let Some(rig) = self.rig.get() {
            return Ok(Some(rig.clone()));
        }
        let rig = RigFile::read(path)?;
        Ok(Some(self.rig.get_or_init(|| rig).clone()))
    }

    /// The rig file of `--rig-file`, else the rig that these files name as their own, as those of `pam convert` do.
    ///
    /// # Errors
    /// As [`rig`](Self::rig), and [`CliError::Data`] if the files name different rigs.
    pub fn rig_for(&self, files: &[impl AsRef<Path>]) -> Result<Option<RigFile>, CliError> {
        match self.rig()? {
            Some(rig) => Ok(Some(rig)),
            None => Ok(rig_of(files)?),
        }
    }
}

/// Most threads: more than any machine has cores.
const MOST_THREADS: usize = 4096;

fn parse_threads(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(0) => Err("there must be at least one thread".into()),
        Ok(n) if n > MOST_THREADS => Err(format!("there are at most {MOST_THREADS} threads")),
        Ok(n) => Ok(n),
        Err(e) => Err(format!("{e}")),
    }
}
