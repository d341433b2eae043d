//! The losses that configuration files name.

use super::TrajectoryLoss;
use super::own::{self, OwnLoss};
use crate::settings::SettingsError;
use pam_core::error::OWN_PART;
use pam_data::Recording;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error};
use serde_json::Value;

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
        // `remote` makes functions in place of the traits, which are implemented below and know the losses of other
        // crates besides.
        #[serde(remote = "Self", tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
        pub enum AnyLoss {
            /// [`SquaredError::paper`].
            Paper {},
            /// [`SquaredError::published`], the default.
            Published {},
            $($(#[doc = $doc])+ $variant($type $(<$of>)?),)+
            /// One of another crate.
            #[serde(skip)]
            Own(OwnLoss),
        }

        impl AnyLoss {
            /// Name and one-line description of every built-in loss; [`all`](Self::all) has those of other crates
            /// besides.
            pub const ALL: &'static [(&'static str, &'static str)] = &[
                ("paper", "squared error as the paper writes it"),
                ("published", "half of it, as the published code averages"),
                $((stringify!($module), concat!($($doc),+).trim_ascii())),+
            ];

            /// Its name in files.
            #[must_use]
            pub fn name(&self) -> &'static str {
                match self {
                    Self::Paper {} => "paper",
                    Self::Published {} => "published",
                    $(Self::$variant(_) => stringify!($module),)+
                    Self::Own(loss) => loss.name(),
                }
            }

            /// The loss behind the name.
            fn with<T>(&self, f: impl FnOnce(&dyn TrajectoryLoss) -> T) -> T {
                match self {
                    Self::Paper {} => f(&SquaredError::paper()),
                    Self::Published {} => f(&SquaredError::published()),
                    $(Self::$variant(loss) => f(loss),)+
                    Self::Own(loss) => f(loss),
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

impl Serialize for AnyLoss {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Own(loss) => Serialize::serialize(loss, serializer),
            named => Self::serialize(named, serializer),
        }
    }
}

impl<'de> Deserialize<'de> for AnyLoss {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        // Errors of serde are texts; this is how that of an unknown tag begins.
        let advised = |e: String| match e.contains("unknown variant") {
            true => D::Error::custom(format!("loss: {e}; {OWN_PART}")),
            false => D::Error::custom(e),
        };
        if own::registered().is_empty() {
            return Self::deserialize(deserializer).map_err(|e| {
                let text = e.to_string();
                if text.contains("unknown variant") { advised(text) } else { e }
            });
        }
        let table = <Value as Deserialize>::deserialize(deserializer)?;
        match own::read(&table) {
            Some(own) => own.map(Self::Own).map_err(D::Error::custom),
            None => Self::deserialize(table).map_err(|e| advised(e.to_string())),
        }
    }
}

impl AnyLoss {
    /// Name and one-line description of every loss: the built-in ones, then those that were
    /// [registered](super::register).
    #[must_use]
    pub fn all() -> Vec<(&'static str, &'static str)> {
        Self::ALL.iter().copied().chain(own::registered()).collect()
    }

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
