//! Errors of plans and experiments.

use pam_data::DataError;
use thiserror::Error;

/// Something that cannot be planned, identified or executed as asked.
#[derive(Debug, Error)]
pub enum ControlError {
    /// A motion or stiffness that is described in words is wrong.
    #[error("`{text}`: {why}")]
    Spec {
        /// The text that was given.
        text: String,
        /// The problem and its remedy.
        why: String,
    },
    /// A number is impossible.
    #[error("{field} = {value}: {why}")]
    Value {
        /// Which quantity, with its unit.
        field: &'static str,
        /// Its value.
        value: f64,
        /// The problem and its remedy.
        why: String,
    },
    /// No air masses within the bounds give the motion its acceleration.
    #[error(
        "the motion cannot be reached at t = {time_s:.4} s (x = {displacement_mm:.3} mm, v = \
         {velocity_mm_s:.3} mm/s, a = {acceleration_mm_s2:.3} mm/s²): the muscles lack at least \
         {missing_n:.3} N within the mass bounds; {count} of {samples} samples are like this. Take a \
         smaller or slower motion, another load, or wider bounds"
    )]
    Motion {
        /// The first such time.
        time_s: f64,
        /// Displacement there.
        displacement_mm: f64,
        /// Velocity there.
        velocity_mm_s: f64,
        /// Acceleration there.
        acceleration_mm_s2: f64,
        /// Smallest force that is missing, N.
        missing_n: f64,
        /// Number of samples without a solution.
        count: usize,
        /// Number of samples.
        samples: usize,
    },
    /// A file is wrong.
    #[error(transparent)]
    Data(#[from] DataError),
    /// The data do not hold what is asked of them.
    #[error("{0}")]
    Insufficient(String),
}

impl ControlError {
    /// A spec that is wrong.
    pub(crate) fn spec(text: &str, why: impl Into<String>) -> Self {
        Self::Spec { text: text.to_owned(), why: why.into() }
    }

    /// Checks that a value is finite.
    pub(crate) fn require_finite(field: &'static str, value: f64) -> Result<(), Self> {
        if value.is_finite() {
            Ok(())
        } else {
            Err(Self::Value { field, value, why: "it must be finite".into() })
        }
    }

    /// Checks that a value is positive and finite.
    pub(crate) fn require_positive(field: &'static str, value: f64) -> Result<(), Self> {
        if value.is_finite() && value > 0.0 {
            Ok(())
        } else {
            Err(Self::Value { field, value, why: "it must be positive and finite".into() })
        }
    }
}
