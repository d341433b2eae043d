//! Diagnosis.
pub mod effects;
pub mod fit;
pub mod search;
pub mod simulation;
