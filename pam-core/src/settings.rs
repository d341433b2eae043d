//! Settings that make no sense.

use thiserror::Error;

/// A setting outside the range in which what it controls is defined.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("{0}")]
pub struct SettingsError(pub String);

/// Passes if `holds`.
///
/// # Errors
/// [`SettingsError`] with `message` otherwise.
pub fn require(holds: bool, message: impl FnOnce() -> String) -> Result<(), SettingsError> {
    if holds { Ok(()) } else { Err(SettingsError(message())) }
}

/// Passes if all `weights` are finite and none is negative.
///
/// # Errors
/// [`SettingsError`] otherwise.
pub fn require_weights(what: &str, weights: &[f64]) -> Result<(), SettingsError> {
    require(weights.iter().all(|w| w.is_finite() && *w >= 0.0), || {
        format!("weights of {what} must be finite and not negative, got {weights:?}")
    })
}
