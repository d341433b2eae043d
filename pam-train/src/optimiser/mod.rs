//! Optimisers of a vector of numbers.
//!
//! [`Adam`] takes a gradient and a rate; [`Lbfgs`] takes a function that it evaluates as often as its
//! line search needs. [`OptimiserSettings`] is the choice between them in configuration files.

mod adam;
mod clip;
mod lbfgs;
mod lbfgs_settings;
mod line_search;
mod settings;

pub use adam::{Adam, AdamSettings};
pub use clip::clip_to_norm;
pub use lbfgs::{Lbfgs, Outcome, StepKind};
pub use lbfgs_settings::LbfgsSettings;
pub use line_search::Evaluate;
pub use settings::OptimiserSettings;
