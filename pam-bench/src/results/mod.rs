//! Measured results: one JSON file per study in `results/`, from which the tables and numbers of README, book and changelog are
//! written.
//!
//! A study says with which commands, at which commit and on which machine its numbers were measured. A page refers to a number by
//! `<!--= STUDY.KEY -->` and to a table by `<!--# STUDY.TABLE -->` ([`page::fill`]); [`measure::measure`] runs the commands again.
//!
//! ```
//! use pam_bench::results::{Results, page};
//!
//! let results = Results::read("../results").unwrap();
//! let text = "An epoch takes <!--= peers.epoch_pam_s .2 --><!--/--> s.";
//! assert_eq!(page::fill(text, &results).unwrap(), "An epoch takes <!--= peers.epoch_pam_s .2 -->0.41<!--/--> s.");
//! ```

pub mod measure;
pub mod page;
mod study;
mod unmarked;

pub use study::{CellReference, Measured, Source, Study, Table};
pub use unmarked::unmarked;

use pam_data::DataError;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Results that cannot be read, used or measured.
#[derive(Debug, Error)]
pub enum ResultsError {
    /// A file cannot be read or written.
    #[error(transparent)]
    File(#[from] DataError),
    /// A page or a study names something that no study has.
    #[error("`{name}` is in no file of results/: {hint}")]
    Unknown {
        /// The name, as `STUDY.KEY`.
        name: String,
        /// Names that exist.
        hint: String,
    },
    /// A marker of a page cannot be read.
    #[error("line {line}: {message}")]
    Marker {
        /// Line of the page, counted from one.
        line: usize,
        /// The problem and its remedy.
        message: String,
    },
    /// A command of a study failed.
    #[error("`{command}` failed ({status}): the results stay as they are")]
    Command {
        /// The command.
        command: String,
        /// Its exit status.
        status: String,
    },
    /// A command did not write what a study reads from it.
    #[error("{}: {message}", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
        /// The missing number or columns.
        message: String,
    },
}

/// All studies of a folder, by name.
#[derive(Debug, Clone, Default)]
pub struct Results {
    /// The studies: `peers` is that of `peers.json`.
    pub studies: BTreeMap<String, Study>,
}

impl Results {
    /// Reads every `NAME.json` of `folder`; other files and subfolders, such as the rows of a study, are ignored.
    ///
    /// # Errors
    /// [`ResultsError::File`] if a file cannot be read or is no study; [`ResultsError::Unknown`] if a value refers to a cell that
    /// does not exist.
    pub fn read(folder: impl AsRef<Path>) -> Result<Self, ResultsError> {
        let folder = folder.as_ref();
        let mut studies = BTreeMap::new();
        for entry in std::fs::read_dir(folder).map_err(|e| DataError::io(folder, e))? {
            let path = entry.map_err(|e| DataError::io(folder, e))?.path();
            if path.extension().is_some_and(|e| e == "json") {
                let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
                studies.insert(name, Study::read(&path)?);
            }
        }
        let results = Self { studies };
        for (study, content) in &results.studies {
            for key in content.values.keys() {
                results.number(&format!("{study}.{key}"))?;
            }
        }
        Ok(results)
    }

    /// The number `STUDY.KEY`, in its unit; `STUDY.KEY.low` and `.high` are the limits of its interval, `.spread` its spread.
    ///
    /// # Errors
    /// [`ResultsError::Unknown`] if there is none.
    pub fn number(&self, name: &str) -> Result<f64, ResultsError> {
        let unknown = |hint: String| ResultsError::Unknown { name: name.into(), hint };
        let mut parts = name.split('.');
        let (study, key) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
        let content = self.study(study, name)?;
        let measured = content.values.get(key).ok_or_else(|| {
            unknown(format!(
                "`{study}` has {}",
                content.values.keys().cloned().collect::<Vec<_>>().join(", ")
            ))
        })?;
        let number = match parts.next() {
            None => content.value_of(measured),
            Some("low") => measured.low,
            Some("high") => measured.high,
            Some("spread") => measured.spread,
            Some(_) => return Err(unknown("after the key come `low`, `high` or `spread`".into())),
        };
        number.ok_or_else(|| {
            unknown("it has no such number, or refers to a cell that is none".into())
        })
    }

    /// The table `STUDY.TABLE`.
    ///
    /// # Errors
    /// [`ResultsError::Unknown`] if there is none.
    pub fn table(&self, name: &str) -> Result<&Table, ResultsError> {
        let (study, key) = name.split_once('.').unwrap_or((name, ""));
        let content = self.study(study, name)?;
        content.tables.get(key).ok_or_else(|| ResultsError::Unknown {
            name: name.into(),
            hint: format!(
                "`{study}` has {}",
                content.tables.keys().cloned().collect::<Vec<_>>().join(", ")
            ),
        })
    }

    fn study(&self, study: &str, name: &str) -> Result<&Study, ResultsError> {
        self.studies.get(study).ok_or_else(|| ResultsError::Unknown {
            name: name.into(),
            hint: format!(
                "there are {}",
                self.studies.keys().cloned().collect::<Vec<_>>().join(", ")
            ),
        })
    }
}
