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

use std::path::PathBuf;

/// A file of the reference data.
fn shared(name: &str) -> PathBuf {
    std::env::var_os("PAM_SHARED")
        .map_or_else(
            || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared"),
            PathBuf::from,
        )
        .join(name)
}
