//! The experiment that trains a model in each cell.
//!
//! A cell is a curriculum with some of its values changed, a set of recordings, and a seed. It is known by their
//! content: a sweep goes on where the folders of sweep, curriculum and recordings were moved or are mounted
//! elsewhere, and differs where any sample differs. Besides the
//! curriculum's own keys (`model.activation`, `solver.gradient`, `stage.2.epochs`, …) an axis can set
//! those of [`CellSettings`]: `curriculum`, `recordings`, `subset`, `seconds`, `stiffness.scheme`,
//! `stiffness.step_mm`.
//!
//! Metrics of a cell:
//!
//! | metric | |
//! |---|---|
//! | `train_r2_x`, `_v`, `_pf`, `_pe` | mean R² over the recordings of the last stage |
//! | `held_out_r2_x`, `_v`, `_pf`, `_pe` | mean R² over the held-out recordings |
//! | `loss` | best loss of the last stage |
//! | `epochs` | epochs of all stages |
//! | `mass_kg`, `deformation` | m and ν |
//! | `rollbacks` | epochs that diverged and were done again |
//! | `stiffness_…` | see [`stiffness`] |

mod settings;
pub mod stiffness;

pub use settings::CellSettings;
pub use stiffness::StiffnessProbe;

use crate::experiment::{Experiment, Measurements, Outcome, Problem, Workplace};
use crate::sweep::{Cell, Sweep};
use pam_data::fingerprint::fingerprint;
use pam_data::{LoadOptions, Recording, collect_paths, read_files};
use pam_train::curriculum::{Curriculum, SplitRole};
use pam_train::training::{RunFolder, RunSettings, Trainer, train_into};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::SliceRandom;
use serde_json::{Value, json};
use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};
use std::time::Duration;

type Recordings = Arc<Vec<Recording>>;

/// Recordings by the paths that a cell names, with their digest.
type Read = HashMap<Vec<PathBuf>, (Recordings, String)>;

/// Trains a model in each cell.
#[derive(Debug)]
pub struct TrainingExperiment {
    base: PathBuf,
    experiment: toml::Table,
    load: LoadOptions,
    checkpoint_every: Duration,
    made_by: String,
    read: Mutex<Read>,
    /// Digests that stand for data which need not be there.
    stored: BTreeMap<String, String>,
    /// True if data without such a digest are read.
    reads: bool,
}

impl TrainingExperiment {
    /// The experiment that a sweep asks for.
    #[must_use]
    pub fn new(sweep: &Sweep, load: LoadOptions, made_by: &str) -> Self {
        Self {
            base: sweep.base.clone(),
            experiment: sweep.experiment.clone(),
            load,
            checkpoint_every: Duration::from_secs(10),
            made_by: made_by.to_owned(),
            read: Mutex::default(),
            stored: BTreeMap::new(),
            reads: true,
        }
    }

    /// The experiment with another time between checkpoints; what was done since the last one is done
    /// again after a crash.
    #[must_use]
    pub fn with_checkpoints(mut self, every: Duration) -> Self {
        self.checkpoint_every = every;
        self
    }

    /// The experiment of a sweep whose cells are only looked at: no data are read. Cells whose data the sweep
    /// has digests of ([`Sweep::data`]) have their names; others have names that no run gives them.
    #[must_use]
    pub fn without_data(sweep: &Sweep, made_by: &str) -> Self {
        let stored = sweep.data.clone();
        Self { stored, reads: false, ..Self::new(sweep, LoadOptions::default(), made_by) }
    }

    /// Digests of the data of all cells that were planned, for [`Sweep::data`].
    #[must_use]
    pub fn digests(&self) -> BTreeMap<String, String> {
        let read = self.read.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let own = read.iter().map(|(paths, (_, digest))| (key(paths), digest.clone()));
        self.stored.clone().into_iter().chain(own).collect()
    }

    /// The settings and the curriculum of a cell.
    ///
    /// # Errors
    /// [`Problem`] naming the assignment that makes no sense.
    pub fn settings(&self, cell: &Cell) -> Result<(CellSettings, Curriculum), Problem> {
        CellSettings::of(&self.experiment, &self.base, &cell.assignments)
    }

    /// Reads the recordings of some files or folders, once for all cells, and digests them.
    fn read(&self, paths: &[PathBuf]) -> Result<(Recordings, String), Problem> {
        // Cells that need the same files wait for the one that reads them.
        let mut read = self.read.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some((recordings, digest)) = read.get(paths) {
            return Ok((Arc::clone(recordings), digest.clone()));
        }
        let absolute: Vec<PathBuf> = paths.iter().map(|p| self.base.join(p)).collect();
        let fail = |e: pam_data::DataError| Problem::new(e.to_string());
        let files = collect_paths(&absolute).map_err(fail)?;
        let found: Recordings = Arc::new(read_files(&files, &self.load, &|| {}).map_err(fail)?);
        let digest = format!("{} recordings, {}", found.len(), fingerprint(&*found));
        read.insert(paths.to_vec(), (Arc::clone(&found), digest.clone()));
        Ok((found, digest))
    }

    /// The recordings that a cell trains on or holds out.
    fn selected(
        &self,
        settings: &CellSettings,
        curriculum: &Curriculum,
        seed: u64,
    ) -> Result<Vec<Recording>, Problem> {
        let (all, _) = self.read(&settings.recordings)?;
        let names: Vec<&str> = all.iter().map(|r| r.name.as_str()).collect();
        let roles = curriculum.data.roles(&names);
        let trained = |r: &&Recording| {
            all.iter().zip(&roles).any(|(a, role)| a.name == r.name && *role == SplitRole::Train)
        };
        let mut train: Vec<&Recording> = all.iter().filter(trained).collect();
        if let Some(subset) = settings.subset {
            if subset > train.len() {
                return Err(Problem::new(format!(
                    "subset = {subset}, but data.train selects {} recordings",
                    train.len()
                )));
            }
            // The first of one order for each seed, so that larger subsets hold the smaller ones.
            let order_seed = seed ^ SUBSET_STREAM;
            train.shuffle(&mut ChaCha8Rng::seed_from_u64(order_seed));
            train.truncate(subset);
        }
        let kept = |r: &&Recording| !trained(r) || train.iter().any(|t| t.name == r.name);
        let cut = |r: &Recording| match settings.seconds {
            None => r.clone(),
            Some(seconds) => {
                let end = r.span_s().0 + seconds;
                r.slice(0..r.time_s.partition_point(|&t| t <= end))
            }
        };
        Ok(all.iter().filter(kept).map(cut).collect())
    }
}

/// Some paths as one text.
fn key(paths: &[PathBuf]) -> String {
    paths.iter().map(|p| p.display().to_string()).collect::<Vec<_>>().join(", ")
}

/// Keeps the draw of recordings apart from that of weights.
const SUBSET_STREAM: u64 = 0x7375_6273_6574;

const CHANNELS: [&str; 4] = ["x", "v", "pf", "pe"];

impl Experiment for TrainingExperiment {
    fn configuration(&self, cell: &Cell) -> Result<Value, Problem> {
        let (settings, curriculum) = self.settings(cell)?;
        let digest = match self.stored.get(&key(&settings.recordings)) {
            Some(digest) => digest.clone(),
            None if self.reads => self.read(&settings.recordings)?.1,
            None => key(&settings.recordings),
        };
        // Paths lead elsewhere on another machine; what they lead to decides the numbers.
        let mut settings = json!(settings);
        settings["recordings"] = digest.into();
        settings["curriculum"] = curriculum.name.as_str().into();
        Ok(json!({ "settings": settings, "curriculum": curriculum }))
    }

    fn run(&self, cell: &Cell, at: &Workplace<'_>) -> Result<Outcome, Problem> {
        let (settings, mut curriculum) = self.settings(cell)?;
        let (all, _) = self.read(&settings.recordings)?;
        let names: Vec<&str> = all.iter().map(|r| r.name.as_str()).collect();
        curriculum.data = curriculum.data.pinned(&names);
        let recordings = self.selected(&settings, &curriculum, cell.seed)?;
        let held_out: Vec<Recording> = if settings.stiffness.is_some() {
            stiffness::subjects(&recordings, &curriculum)
        } else {
            Vec::new()
        };
        let fail = |e: pam_train::training::TrainingError| Problem::new(e.to_string());
        let mut trainer = Trainer::new(curriculum, recordings, None, cell.seed).map_err(fail)?;
        let before: Vec<usize> = trainer
            .curriculum()
            .stages
            .iter()
            .scan(0, |sum, stage| {
                let first = *sum;
                *sum += stage.epochs();
                Some(first)
            })
            .collect();
        let total: usize = trainer.curriculum().stages.iter().map(|s| s.epochs()).sum();
        let folder = RunFolder::new(at.folder);
        let run = RunSettings {
            checkpoint_every: self.checkpoint_every,
            model_name: format!("{} (seed {})", trainer.curriculum().name, cell.seed),
            made_by: self.made_by.clone(),
        };
        let resume = folder.has_checkpoint();
        let trained = train_into(&mut trainer, &folder, &run, resume, at.stop, &mut |row, _| {
            (at.progress)((before[row.stage] + row.epoch) as f64 / total as f64);
        })
        .map_err(fail)?;
        if !trained.finished {
            return Ok(Outcome::Stopped);
        }
        let mut found = Measurements::default();
        if let Some(last) = trained.results.last() {
            for (set, scores) in [("train", last.r2_train), ("held_out", last.r2_held_out)] {
                for (channel, value) in CHANNELS.iter().zip(scores) {
                    let value = value.unwrap_or(f64::NAN);
                    found.metrics.push((format!("{set}_r2_{channel}"), value));
                }
            }
            found.metrics.push(("loss".into(), last.best_loss));
        }
        let epochs: usize = trained.results.iter().map(|r| r.epochs).sum();
        let model = trainer.model();
        let physical = model.physical();
        found.metrics.extend([
            ("epochs".into(), epochs as f64),
            ("mass_kg".into(), physical.mass_kg),
            ("deformation".into(), physical.deformation),
            ("rollbacks".into(), trained.events.len() as f64),
        ]);
        let seconds: f64 = trained.results.iter().map(|r| r.seconds).sum();
        found.times.push(("train_s".into(), seconds));
        found.times.push(("epoch_s".into(), seconds / epochs.max(1) as f64));
        found.notes = trained.events;
        if let Some(probe) = &settings.stiffness {
            probe.measure(&model, &held_out, &mut found)?;
        }
        Ok(Outcome::Finished(found))
    }
}
