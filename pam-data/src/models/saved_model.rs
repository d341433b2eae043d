//! A model with its metadata.

use crate::rig_file::RigFile;
use pam_core::{AnyForce, JointModel};
use std::path::PathBuf;

/// Metadata of a model.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ModelInfo {
    /// Name for reports.
    pub name: String,
    /// Where its numbers come from.
    pub provenance: String,
    /// True if it was fitted to data; decides how masses are found by default.
    pub trained: bool,
    /// Names of the recordings it was fitted to, if they are known.
    pub trained_on: Vec<String>,
    /// Effects that extend the joint model, in the order in which they act; empty for a model without. They are
    /// carried through unchanged: `pam-effects` reads and writes them.
    pub effects: Vec<serde_json::Value>,
    /// The rig that it was trained for, if its files were described by one.
    pub rig: Option<RigFile>,
    /// The file it was read from, if any.
    pub source: Option<PathBuf>,
}

/// A joint model as it stands in a file.
#[derive(Debug, Clone, PartialEq)]
pub struct SavedModel {
    /// The model.
    pub model: JointModel<f64, AnyForce<f64>>,
    /// Its metadata.
    pub info: ModelInfo,
}
