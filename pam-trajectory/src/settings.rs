//! Settings that make no sense.

pub use pam_core::settings::{SettingsError, require, require_weights};
