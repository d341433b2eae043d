//! Options that several commands share, and what they turn into.

mod accept;
mod choice;
mod data;
mod diagnosis;
mod model;
mod solver;

pub use accept::{check_plausible, check_quality};
pub(crate) use choice::possible_values;
pub use choice::{choice, named};
pub use data::DataOptions;
pub use diagnosis::{DiagnosisOptions, effect, given_values, settings_of};
pub use model::{
    DEFAULT_MODEL, ModelOptions, SPRING_DAMPER, built_in_spring_damper, default_model,
    describe_model,
};
pub use solver::{SolverOptions, StepOptions, solver_json};
