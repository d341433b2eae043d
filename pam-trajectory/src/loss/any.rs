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
