//! Ablation sweeps: grids and random searches over any setting, that survive being killed and being
//! shared.
//!
//! - [`sweep`]: what is varied, as data: a TOML file or a few calls;
//! - [`experiment`]: what a cell does, a trait; [`training`]: the one that trains models;
//! - [`folder`]: the folder of a sweep, claims on cells, merging;
//! - [`run`]: cells at work, side by side, in shards;
//! - [`table`]: results as CSV and, with the feature `parquet`, Apache Parquet;
//! - [`statistics`]: differences paired by seed; [`summary`]: what a sweep found;
//! - [`report`]: files and the page;
//! - [`slurm`]: job arrays.
//!
//! A sweep of your own experiment:
//!
//! ```
//! use pam_ablate::prelude::*;
//! use std::sync::atomic::AtomicBool;
//!
//! /// How far a pendulum of some length swings in one second, from an angle that the seed draws.
//! struct Pendulum;
//!
//! impl Experiment for Pendulum {
//!     fn configuration(&self, cell: &Cell) -> Result<serde_json::Value, Problem> {
//!         let length = cell.assignments[0].value.as_float().filter(|l| *l > 0.0);
//!         let length = length.ok_or_else(|| Problem::new("length_m must be positive"))?;
//!         Ok(serde_json::json!({ "length_m": length }))
//!     }
//!     fn run(&self, cell: &Cell, _: &Workplace<'_>) -> Result<Outcome, Problem> {
//!         let length = cell.assignments[0].value.as_float().unwrap_or(1.0);
//!         let (mut angle, mut rate) = (0.1 * cell.seed as f64, 0.0);
//!         for _ in 0..1000 {
//!             rate -= 1e-3 * 9.81 / length * f64::sin(angle);
//!             angle += 1e-3 * rate;
//!         }
//!         let metrics = vec![("angle_rad".to_owned(), angle)];
//!         Ok(Outcome::Finished(Measurements { metrics, ..Default::default() }))
//!     }
//! }
//!
//! let sweep = Sweep::new("lengths").with_axis("length_m", [0.5, 1.0, 2.0]).with_seeds(1..=5);
//! let out = std::env::temp_dir().join(format!("pam-lengths-{}", std::process::id()));
//! let folder = SweepFolder::begin(&out, &sweep, false)?;
//! let planned = plan(&sweep, &Pendulum)?;
//! let counts = run_cells(
//!     &planned, &Pendulum, &folder, &RunOptions::default(), &AtomicBool::new(false), &|_| {},
//! )?;
//! assert_eq!(counts.done, 15);
//! let summary = write_results(&folder, &sweep, &planned, "a doc test")?; // results.csv, report.html, …
//! assert_eq!(summary.differences.len(), 2);
//! # std::fs::remove_dir_all(out)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod error;
pub mod experiment;
pub mod folder;
#[cfg(feature = "parquet")]
mod parquet_file;
pub mod report;
pub mod run;
pub mod slurm;
pub mod statistics;
pub mod summary;
pub mod sweep;
pub mod table;
pub mod training;

pub use error::AblateError;
pub use training::TrainingExperiment;

/// Names for sweeps of your own.
pub mod prelude {
    pub use crate::error::AblateError;
    pub use crate::experiment::{Experiment, Measurements, Outcome, Problem, Workplace};
    pub use crate::folder::{CellRecord, Planned, Status, SweepFolder, merge, plan};
    pub use crate::report::write_results;
    pub use crate::run::{Event, RunCounts, RunOptions, Shard, free_failed, run_cells};
    pub use crate::summary::Summary;
    pub use crate::sweep::{Cell, Range, Search, Sweep};
    pub use crate::training::TrainingExperiment;
}
