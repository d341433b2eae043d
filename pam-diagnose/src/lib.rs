//! Diagnosis.
pub mod design;
pub mod diagnosis;
pub mod effects;
pub mod error;
pub mod extended;
pub mod fit;
pub mod report;
pub mod residual;
pub mod search;
pub mod simulation;

pub use diagnosis::{Diagnosis, Options, Sets, Stage, Verdict, diagnose};
pub use error::DiagnoseError;
pub use extended::{Active, Extended};
