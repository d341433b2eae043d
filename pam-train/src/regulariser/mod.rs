//! Regularisers: penalties on the model that training adds to the loss.
//!
//! One regulariser a file: [`L2`], [`Passivity`]. To add one that configuration files name, write its
//! file and add a line to [`AnyRegulariser`].

mod l2;
mod passivity;

pub use l2::L2;
pub use passivity::{OperatingBox, Passivity, SlopeFloor};

use pam_core::settings::SettingsError;
use pam_trajectory::engine::NetworkJoint;
use serde::{Deserialize, Serialize};

/// A penalty on a model.
pub trait Regulariser {
    /// Returns the penalty and **adds** its gradient by the force network's weights, in the order of
    /// [`ParametricForce`](pam_core::ParametricForce), to `weights_gradient`. The penalty does not
    /// depend on other numbers of the model.
    ///
    /// # Panics
    /// If `weights_gradient` has not one place for each weight and bias.
    fn value_and_gradient(&self, model: &NetworkJoint, weights_gradient: &mut [f64]) -> f64;
}

/// A regulariser by its name: a table with `kind` and the fields of that regulariser.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum AnyRegulariser {
    /// Squared weights.
    L2(L2),
    /// Lower limits of the force's slopes.
    Passivity(Passivity),
}

impl AnyRegulariser {
    /// Checks the numbers of the regulariser.
    ///
    /// # Errors
    /// [`SettingsError`] naming the first that is out of range.
    pub fn check(&self) -> Result<(), SettingsError> {
        match self {
            Self::L2(own) => own.check(),
            Self::Passivity(own) => own.check(),
        }
    }
}

impl Regulariser for AnyRegulariser {
    fn value_and_gradient(&self, model: &NetworkJoint, weights_gradient: &mut [f64]) -> f64 {
        match self {
            Self::L2(own) => own.value_and_gradient(model, weights_gradient),
            Self::Passivity(own) => own.value_and_gradient(model, weights_gradient),
        }
    }
}
