//! The files of a run.
//!
//! | file | holds |
//! |---|---|
//! | `curriculum.toml` | the curriculum with all overrides |
//! | `checkpoint.json` | the state, every few seconds and at the end of each stage |
//! | `metrics.csv` | one row an epoch |
//! | `events.out.tfevents.pam` | the same for TensorBoard |
//! | `stages/NN.safetensors` | the best model of each stage |
//! | `model.safetensors` | the trained model |
//!
//! Every file is complete or absent, but for rows at the end of `metrics.csv` that are younger than the
//! checkpoint; a run that is resumed drops them and makes them again.

use super::error::TrainingError;
use super::state::{EpochRow, StageResult, TrainingState};
use super::trainer::Trainer;
use crate::events::EventFile;
use pam_core::AnyForce;
use pam_data::atomic::write_atomic;
use pam_data::models::safetensors_file;
use pam_data::read_limit::read_text;
use pam_data::{DataError, ModelInfo, document};
use pam_effects::ExtendedModel;
use pam_numerics::ContentHash;
use serde::{Deserialize, Serialize};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// How a run is kept.
#[derive(Debug, Clone, PartialEq)]
pub struct RunSettings {
    /// Time between checkpoints.
    pub checkpoint_every: Duration,
    /// Name of the trained model.
    pub model_name: String,
    /// Program, version and commit.
    pub made_by: String,
}

/// The result of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainedRun {
    /// Whether all stages were done; if not, it was asked to stop and can be resumed.
    pub finished: bool,
    /// Results of the stages.
    pub results: Vec<StageResult>,
    /// Messages for the reader.
    pub events: Vec<String>,
    /// All epochs.
    pub rows: Vec<EpochRow>,
}

#[derive(Serialize, Deserialize)]
struct Checkpoint {
    format: u32,
    seed: u64,
    /// Fingerprint of the recordings.
    data: String,
    /// Fingerprint of everything else that decides how training goes on.
    settings: String,
    /// Of the other fields.
    checksum: String,
    state: TrainingState,
}

const FORMAT: u32 = 4;

/// The part of a checkpoint that is read first.
#[derive(Deserialize)]
struct Version {
    format: u32,
}

impl Checkpoint {
    /// The checkpoint as text, and the checksum of that text without the checksum itself.
    fn sealed(mut self) -> Result<(String, String), document::DocumentError> {
        self.checksum = String::new();
        let mut hash = ContentHash::default();
        hash.text(&document::to_json(&self)?);
        self.checksum = hash.hex();
        Ok((document::to_json(&self)?, self.checksum))
    }
}

/// The folder of a run.
#[derive(Debug)]
pub struct RunFolder {
    path: PathBuf,
}

impl RunFolder {
    /// The folder at a path; it need not exist.
    #[must_use]
    pub fn new(path: impl AsRef<Path>) -> Self {
        let path = path.as_ref();
        Self { path: path.to_owned() }
    }

    /// A file of the folder.
    #[must_use]
    pub fn file(&self, name: &str) -> PathBuf {
        self.path.join(name)
    }

    /// Whether a run was begun here.
    #[must_use]
    pub fn has_checkpoint(&self) -> bool {
        self.file("checkpoint.json").exists()
    }

    /// The curriculum of the run that was begun here, as text.
    ///
    /// # Errors
    /// [`DataError::Io`].
    pub fn curriculum_text(&self) -> Result<String, DataError> {
        read_text(self.file("curriculum.toml"))
    }

    fn load(&self, trainer: &mut Trainer) -> Result<(), TrainingError> {
        let path = self.file("checkpoint.json");
        let io = |source| DataError::Io { path: path.clone(), source };
        let text = read_text(&path)?;
        let fail = |what: &str| TrainingError::Curriculum(format!("{}: {what}", path.display()));
        let version: Version = document::from_json(&text)
            .map_err(|e| fail(&format!("not a checkpoint, or damaged: {e}")))?;
        if version.format != FORMAT {
            return Err(fail("written by another version of the program"));
        }
        let checkpoint: Checkpoint = document::from_json(&text)
            .map_err(|e| fail(&format!("not a checkpoint, or damaged: {e}")))?;
        let stated = checkpoint.checksum.clone();
        let (_, checksum) = checkpoint.sealed().map_err(|e| io(std::io::Error::other(e)))?;
        if checksum != stated {
            return Err(fail(
                "its checksum is not that of its content: it was edited or damaged; train anew in another folder",
            ));
        }
        let checkpoint: Checkpoint =
            document::from_json(&text).map_err(|e| io(std::io::Error::other(e)))?;
        if checkpoint.seed != trainer.seed {
            return Err(fail(&format!("the run was begun with --seed {}", checkpoint.seed)));
        }
        if checkpoint.data != trainer.fingerprint() {
            return Err(fail("the run was begun on other recordings"));
        }
        if checkpoint.settings != trainer.settings_fingerprint()? {
            return Err(fail(
                "the run was begun with another curriculum, other effects, another model to start from or other \
                 mass surfaces",
            ));
        }
        trainer.resume(checkpoint.state)
    }

    fn save(&self, trainer: &Trainer) -> Result<(), TrainingError> {
        let checkpoint = Checkpoint {
            format: FORMAT,
            seed: trainer.seed,
            data: trainer.fingerprint(),
            settings: trainer.settings_fingerprint()?,
            checksum: String::new(),
            state: trainer.state().clone(),
        };
        let path = self.file("checkpoint.json");
        let (text, _) = checkpoint
            .sealed()
            .map_err(|e| DataError::Io { path: path.clone(), source: std::io::Error::other(e) })?;
        Ok(write_atomic(&path, text.as_bytes())?)
    }

    fn save_model(
        &self,
        name: &str,
        trainer: &Trainer,
        settings: &RunSettings,
    ) -> Result<(), TrainingError> {
        let model = trainer.model();
        let curriculum = trainer.curriculum();
        let extended = ExtendedModel {
            joint: model.map(|v| v, |force| AnyForce::Network(force.clone())),
            effects: trainer.effects(),
            info: ModelInfo {
                name: settings.model_name.clone(),
                provenance: format!(
                    "{}: curriculum {}, seed {}, trained on {} recordings",
                    settings.made_by,
                    curriculum.name,
                    trainer.seed,
                    trainer.trained_on().len()
                ),
                trained: true,
                trained_on: trainer.trained_on(),
                effects: Vec::new(),
                rig: curriculum.model.rig.clone(),
                source: None,
            },
        };
        Ok(safetensors_file::write(self.file(name), &extended.to_saved())?)
    }

    /// Rows of `metrics.csv` up to an epoch.
    fn rows_until(&self, epochs: usize, effects: usize) -> Result<Vec<EpochRow>, TrainingError> {
        let path = self.file("metrics.csv");
        if !path.exists() {
            return Ok(Vec::new());
        }
        let text = read_text(&path)?;
        // The last row of a killed run may be cut short: whatever does not read is made again.
        Ok(text
            .lines()
            .skip(1)
            .map_while(|line| row_from(line, effects))
            .filter(|r| r.total_epoch <= epochs)
            .collect())
    }
}

const HEADER: &str = "stage,epoch,total_epoch,loss,rate,gradient_norm,mass_kg,deformation,\
    held_out_r2_x,held_out_r2_v,held_out_r2_pf,held_out_r2_pe,seconds";

fn line_of(row: &EpochRow) -> String {
    // Empty where it was not scored.
    let scores =
        row.r2_held_out.map_or([const { String::new() }; 4], |r2| r2.map(|v| v.to_string()));
    let effects: String = row.effects.iter().map(|v| format!(",{v}")).collect();
    format!(
        "{},{},{},{},{},{},{},{},{},{:.6}{effects}\n",
        row.stage,
        row.epoch,
        row.total_epoch,
        row.loss,
        row.rate,
        row.gradient_norm,
        row.mass_kg,
        row.deformation,
        scores.join(","),
        row.seconds
    )
}

/// A row with so many effect values.
fn row_from(line: &str, effects: usize) -> Option<EpochRow> {
    let cells: Vec<&str> = line.split(',').collect();
    let [
        stage,
        epoch,
        total,
        loss,
        rate,
        norm,
        mass,
        deformation,
        x,
        v,
        pf,
        pe,
        seconds,
        ref values @ ..,
    ] = cells[..]
    else {
        return None;
    };
    if values.len() != effects {
        return None;
    }
    let r2_held_out = if x.is_empty() {
        None
    } else {
        Some([x.parse().ok()?, v.parse().ok()?, pf.parse().ok()?, pe.parse().ok()?])
    };
    Some(EpochRow {
        stage: stage.parse().ok()?,
        epoch: epoch.parse().ok()?,
        total_epoch: total.parse().ok()?,
        loss: loss.parse().ok()?,
        rate: rate.parse().ok()?,
        gradient_norm: norm.parse().ok()?,
        mass_kg: mass.parse().ok()?,
        deformation: deformation.parse().ok()?,
        effects: values.iter().map(|v| v.parse().ok()).collect::<Option<_>>()?,
        r2_held_out,
        seconds: seconds.parse().ok()?,
    })
}

/// Carries a curriculum out in a folder. With `resume` it goes on from the checkpoint there.
/// `observe` is called after every epoch; when `stop` becomes true the running epoch is finished, the state
/// saved, and the run can be resumed.
///
/// # Errors
/// [`TrainingError`]; what was reached is saved before.
pub fn train_into(
    trainer: &mut Trainer,
    folder: &RunFolder,
    settings: &RunSettings,
    resume: bool,
    stop: &AtomicBool,
    observe: &mut dyn FnMut(&EpochRow, &TrainingState),
) -> Result<TrainedRun, TrainingError> {
    if resume {
        folder.load(trainer)?;
    } else {
        write_atomic(folder.file("curriculum.toml"), trainer.curriculum().to_toml().as_bytes())?;
    }
    let names: Vec<String> = trainer.effect_values().into_iter().map(|(name, _)| name).collect();
    let done = if resume { trainer.state().epochs } else { 0 };
    let mut rows = folder.rows_until(done, names.len())?;
    let mut text = HEADER.to_owned();
    names.iter().for_each(|name| text += &format!(",{name}"));
    text.push('\n');
    rows.iter().for_each(|row| text += &line_of(row));
    let metrics_path = folder.file("metrics.csv");
    write_atomic(&metrics_path, text.as_bytes())?;
    let io = |source| DataError::Io { path: metrics_path.clone(), source };
    let mut metrics = std::fs::OpenOptions::new().append(true).open(&metrics_path).map_err(io)?;
    let mut events = EventFile::rewrite(
        folder.file(EVENTS),
        &rows.iter().flat_map(|row| scalars(row, &names)).collect::<Vec<_>>(),
    )?;
    if !resume {
        folder.save(trainer)?;
    }

    let mut saved = Instant::now();
    let mut pending = String::new();
    let outcome = loop {
        if trainer.is_done() {
            break Ok(true);
        }
        if stop.load(Ordering::Relaxed) {
            break Ok(false);
        }
        let stages_done = trainer.state().results.len();
        let row = match trainer.advance() {
            Ok(Some(row)) => row,
            Ok(None) => break Ok(true),
            Err(e) => break Err(e),
        };
        observe(&row, trainer.state());
        let _ = write!(pending, "{}", line_of(&row));
        for (tag, step, time, value) in scalars(&row, &names) {
            events.scalar(&tag, step, time, value)?;
        }
        rows.push(row);
        let stage_over = trainer.state().results.len() > stages_done;
        if stage_over {
            let name = format!("stages/{:02}.safetensors", trainer.state().results.len());
            folder.save_model(&name, trainer, settings)?;
        }
        if stage_over || saved.elapsed() >= settings.checkpoint_every {
            metrics.write_all(pending.as_bytes()).map_err(io)?;
            pending.clear();
            events.flush()?;
            folder.save(trainer)?;
            saved = Instant::now();
        }
    };
    metrics.write_all(pending.as_bytes()).map_err(io)?;
    events.flush()?;
    folder.save(trainer)?;
    let finished = outcome?;
    if finished {
        folder.save_model("model.safetensors", trainer, settings)?;
    }
    let state = trainer.state();
    Ok(TrainedRun { finished, results: state.results.clone(), events: state.events.clone(), rows })
}

const EVENTS: &str = "events.out.tfevents.pam";

/// A row for TensorBoard: tag, step, time, value.
fn scalars(row: &EpochRow, effects: &[String]) -> Vec<(String, i64, f64, f32)> {
    let time = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |d| d.as_secs_f64());
    let step = row.total_epoch as i64;
    let held_out = row.r2_held_out.into_iter().flat_map(|r2| {
        ["held_out/r2_x", "held_out/r2_v", "held_out/r2_pf", "held_out/r2_pe"].into_iter().zip(r2)
    });
    let effects = effects.iter().map(|name| format!("effects/{name}")).zip(row.effects.clone());
    [
        ("loss", row.loss),
        ("rate", row.rate),
        ("gradient_norm", row.gradient_norm),
        ("mass_kg", row.mass_kg),
        ("deformation", row.deformation),
        ("epoch_seconds", row.seconds),
    ]
    .into_iter()
    .chain(held_out)
    .map(|(tag, value)| (tag.to_owned(), value))
    .chain(effects)
    .map(|(tag, value)| (tag, step, time, value as f32))
    .collect()
}
