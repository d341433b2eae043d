//! Training of a joint model on recordings, and its evaluation.
//!
//! - [`segments`]: stretches of one excitation frequency;
//! - [`balance`]: the force that the model lacks on the measured motion;
//! - [`evaluation`]: predictions and scores of a whole data set, in parallel;
//! - [`coordinates`]: the numbers that an optimiser moves;
//! - [`optimiser`]: Adam and L-BFGS;
//! - [`schedule`]: how their rate changes, and when they stop;
//! - [`regulariser`]: penalties that are added to the loss;
//! - [`warm_start`]: starting values by regression;
//! - [`curriculum`]: how a model is trained, as data;
//! - [`training`]: the trainer, checkpoints, the files of a run;
//! - [`identification`]: standard errors of the physical parameters;
//! - [`field`]: training of any vector field, of any number of states;
//! - [`events`]: curves for TensorBoard.

pub mod balance;
pub mod coordinates;
pub mod curriculum;
pub mod evaluation;
pub mod events;
pub mod field;
pub mod identification;
pub mod optimiser;
pub mod regulariser;
pub mod schedule;
pub mod segments;
pub mod training;
pub mod warm_start;

pub use balance::ForceBalance;
pub use evaluation::{Evaluation, RecordingEvaluation, evaluate, evaluate_with};
pub use events::{EVENT_FILE_NAME, EventFile, ScalarEvent};
pub use regulariser::{AnyRegulariser, Regulariser};
pub use schedule::{EarlyStop, Rate, Schedule};
pub use segments::{Segment, frequency_segments};
pub use training::{TrainingError, effects_of};
