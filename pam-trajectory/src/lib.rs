//! Predictions of recordings by a joint model, and their gradients.
//!
//! - [`mod@predict`]: free-run prediction of a recording from its first sample;
//! - [`metrics`]: R² and RMSE per channel;
//! - [`loss`]: the distance between a predicted and a measured trajectory;
//! - [`windows`]: recordings cut into windows;
//! - [`gradient`]: loss and gradient of a model on recordings;
//! - [`settings`]: errors of settings that are out of range.

pub mod gradient;
pub mod loss;
pub mod metrics;
pub mod predict;
pub mod settings;
pub mod windows;

pub use gradient::{GradientChoice, JointGradient, SealedGradient};
pub use loss::{AnyLoss, SquaredError, TrajectoryLoss};
pub use metrics::{PerChannel, Scores};
pub use predict::{PredictError, Prediction, Predictor, SolverSettings, StepChoice, predict};
pub use settings::SettingsError;
pub use windows::Windows;
