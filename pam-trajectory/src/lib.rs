//! Predictions of recordings by a joint model, losses, and their gradients.
//!
//! - [`mod@predict`]: free-run prediction of a recording from its first sample;
//! - [`metrics`]: R² and RMSE per channel;
//! - [`loss`]: the distance between a predicted and a measured trajectory;
//! - [`windows`]: recordings cut into windows;
//! - [`engine`]: prediction, loss and gradient of a model on windows, by engines for different models;
//! - [`settings`]: errors of settings that are out of range.

pub mod engine;
pub mod loss;
pub mod metrics;
pub mod predict;
pub mod settings;
pub mod windows;

pub use engine::{
    BatchedEngine, ClosedFormEngine, EngineError, GeneralEngine, GradientChoice, TrajectoryEngine,
    TrajectoryGradient, TrajectoryRequest,
};
pub use loss::{AnyLoss, SquaredError, TrajectoryLoss};
pub use metrics::{PerChannel, Scores};
pub use predict::{PredictError, Prediction, Predictor, SolverSettings, StepChoice, predict};
pub use settings::SettingsError;
pub use windows::Windows;
