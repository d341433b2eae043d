//! Training: a curriculum carried out on recordings.
//!
//! - [`Training`]: all of it in a few lines;
//! - [`state`]: everything that decides how training goes on, and nothing else: what a checkpoint is;
//! - [`trainer`]: one epoch after another;
//! - [`folder`]: the files of a run, written so that a run can be killed at any moment and resumed.

mod beginning;
mod builder;
mod effects;
mod epoch;
mod error;
pub mod folder;
mod held_out;
mod scores;
mod stage;
pub mod state;
pub mod trainer;

pub use builder::{Trained, Training};
pub use effects::effects_of;
pub use error::TrainingError;
pub use folder::{RunFolder, RunSettings, TrainedRun, train_into};
pub use state::{EpochRow, StageResult, TrainingState};
pub use trainer::Trainer;
