use super::{ForceInput, ForceModel, NetworkForce, SpringDamper};
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
