use super::{
    ForceInput, ForceModel, ForceParts, NetworkForce, ReluLayers, SpringDamper, StoredForce,
};
use crate::error::ModelError;
use crate::scalar::Scalar;

macro_rules! forces {
    ($($(#[$doc:meta])* $name:literal => $variant:ident($type:ty)),+ $(,)?) => {
        /// A force model that files and commands know by name.
        #[derive(Debug, Clone, PartialEq)]
        pub enum AnyForce<S> {
            $($(#[$doc])* $variant($type)),+
        }

        impl<S: Scalar> AnyForce<S> {
            /// The kind's name in model files.
            #[must_use]
            pub fn kind(&self) -> &'static str {
                match self { $(Self::$variant(_) => $name),+ }
            }

            /// The same force with other numbers, parameter by parameter.
            pub fn map<T: Scalar>(&self, f: impl FnMut(S) -> T) -> AnyForce<T> {
                match self { $(Self::$variant(m) => AnyForce::<T>::$variant(m.map(f))),+ }
            }
        }

        impl<S: Scalar> ForceModel<S> for AnyForce<S> {
            #[inline]
            fn restoring_force_mn(&self, input: &ForceInput<S>, work: &mut [S]) -> S {
                match self { $(Self::$variant(m) => m.restoring_force_mn(input, work)),+ }
            }
            fn work_len(&self) -> usize {
                match self { $(Self::$variant(m) => m.work_len()),+ }
            }
            fn relu_layers(&self) -> Option<ReluLayers<'_, S>> {
                match self { $(Self::$variant(m) => m.relu_layers()),+ }
            }
            fn network(&self) -> Option<&NetworkForce<S>> {
                match self { $(Self::$variant(m) => m.network()),+ }
            }
        }

        impl AnyForce<f64> {
            /// Names of all kinds.
            pub const KINDS: &'static [&'static str] = &[$($name),+];

            /// The model taken apart; [`kind`](AnyForce::kind) says what it was.
            #[must_use]
            pub fn to_parts(&self) -> ForceParts {
                match self { $(Self::$variant(m) => m.to_parts()),+ }
            }

            /// A model of this kind from its parts.
            ///
            /// # Errors
            /// [`ModelError`] if there is no such kind, or a part is missing or wrong.
            pub fn from_parts(kind: &str, parts: &ForceParts) -> Result<Self, ModelError> {
                match kind {
                    $($name => StoredForce::from_parts(parts).map(Self::$variant),)+
                    _ => Err(ModelError::UnknownName {
                        kind: "force",
                        name: kind.to_owned(),
                        known: Self::KINDS.join(", "),
                    }),
                }
            }

            /// The force times a factor; `None` if its numbers cannot hold that.
            #[must_use]
            pub fn scaled(&self, factor: f64) -> Option<Self> {
                match self { $(Self::$variant(m) => m.scaled(factor).map(Self::$variant)),+ }
            }

            /// The force with a constant (mN) added; `None` if its numbers cannot hold that.
            #[must_use]
            pub fn shifted(&self, offset_mn: f64) -> Option<Self> {
                match self { $(Self::$variant(m) => m.shifted(offset_mn).map(Self::$variant)),+ }
            }

            /// The model in a few words.
            #[must_use]
            pub fn describe(&self) -> String {
                match self { $(Self::$variant(m) => m.describe()),+ }
            }
        }

        $(impl<S> From<$type> for AnyForce<S> {
            fn from(force: $type) -> Self {
                Self::$variant(force)
            }
        })+
    };
}

forces! {
    /// A network of (m_f, m_e, x, ẋ).
    "mlp" => Network(NetworkForce<S>),
    /// A linear spring–damper.
    "spring_damper" => SpringDamper(SpringDamper<S>),
}
