//! Tests against published files, measured muscles and joints that are known exactly.

mod comparison;
mod equilibrium_point;
mod gru {
    mod batch;
    mod tape;
}
mod kang;
mod koopman {
    mod dictionary;
}
mod neural_ode {
    mod windows;
}
mod published;
mod regression;
mod sparse_force;

use std::path::{Path, PathBuf};

/// A file of the reference data.
fn published(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/published").join(name)
}
