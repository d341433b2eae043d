//! Regularisers: penalties on the model that training adds to the loss.
//!
//! One regulariser a file: [`L2`], [`Passivity`]. To add one that configuration files name, write its
//! file and add a line to [`AnyRegulariser`].

mod l2;
mod passivity;
#[cfg(test)]
mod testing;

pub use l2::L2;
pub use passivity::{OperatingBox, Passivity, SlopeFloor};

use pam_trajectory::engine::NetworkJoint;
use pam_trajectory::settings::SettingsError;
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

#[cfg(test)]
mod tests {
    use super::*;

    const PASSIVITY: &str = r#"{
        "kind": "passivity",
        "within": { "mass_flexor_g": [0.02, 0.1], "mass_extensor_g": [0.02, 0.1],
                    "displacement_mm": [-3, 3], "velocity_mm_s": [-20, 20] },
        "damping": { "strength": 1.0, "half_width": 0.5 }
    }"#;

    #[test]
    fn kinds_are_read_and_wrong_numbers_refused() {
        let read = |json: &str| serde_json::from_str::<AnyRegulariser>(json);
        let l2 = read(r#"{ "kind": "l2", "strength": 1e-4 }"#).unwrap();
        assert_eq!(l2, AnyRegulariser::L2(L2 { strength: 1e-4 }));
        let passivity = read(PASSIVITY).unwrap();
        passivity.check().unwrap();
        let AnyRegulariser::Passivity(own) = &passivity else { panic!("{passivity:?}") };
        assert_eq!((own.stiffness, own.damping.map(|d| d.floor)), (None, Some(0.0)));
        let again = read(&serde_json::to_string(&passivity).unwrap()).unwrap();
        assert_eq!(again, passivity);

        assert!(read(r#"{ "kind": "l2", "strength": -1.0 }"#).unwrap().check().is_err());
        assert!(read(r#"{ "kind": "l2", "strength": 1.0, "power": 2 }"#).is_err());
        for (from, to) in [("[-3, 3]", "[3, -3]"), ("0.5", "0.0"), ("1.0", "-1.0")] {
            assert!(read(&PASSIVITY.replace(from, to)).unwrap().check().is_err(), "{from}");
        }
    }
}
