//! Baselines for the hybrid model, and their comparison on one split of the data.
//!
//! - [`method`]: what a baseline is; [`registry`]: those that configurations know by name;
//! - [`koopman`]: Koopman/EDMDc; [`kang`]: the analytical muscle model; [`gru`]: the recurrent network;
//! - [`neural_ode`]: a neural ODE without physics; [`spring_damper`]: physics without learning;
//!   [`sparse_force`]: a sparse polynomial force (SINDy); [`equilibrium_point`]; [`hybrid`];
//! - [`comparison`]: all of them on the same data, `pam compare`;
//! - [`joint`]: any force as a joint model; [`points`], [`regression`]: what they share.

mod batched;
pub mod comparison;
pub mod equilibrium_point;
pub mod error;
pub mod gru;
pub mod hybrid;
pub mod joint;
pub mod kang;
pub mod koopman;
pub mod method;
pub mod neural_ode;
pub mod points;
pub mod registry;
pub mod regression;
mod saved;
pub mod sparse_force;
pub mod spring_damper;
mod tanh;

pub use comparison::{Comparison, ComparisonConfig, compare};
pub use error::BaselineError;
pub use method::{FittedModel, FreeRun, Method, TrainingSet};
pub use registry::AnyMethod;
