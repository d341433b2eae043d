//! Predictions of recordings by a joint model, and how good they are.
//!
//! - [`mod@predict`]: free-run prediction of a recording from its first sample;
//! - [`metrics`]: R² and RMSE per channel;
//! - [`segments`]: stretches of one excitation frequency;
//! - [`balance`]: the force that the model lacks on the measured motion;
//! - [`evaluation`]: all of these for a whole data set, in parallel;
//! - [`loss`]: what training makes small;
//! - [`gradient`]: loss and gradient of a model on recordings;
//! - [`coordinates`]: the numbers that an optimiser moves;
//! - [`optimiser`]: what moves them;
//! - [`warm_start`]: where they start from.

pub mod balance;
pub mod coordinates;
pub mod evaluation;
pub mod gradient;
pub mod loss;
pub mod metrics;
pub mod optimiser;
pub mod predict;
pub mod segments;
pub mod warm_start;

pub use balance::ForceBalance;
pub use evaluation::{Evaluation, RecordingEvaluation, Subject, evaluate};
pub use gradient::{GradientChoice, JointGradient, SealedGradient};
pub use loss::{SquaredError, TrajectoryLoss};
pub use metrics::{PerChannel, Scores};
pub use predict::{PredictError, Prediction, SolverSettings, StepChoice, predict};
pub use segments::{Segment, frequency_segments};
