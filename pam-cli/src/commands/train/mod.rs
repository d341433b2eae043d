//! `pam train`.

mod results;

use super::RunCommand;
use crate::arguments::GlobalOptions;
use crate::console::Console;
use crate::error::CliError;
use crate::interrupt::{seconds, stop_flag};
use crate::memory::return_large_blocks;
use crate::options::{DataOptions, built_in_spring_damper, check_plausible};
use crate::output::Output;
use crate::run_record::{self, made_by};
use clap::Args;
use pam_data::{MassChoice, MassOptions, Recording, RigFile, Subject, toml_file};
use pam_report::page::number;
use pam_solvers::Tableau;
use pam_train::curriculum::{Curriculum, StartModel};
use pam_train::training::{
    RunFolder, RunSettings, StageResult, TrainedRun, Trainer, TrainingError, effects_of, train_into,
};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Arguments of `pam train`.
#[derive(Debug, Args)]
pub struct TrainArguments {
    /// Curriculum.
    #[arg(default_value = "recommended", value_name = "NAME|FILE", help = curricula())]
    pub curriculum: String,
    /// Recordings, or folders of them
    #[arg(long, num_args = 1.., required_unless_present = "print", value_name = "PATH")]
    pub data: Vec<PathBuf>,
    /// Recordings to train on, by name or pattern (`monday-*`); the same as --set data.train=… [default: the
    /// published training conditions, or all that are not held out]
    #[arg(long, num_args = 1.., value_name = "NAME", conflicts_with = "resume")]
    pub train: Vec<String>,
    /// Recordings to score on and never train on: names, patterns, or a share (`0.2`) that is drawn by data.split_seed
    /// [default: the others; a fifth, where recordings are not named after pressures, or the end of a single one]
    #[arg(long, num_args = 1.., value_name = "NAME|SHARE", conflicts_with = "resume")]
    pub heldout: Vec<String>,
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
    /// Resume the run in the folder, from its last checkpoint and with its curriculum
    #[arg(long, conflicts_with = "overrides")]
    pub resume: bool,
    /// Seconds between checkpoints
    #[arg(long, default_value_t = 10.0, value_name = "S")]
    pub checkpoint_s: f64,
    /// Print the curriculum as TOML and exit
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
        "Solver: exact (leaky_relu or relu), {}, or auto; the same as --set \
         solver.method=NAME",
        Tableau::NAMES.join(", ")
    )
}

impl RunCommand for TrainArguments {
    fn outputs(&self) -> Vec<Output<'_>> {
        let out = self.out.as_deref().filter(|_| !self.print);
        out.map(|path| Output::Folder("train", path)).into_iter().collect()
    }

    fn run(&self, global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        return_large_blocks();
        if self.print {
            let curriculum = Curriculum::open(&self.curriculum, &overrides(self, global)?)?;
            console.json(&serde_json::to_value(&curriculum).unwrap_or(Value::Null));
            console.text(curriculum.to_toml().trim_end());
            return Ok(ExitCode::SUCCESS);
        }
        let out = self.out.as_deref().unwrap_or(Path::new("."));
        let folder = RunFolder::new(out);
        let curriculum = curriculum(self, &folder, global)?;
        let checkpoint_every = seconds("--checkpoint-s", self.checkpoint_s, true)?;

        let masses = self.reading.mass_options()?;
        // Training takes the masses of the files, then those of surfaces while the model is untrained, then the gas law.
        let surfaces = masses.surfaces.filter(|_| masses.choice != MassChoice::GasLaw);
        if let StartModel::File(path) = &curriculum.model.start {
            if !path.exists() {
                return Err(CliError::Usage(format!(
                    "the model to start from, {}, is not there; name it with --start FILE",
                    path.display()
                )));
            }
            if masses.choice == MassChoice::Surfaces {
                return Err(CliError::Usage(
                    "--masses surfaces: training that starts from a model takes the masses from its gas law".into(),
                ));
            }
        }
        let effects = effects_of(&curriculum, &[])?;
        let rig = global.rig_for(&self.data)?;
        let reading = self.reading.for_model(!effects.is_empty());
        let recordings = reading.recordings(&self.data, rig.clone(), console)?;
        let recordings = checked(recordings, rig.as_ref(), global, console)?;
        let names: Vec<&str> = recordings.iter().map(|r| r.name.as_str()).collect();
        curriculum.data.check_names(&names).map_err(CliError::Failed)?;
        let mut trainer =
            Trainer::extended(curriculum, recordings, surfaces, effects, global.seed)?;
        console.text(format!(
            "{}: {} recordings to train on, {} held out.",
            trainer.curriculum().name,
            trainer.trained_on().len(),
            trainer.held_out_len()
        ));
        let effects = trainer.effect_values();
        if !effects.is_empty() {
            let from: Vec<String> =
                effects.iter().map(|(name, v)| format!("{name} = {}", number(*v, 4))).collect();
            console.text(format!("Effects: {}.", from.join(", ")));
        }

        let settings = RunSettings {
            checkpoint_every,
            model_name: format!(
                "hybrid joint, {} (seed {})",
                trainer.curriculum().name,
                global.seed
            ),
            made_by: made_by(),
        };
        let configuration = json!({
            "curriculum": trainer.curriculum(),
            "data": self.data,
            "reading": self.reading.to_json(global)?,
        });
        run_record::write(out, "train", global.seed, &configuration)?;
        let trained = train(&mut trainer, &folder, &settings, self.resume, console)?;
        results::finish(&trainer, &trained, out, console)
    }
}

/// Checks recordings against the physics of the joint, with the data sheet's model: before training there is no
/// other.
fn checked(
    recordings: Vec<Recording>,
    rig: Option<&RigFile>,
    global: &GlobalOptions,
    console: &Console,
) -> Result<Vec<Recording>, CliError> {
    let saved = built_in_spring_damper(rig);
    let subjects = Subject::resolve(recordings, &saved, &MassOptions::default())?;
    check_plausible(&saved, &subjects, global, console)?;
    Ok(subjects.into_iter().map(|s| s.recording).collect())
}

/// The curriculum of the arguments, or that of the run that is resumed.
fn curriculum(
    arguments: &TrainArguments,
    folder: &RunFolder,
    global: &GlobalOptions,
) -> Result<Curriculum, CliError> {
    if arguments.resume {
        if !folder.has_checkpoint() {
            return Err(CliError::Usage(
                "--resume: no run was begun in the folder of --out".into(),
            ));
        }
        let path = folder.file("curriculum.toml");
        return Ok(Curriculum::parse(&folder.curriculum_text()?, &path, &[])?);
    }
    if folder.has_checkpoint() {
        return Err(CliError::Usage(
            "the folder of --out holds a run; give another one, or --resume".into(),
        ));
    }
    Ok(Curriculum::open(&arguments.curriculum, &overrides(arguments, global)?)?)
}

/// Overrides of the curriculum, the method first.
fn overrides(arguments: &TrainArguments, global: &GlobalOptions) -> Result<Vec<String>, CliError> {
    let mut all = Vec::new();
    if let Some(rig) = global.rig_for(&arguments.data)? {
        let rig = toml_file::inline(&rig).map_err(CliError::Failed)?;
        all.push(format!("model.rig={rig}"));
    }
    if !arguments.train.is_empty() {
        all.push(format!("data.train={}", json!(arguments.train)));
    }
    match &arguments.heldout[..] {
        [] => {
            // Recordings that --train does not select are held out.
            if !arguments.train.is_empty() {
                all.push("data.held_out=\"rest\"".into());
            }
        }
        heldout => {
            all.push(match heldout {
                [share] if share.parse::<f64>().is_ok_and(|s| s > 0.0 && s < 1.0) => {
                    format!("data.held_out={share}")
                }
                names => format!("data.held_out={}", json!(names)),
            });
            if arguments.train.is_empty() {
                all.push("data.train=\"rest\"".into());
            }
        }
    }
    let method = arguments.method.iter().map(|name| format!("solver.method={name}"));
    // A path is text, whatever is in it.
    let start = arguments.start.iter().map(|path| {
        let quoted = serde_json::Value::String(path.display().to_string());
        format!("model.start={{ file = {quoted} }}")
    });
    all.extend(method.chain(start).chain(arguments.overrides.iter().cloned()));
    Ok(all)
}

fn train(
    trainer: &mut Trainer,
    folder: &RunFolder,
    settings: &RunSettings,
    resume: bool,
    console: &Console,
) -> Result<TrainedRun, TrainingError> {
    let stop = stop_flag();
    let total: usize = trainer.curriculum().stages.iter().map(|s| s.epochs()).sum();
    let bar = console.progress(total, "training");
    let names: Vec<(String, usize)> =
        trainer.curriculum().stages.iter().map(|s| (s.name().to_owned(), s.epochs())).collect();
    let mut told = trainer.state().results.len();
    let mut events = 0;
    let trained = train_into(trainer, folder, settings, resume, stop, &mut |row, state| {
        // Stages that stop early count as done.
        let before: usize = names[..row.stage].iter().map(|(_, epochs)| epochs).sum();
        bar.set_position((before + row.epoch) as u64);
        bar.set_message(format!("{}  loss {:.4}", names[row.stage].0, row.loss));
        for event in &state.events[events.min(state.events.len())..] {
            bar.suspend(|| console.warn(event));
        }
        events = state.events.len();
        for result in &state.results[told.min(state.results.len())..] {
            bar.suspend(|| console.text(stage_line(result)));
        }
        told = state.results.len();
    });
    bar.finish_and_clear();
    trained
}

/// Result of a stage in one line.
fn stage_line(r: &StageResult) -> String {
    let r2 = |values: &[Option<f64>; 4]| {
        let cells: Vec<String> =
            values.iter().map(|v| v.map_or("–".into(), |v| format!("{v:.4}"))).collect();
        cells.join(" ")
    };
    format!(
        "  {} ({} epochs, {:.1} s): loss {:.5}, R² x v pf pe: trained on {}, held out {}",
        r.name,
        r.epochs,
        r.seconds,
        r.best_loss,
        r2(&r.r2_train),
        r2(&r.r2_held_out)
    )
}
