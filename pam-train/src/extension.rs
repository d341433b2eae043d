//! Parts of a model beside its network and its physical parameters, with numbers of their own that are
//! trained along.
//!
//! This crate does not know what such parts do: friction, a leak, a sensor's delay are known above it. It
//! asks an [`Extension`] for its numbers and for loss and gradient of the whole, and moves its numbers with
//! the others, each inside its range, in a coordinate of its own ([`ExtensionCoordinate`]).

use crate::curriculum::Precision;
use pam_data::StoredEffect;
use pam_data::Subject;
use pam_trajectory::gradient::ExtendedGradient;
use pam_trajectory::gradient::NetworkJoint;
use pam_trajectory::windows::Windows;
use std::fmt::Debug;
use thiserror::Error;

/// An extension that cannot be trained as asked.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("effect `{part}`: {message}")]
pub struct ExtensionError {
    /// Which part.
    pub part: String,
    /// Why, and what to do.
    pub message: String,
}

/// A number of an extension.
#[derive(Debug, Clone, PartialEq)]
pub struct ExtensionParameter {
    /// Name with its part and its unit, `coulomb_friction.force_n`.
    pub name: String,
    /// Values that it may have.
    pub range: [f64; 2],
    /// Whether it is moved by its logarithm.
    pub logarithmic: bool,
    /// The value from which training starts.
    pub start: f64,
}

/// Further parts of a model.
pub trait Extension: Debug + Send + Sync {
    /// Its numbers, in order.
    fn parameters(&self) -> Vec<ExtensionParameter>;

    /// For each number how far its coordinate (the value, or its logarithm) must change to change the
    /// predictions of `subjects` by one standard deviation of the measured channels (root mean square over
    /// channels and recordings).
    ///
    /// # Errors
    /// [`ExtensionError`] if a number changes no prediction, or the model diverges.
    fn units(
        &self,
        model: &NetworkJoint,
        values: &[f64],
        subjects: &[Subject],
    ) -> Result<Vec<f64>, ExtensionError>;

    /// What finds loss and gradient on windows.
    ///
    /// # Errors
    /// [`ExtensionError`] if a part cannot be simulated in such windows.
    fn engine(
        &self,
        windows: &Windows,
        precision: Precision,
    ) -> Result<Box<dyn ExtendedGradient>, ExtensionError>;

    /// The parts with these values as they stand in a file.
    fn stored(&self, values: &[f64]) -> Vec<StoredEffect>;
}

/// How a number of an extension is moved: `coordinate · unit` is the value, or its logarithm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExtensionCoordinate {
    /// Values that it may have.
    pub range: [f64; 2],
    /// Whether its logarithm is moved.
    pub logarithmic: bool,
    /// The value from which training starts.
    pub start: f64,
    /// What one unit of the coordinate is.
    pub unit: f64,
}

impl ExtensionCoordinate {
    /// A coordinate in units of one.
    #[must_use]
    pub fn of(parameter: &ExtensionParameter) -> Self {
        Self {
            range: parameter.range,
            logarithmic: parameter.logarithmic,
            start: parameter.start,
            unit: 1.0,
        }
    }

    /// The largest change of value or logarithm that is taken for one unit, however little it changes
    /// predictions: a factor of e, or a tenth of the range.
    #[must_use]
    pub fn largest_unit(&self) -> f64 {
        if self.logarithmic { 1.0 } else { 0.1 * (self.range[1] - self.range[0]) }
    }

    /// The coordinate of a value.
    #[must_use]
    pub fn at(&self, value: f64) -> f64 {
        let moved = if self.logarithmic { value.max(f64::MIN_POSITIVE).ln() } else { value };
        moved / self.unit
    }

    /// The value at a coordinate, inside its range.
    #[must_use]
    pub fn value(&self, at: f64) -> f64 {
        let moved = at * self.unit;
        let value = if self.logarithmic { moved.exp() } else { moved };
        value.clamp(self.range[0], self.range[1])
    }

    /// The derivative by the coordinate from that by the value; zero where a descent would leave the
    /// range.
    #[must_use]
    pub fn pull_back(&self, at: f64, by_value: f64) -> f64 {
        let value = self.value(at);
        let slope = by_value * self.unit * if self.logarithmic { value } else { 1.0 };
        let outward =
            (value <= self.range[0] && slope > 0.0) || (value >= self.range[1] && slope < 0.0);
        if outward { 0.0 } else { slope }
    }
}
