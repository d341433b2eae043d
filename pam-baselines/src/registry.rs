//! The methods that configurations know by name. To add one, write its file with [`Method`] and add one
//! line here.

use crate::method::Method;
use serde::{Deserialize, Serialize};

macro_rules! methods {
    ($($(#[$doc:meta])* $name:literal => $variant:ident($type:ty)),+ $(,)?) => {
        /// A method by its `kind`, with its settings.
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
        #[serde(tag = "kind")]
        pub enum AnyMethod {
            $($(#[$doc])* #[serde(rename = $name)] $variant($type)),+
        }

        impl AnyMethod {
            /// Names of all kinds.
            pub const KINDS: &'static [&'static str] = &[$($name),+];

            /// The kind's name.
            #[must_use]
            pub fn kind(&self) -> &'static str {
                match self { $(Self::$variant(_) => $name),+ }
            }

            /// The method.
            #[must_use]
            pub fn method(&self) -> &dyn Method {
                match self { $(Self::$variant(m) => m),+ }
            }

            /// Every kind with its default settings.
            #[must_use]
            pub fn defaults() -> Vec<Self> {
                vec![$(Self::$variant(<$type>::default())),+]
            }
        }
    };
}

methods! {
    /// Two analytical muscles.
    "kang" => Kang(crate::kang::Kang),
    /// Koopman/EDMDc.
    "koopman" => Koopman(crate::koopman::Koopman),
    /// Gated recurrent units.
    "gru" => Gru(crate::gru::Gru),
    /// Neural ODE without physics.
    "neural_ode" => NeuralOde(crate::neural_ode::NeuralOde),
    /// Linear spring and damper.
    "spring_damper" => SpringDamper(crate::spring_damper::LinearJoint),
    /// Published line of stiffness and position over the pressures.
    "equilibrium_point" => EquilibriumPoint(crate::equilibrium_point::EquilibriumModel),
    /// Sparse polynomial force.
    "sparse_force" => SparseForce(crate::sparse_force::SparseForce),
    /// Joint with a learned force.
    "hybrid" => Hybrid(crate::hybrid::Hybrid),
}
