//! Errors of models.

use thiserror::Error;

/// A model that cannot be built or evaluated as asked.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ModelError {
    /// Parts of a model are missing or do not fit together, or its inputs or outputs are not those of
    /// a force.
    #[error("{0}")]
    Shape(String),
    /// A quantity that must be positive and finite is not.
    #[error("{quantity} must be positive and finite, got {value}")]
    NotPositive {
        /// Name of the quantity with its unit.
        quantity: &'static str,
        /// The offending value.
        value: f64,
    },
    /// A name that is in no registry.
    #[error("unknown {kind} `{name}`; known: {known}")]
    UnknownName {
        /// Kind of the name (activation, tableau, …).
        kind: &'static str,
        /// The name that was given.
        name: String,
        /// The names that exist, comma-separated.
        known: String,
    },
}

impl ModelError {
    /// Checks that `value` is positive and finite.
    ///
    /// # Errors
    /// [`ModelError::NotPositive`] otherwise.
    pub fn require_positive(quantity: &'static str, value: f64) -> Result<(), Self> {
        if value.is_finite() && value > 0.0 {
            Ok(())
        } else {
            Err(Self::NotPositive { quantity, value })
        }
    }
}
