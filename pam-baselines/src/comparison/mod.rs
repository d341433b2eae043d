//! Several models on one split of the data.
//!
//! Every model is fitted to the same training recordings and predicts the same recordings twice: from the
//! first sample alone (*cold*), and knowing the first [`warm_up`](config::EvaluationConfig::warm_up)
//! samples (*warm*), scored on the same samples after them. So the advantage of knowing a history is
//! separated from that of a model.

pub mod cache;
pub mod config;
pub mod files;
pub mod qualitative;
pub mod report;
pub mod result;
pub mod run;
mod score;
pub mod split;

pub use cache::ModelCache;
pub use config::{ComparisonConfig, DataConfig, EvaluationConfig, ModelConfig};
pub use result::{Comparison, FinishedModel, ModelResult, ModelTimes, SetScores, Summary};
pub use run::{Event, compare};
pub use split::{Split, split};
