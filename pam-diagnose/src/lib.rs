//! Diagnosis.
pub mod effects;
pub mod fit;
pub mod simulation;
