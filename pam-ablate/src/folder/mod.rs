//! The folder of a sweep.
//!
//! | file | holds |
//! |---|---|
//! | `sweep.json` | the sweep, with all overrides |
//! | `sweep.lock` | locked while a process starts |
//! | `cells/ID/claim` | who works or worked on the cell; locked as long as somebody does |
//! | `cells/ID/work/` | what the cell keeps while it runs: checkpoint, metrics, models |
//! | `cells/ID/result.json` | numbers, or why it failed |
//! | `results.csv`, `results.parquet` (feature `parquet`) | one row per cell, the same bytes every time |
//! | `times.csv` | times of the cells |
//! | `summary.csv`, `summary.json`, `summary.md` | means and paired differences |
//! | `report.html` | tables and figures |
//!
//! Several processes on several machines may work in one folder; see [`claim`].

pub mod claim;
mod merge;
mod record;

pub use claim::{Claim, Claimed};
pub use merge::merge;
pub use record::{CellRecord, Quantity, Status};

use crate::error::AblateError;
use crate::experiment::{Experiment, Problem};
use crate::sweep::{Cell, MOST_CELLS, Sweep};
use pam_data::DataError;
use pam_data::atomic::write_atomic;
use pam_data::document;
use pam_data::read_limit::read_text;
use pam_numerics::ContentHash;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// A cell that knows its name and its configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct Planned {
    /// The cell.
    pub cell: Cell,
    /// Name of its folder: a hash of configuration and seed.
    pub id: String,
    /// Its configuration.
    pub configuration: Value,
}

/// The folder of a sweep.
#[derive(Debug, Clone)]
pub struct SweepFolder {
    path: PathBuf,
}

impl SweepFolder {
    /// Begins a sweep in a folder, or goes on with it.
    ///
    /// # Errors
    /// [`AblateError::Folder`] if another sweep is there, unless `extend` says that this one takes its
    /// place: cells that are in both are kept.
    pub fn begin(path: impl AsRef<Path>, sweep: &Sweep, extend: bool) -> Result<Self, AblateError> {
        Self::begin_at(path.as_ref(), sweep, extend)
    }

    /// One instance, whatever the path is given as.
    fn begin_at(path: &Path, sweep: &Sweep, extend: bool) -> Result<Self, AblateError> {
        std::fs::create_dir_all(path).map_err(|e| AblateError::io(path, e))?;
        refuse_foreign(path)?;
        let lock = path.join("sweep.lock");
        let file = claim::open(&lock)?;
        file.lock().map_err(|e| AblateError::io(&lock, e))?;
        let snapshot = path.join("sweep.json");
        let there = if snapshot.exists() { Some(Self::at(path).sweep()?) } else { None };
        match there {
            Some(old) if old.same_as(sweep) => {}
            Some(_) if !extend => {
                return Err(AblateError::folder(
                    path,
                    "it holds another sweep, or the same one on other recordings; give another --out, or \
                     --extend to keep the cells that are in both and add the rest",
                ));
            }
            _ => {
                let mut sweep = sweep.clone();
                sweep.base = std::path::absolute(&sweep.base).unwrap_or(sweep.base);
                let text = format!("{:#}\n", serde_json::to_value(&sweep).unwrap_or(Value::Null));
                write_atomic(&snapshot, text.as_bytes())?;
            }
        }
        Ok(Self::at(path))
    }

    /// The folder at a path, in which a sweep was begun.
    #[must_use]
    pub fn at(path: impl AsRef<Path>) -> Self {
        let path = path.as_ref();
        Self { path: path.to_owned() }
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The sweep that was begun here.
    ///
    /// # Errors
    /// [`AblateError`] if there is none.
    pub fn sweep(&self) -> Result<Sweep, AblateError> {
        let path = self.path.join("sweep.json");
        let text = read_text(&path).map_err(|e| {
            if e.is_missing() {
                AblateError::folder(&self.path, "no sweep was begun here: there is no sweep.json")
            } else {
                e.into()
            }
        })?;
        let mut sweep: Sweep = document::from_json(&text).map_err(|e| {
            let message = format!("{e}; it was written by another version or changed");
            DataError::line(&path, e.line(&text), message)
        })?;
        sweep.path = path;
        Ok(sweep)
    }

    /// The folder of a cell.
    #[must_use]
    pub fn cell(&self, id: &str) -> PathBuf {
        self.path.join("cells").join(id)
    }
}

/// Refuses a folder that holds files, but no sweep.
fn refuse_foreign(path: &Path) -> Result<(), AblateError> {
    if path.join("sweep.json").exists() {
        return Ok(());
    }
    let entries = std::fs::read_dir(path).map_err(|e| AblateError::io(path, e))?;
    // Hidden files are locks and what killed programs left.
    let foreign = entries.flatten().map(|e| e.file_name().to_string_lossy().into_owned());
    let mut foreign: Vec<String> =
        foreign.filter(|name| !name.starts_with('.') && name != "sweep.lock").collect();
    foreign.sort();
    match foreign.first() {
        None => Ok(()),
        Some(first) => Err(AblateError::folder(
            path,
            format!(
                "it holds other files ({first} and {} more) and no sweep; give an empty folder",
                foreign.len() - 1
            ),
        )),
    }
}

/// All cells of a sweep with their names; what is wrong with any is found before the first runs. Draws
/// of a random search that are alike are one.
///
/// # Errors
/// [`AblateError`] with the line that sets what makes no sense.
pub fn plan(sweep: &Sweep, experiment: &dyn Experiment) -> Result<Vec<Planned>, AblateError> {
    let count = sweep.cell_count();
    if count > MOST_CELLS {
        return Err(AblateError::setting(
            format!("sweep `{}`", sweep.name),
            format!(
                "{count} cells are more than the {MOST_CELLS} that are run; take fewer values, draws or seeds"
            ),
        ));
    }
    let mut planned: Vec<Planned> = Vec::new();
    let mut ids = std::collections::HashMap::new();
    for cell in sweep.cells() {
        let configuration =
            experiment.configuration(&cell).map_err(|p| located(sweep, &cell, &p))?;
        let id = id_of(&configuration, cell.seed);
        if let Some(&first) = ids.get(&id) {
            // Draws from short lists may be alike.
            if sweep.search.is_some() {
                continue;
            }
            let first: &Planned = &planned[first];
            return Err(located(
                sweep,
                &cell,
                &Problem::new(format!(
                    "the cells `{}` and `{}` are the same: nothing that they set makes a difference",
                    first.cell.describe(sweep),
                    cell.describe(sweep)
                )),
            ));
        }
        ids.insert(id.clone(), planned.len());
        planned.push(Planned { cell, id, configuration });
    }
    Ok(planned)
}

/// A problem with the place in the sweep file that it comes from.
fn located(sweep: &Sweep, cell: &Cell, problem: &Problem) -> AblateError {
    let blamed = problem.assignment.and_then(|i| cell.assignments.get(i));
    let message = match blamed {
        Some(a) => format!("{} = {}: {}", a.key, a.value, problem.message),
        None => problem.message.clone(),
    };
    match blamed.map_or(sweep.experiment_line, |a| a.line) {
        0 => AblateError::setting(format!("sweep `{}`", sweep.name), message),
        line => DataError::line(&sweep.path, line, message).into(),
    }
}

/// The hash of the text of configuration and seed.
fn id_of(configuration: &Value, seed: u64) -> String {
    let mut hash = ContentHash::default();
    hash.bytes(format!("{configuration} {seed}").as_bytes());
    hash.hex()
}
