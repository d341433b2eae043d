//! The losses that configuration files name.

use super::TrajectoryLoss;
use crate::settings::SettingsError;
use pam_data::Recording;
use serde::{Deserialize, Serialize};

macro_rules! losses {
    ($($(#[doc = $doc:literal])+ $variant:ident($module:ident::$type:ident $(<$of:ty>)?)),+ $(,)?) => {
        $(pub use super::$module::$type;)+

        /// A loss by its name: a table with `kind` and the fields of that loss.
        ///
        /// ```
        /// # use pam_trajectory::AnyLoss;
        /// let loss: AnyLoss = serde_json::from_str(
        ///     r#"{ "kind": "masked", "every": 4, "of": { "kind": "normalised", "weights": [2, 1, 1, 1] } }"#,
        /// )?;
        /// loss.check().expect("weights are not negative");
        /// # Ok::<(), serde_json::Error>(())
        /// ```
        // The nameless variants are structs without fields because a unit variant would let unknown
        // fields pass.
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
        #[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
        pub enum AnyLoss {
            /// [`SquaredError::paper`].
            Paper {},
            /// [`SquaredError::published`], the default.
            Published {},
            $($(#[doc = $doc])+ $variant($type $(<$of>)?)),+
        }

        impl AnyLoss {
            /// Name and one-line description of every loss.
            pub const ALL: &'static [(&'static str, &'static str)] = &[
                ("paper", "squared error as the paper writes it"),
                ("published", "half of it, as the published code averages"),
                $((stringify!($module), concat!($($doc),+).trim_ascii())),+
            ];

            /// The loss behind the name.
            fn with<T>(&self, f: impl FnOnce(&dyn TrajectoryLoss) -> T) -> T {
                match self {
                    Self::Paper {} => f(&SquaredError::paper()),
                    Self::Published {} => f(&SquaredError::published()),
                    $(Self::$variant(loss) => f(loss)),+
                }
            }
        }
    };
}

losses! {
    /// squared error with given weights
    Squared(squared::SquaredError),
    /// squared error over the variance of the channel
    Normalised(normalised::Normalised),
    /// squared error that grows linearly beyond thresholds
    Huber(huber::Huber),
    /// another loss on some of the samples
    Masked(masked::Masked<AnyLoss>),
}

impl Default for AnyLoss {
    fn default() -> Self {
        Self::Published {}
    }
}

impl AnyLoss {
    /// Checks the numbers of the loss, and of those that it wraps.
    ///
    /// # Errors
    /// [`SettingsError`] naming the first that is out of range.
    pub fn check(&self) -> Result<(), SettingsError> {
        self.with(|loss| loss.check())
    }
}

impl TrajectoryLoss for AnyLoss {
    fn value_and_cotangents(
        &self,
        measured: &Recording,
        predicted: &[[f64; 4]],
        cotangents: &mut [[f64; 4]],
    ) -> f64 {
        self.with(|loss| loss.value_and_cotangents(measured, predicted, cotangents))
    }

    fn check(&self) -> Result<(), SettingsError> {
        AnyLoss::check(self)
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_cotangents, noisy, random_recording};
    use super::*;

    fn parse(json: &str) -> Result<AnyLoss, serde_json::Error> {
        serde_json::from_str(json)
    }

    const FILES: [&str; 6] = [
        r#"{"kind":"paper"}"#,
        r#"{"kind":"published"}"#,
        r#"{"kind":"squared","weights":[3.0,2.0,1.0,0.5]}"#,
        r#"{"kind":"normalised","weights":[1.0,1.0,2.0,2.0]}"#,
        r#"{"kind":"huber","form":"pseudo_huber","thresholds":[0.5,5.0,2.0,2.0],"weights":[1.0,1.0,1.0,1.0]}"#,
        r#"{"kind":"masked","of":{"kind":"paper"},"every":3,"intervals_s":[[0.0,0.15]]}"#,
    ];

    #[test]
    fn every_loss_has_its_name() {
        for ((name, _), json) in AnyLoss::ALL.iter().zip(FILES) {
            assert!(json.starts_with(&format!(r#"{{"kind":"{name}""#)), "{name}");
        }
        assert_eq!(AnyLoss::ALL.len(), FILES.len());
    }

    #[test]
    fn every_kind_is_read_written_and_right() {
        for (k, json) in FILES.iter().enumerate() {
            let loss = parse(json).unwrap();
            loss.check().unwrap();
            assert_eq!(serde_json::to_string(&loss).unwrap(), *json);
            assert_cotangents(&loss, 20 + k as u64);
        }
    }

    #[test]
    fn named_losses_are_those_of_the_squared_error() {
        let measured = random_recording(12, 3);
        let predicted = noisy(&measured, 4);
        let value = |loss: &dyn TrajectoryLoss| {
            loss.value_and_cotangents(&measured, &predicted, &mut [[0.0; 4]; 12])
        };
        assert_eq!(value(&parse(FILES[0]).unwrap()), value(&SquaredError::paper()));
        assert_eq!(value(&AnyLoss::default()), value(&SquaredError::published()));
    }

    #[test]
    fn what_is_unknown_or_senseless_is_refused() {
        assert!(parse(r#"{"kind":"paper","weights":[1,1,1,1]}"#).is_err());
        assert!(parse(r#"{"kind":"squared","weights":[1,1,1,1],"colour":1}"#).is_err());
        assert!(parse(r#"{"kind":"masked","of":{"kind":"paper"},"each":3}"#).is_err());
        assert!(parse(r#"{"kind":"hinge"}"#).is_err());
        for json in [
            r#"{"kind":"squared","weights":[1,-1,1,1]}"#,
            r#"{"kind":"huber","thresholds":[0,1,1,1],"weights":[1,1,1,1]}"#,
            r#"{"kind":"masked","of":{"kind":"paper"},"every":0}"#,
            r#"{"kind":"masked","of":{"kind":"paper"},"intervals_s":[[2,1]]}"#,
            r#"{"kind":"masked","of":{"kind":"normalised","weights":[-1,1,1,1]}}"#,
        ] {
            assert!(parse(json).unwrap().check().is_err(), "{json}");
        }
    }
}
