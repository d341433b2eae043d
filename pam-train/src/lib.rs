//! Training of a joint model on recordings, and its evaluation; training of any vector field.
//!
//! [`field`], [`optimiser`], [`schedule`] and [`segments`] are always there; all else is behind the feature `joint`, which is on by default.
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

#[cfg(feature = "joint")]
pub mod balance;
#[cfg(feature = "joint")]
pub mod coordinates;
#[cfg(feature = "joint")]
pub mod curriculum;
#[cfg(feature = "joint")]
pub mod evaluation;
#[cfg(feature = "joint")]
pub mod events;
pub mod field;
#[cfg(feature = "joint")]
pub mod identification;
pub mod optimiser;
#[cfg(feature = "joint")]
pub mod regulariser;
pub mod schedule;
pub mod segments;
#[cfg(feature = "joint")]
pub mod training;
#[cfg(feature = "joint")]
pub mod warm_start;

#[cfg(feature = "joint")]
pub use balance::ForceBalance;
#[cfg(feature = "joint")]
pub use evaluation::{
    Evaluation, RecordingEvaluation, evaluate, evaluate_joint, evaluate_keeping, evaluate_with,
};
#[cfg(feature = "joint")]
pub use events::{EVENT_FILE_NAME, EventFile, ScalarEvent};
#[cfg(feature = "joint")]
pub use regulariser::{AnyRegulariser, Regulariser};
pub use schedule::{EarlyStop, Rate, Schedule};
pub use segments::{Segment, frequency_segments};
#[cfg(feature = "joint")]
pub use training::{TrainingError, effects_of};
