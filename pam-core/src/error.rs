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
    /// A quantity is finite, but no joint that could be built or simulated has it.
    #[error("{quantity} = {value:e} is not that of a joint: it lies between {low:e} and {high:e}")]
    OutOfRange {
        /// Name of the quantity with its unit.
        quantity: &'static str,
        /// The offending value.
        value: f64,
        /// Smallest value.
        low: f64,
        /// Largest value.
        high: f64,
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
    /// A part of this name is not known, but may be one of another crate.
    #[error("unknown {kind} `{name}`; known: {known}; {OWN_PART}")]
    UnknownPart {
        /// Kind of the part (activation, …).
        kind: &'static str,
        /// The name that was given.
        name: String,
        /// The names that exist, comma-separated.
        known: String,
    },
    /// A custom part has the name of another part.
    #[error("{kind} `{name}`: there is {what} of this name already; give yours another name")]
    NameTaken {
        /// Kind of the part (activation, …).
        kind: &'static str,
        /// The name.
        name: String,
        /// Which part has the name.
        what: String,
    },
}

/// The remedy for a part that a program does not know.
pub const OWN_PART: &str = "if it is a part of your own, use the program that registers it (`pam_cli::Registry`, see \
                            templates/own-pam)";

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

    /// Checks that `value` lies in a range, both ends included.
    ///
    /// # Errors
    /// [`ModelError::OutOfRange`] otherwise, also for NaN.
    pub fn require_within(
        quantity: &'static str,
        value: f64,
        [low, high]: [f64; 2],
    ) -> Result<(), Self> {
        if value >= low && value <= high {
            Ok(())
        } else {
            Err(Self::OutOfRange { quantity, value, low, high })
        }
    }
}
