//! The gradient methods that files and commands know by name.
//!
//! To add one: write its file, with [`GradientMethod`] and [`NamedMethod`] for the type, name the file in
//! `mod.rs`, and add one line to the list at the end of this module. A method that only a program needs is
//! handed to whatever takes a [`GradientMethod`], without a name.

#[cfg(doc)]
use super::GradientMethod;
use super::{AnyGradientMethod, Direction};
use crate::controller::StepController;
use crate::input::ParametricInput;
use crate::integrator::Integrator;
use pam_autodiff::ByTape;
use pam_core::{ModelError, ParametricField};

/// Settings from which a gradient method is made by its name.
#[derive(Debug, Clone)]
pub struct MethodSetup<C> {
    /// Method and step control of the forward solve; continuous methods solve backwards with the same.
    pub integrator: Integrator<C>,
    /// Directions of the derivative; all of them if absent. Methods whose cost does not grow with the
    /// directions return all of them and ignore this.
    pub directions: Option<Vec<Direction>>,
    /// Smallest scale of parameters of the field, of initial states and of parameters of the input, for
    /// methods that step by them.
    pub floors: [f64; 3],
}

/// A gradient method that can be made from its name and a [`MethodSetup`].
pub trait NamedMethod<C> {
    /// Each direction costs solves of its own, so the work on one problem is worth distributing over
    /// threads.
    const PAYS_BY_DIRECTION: bool = false;

    /// The method.
    fn from_setup(setup: MethodSetup<C>) -> Self;
}

macro_rules! gradient_methods {
    ($($(#[doc = $doc:literal])+ $name:literal => $variant:ident($module:ident::$type:ident $(<$($of:ty),+>)?)),+ $(,)?) => {
        $(pub use super::$module::$type;)+

        /// A gradient method by its name.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum GradientChoice {
            $($(#[doc = $doc])+ $variant),+
        }

        impl GradientChoice {
            /// Every choice with its name in files and on the command line.
            pub const ALL: &'static [(&'static str, Self)] = &[$(($name, Self::$variant)),+];

            /// The method in a few words.
            #[must_use]
            pub fn describe(self) -> &'static str {
                match self { $(Self::$variant => concat!($($doc),+).trim_ascii()),+ }
            }

            /// [`NamedMethod::PAYS_BY_DIRECTION`] of the method with the step control `C`.
            #[must_use]
            pub fn pays_by_direction<C>(self) -> bool
            where
                C: StepController + Clone + 'static,
            {
                match self {
                    $(Self::$variant => {
                        <super::$module::$type $(<$($of),+>)? as NamedMethod<C>>::PAYS_BY_DIRECTION
                    })+
                }
            }

            /// The method for problems of a field and an input.
            #[must_use]
            pub fn method<F, I, C>(self, setup: MethodSetup<C>) -> AnyGradientMethod<F, I>
            where
                F: ParametricField,
                I: ParametricInput,
                C: StepController + Clone + 'static,
            {
                match self {
                    $(Self::$variant => {
                        Box::new(<super::$module::$type $(<$($of),+>)?>::from_setup(setup))
                    })+
                }
            }
        }
    };
}

impl GradientChoice {
    /// The choice of this name.
    ///
    /// # Errors
    /// [`ModelError::UnknownName`] with the names that exist.
    pub fn from_name(name: &str) -> Result<Self, ModelError> {
        Self::ALL.iter().find(|(n, _)| *n == name).map(|(_, choice)| *choice).ok_or_else(|| {
            let known: Vec<&str> = Self::ALL.iter().map(|(n, _)| *n).collect();
            ModelError::UnknownName {
                kind: "gradient method",
                name: name.to_owned(),
                known: known.join(", "),
            }
        })
    }

    /// The name that [`from_name`](Self::from_name) understands.
    #[must_use]
    pub fn name(self) -> &'static str {
        Self::ALL.iter().find(|(_, choice)| *choice == self).map_or("", |(name, _)| name)
    }
}

gradient_methods! {
    /// exact adjoint of the accepted steps
    "adjoint" => Adjoint(discrete_adjoint::DiscreteAdjoint<ByTape>),
    /// tangents of the accepted steps, one for each number
    "forward" => Forward(forward::ForwardSensitivity<ByTape>),
    /// continuous adjoint, the state solved back with it
    "backsolve" => Backsolve(continuous::Backsolve<ByTape, C>),
    /// continuous adjoint along the interpolated forward solution
    "interpolating" => Interpolating(continuous::InterpolatingAdjoint<ByTape, C>),
    /// continuous adjoint, the parameters' part by quadrature
    "quadrature" => Quadrature(continuous::QuadratureAdjoint<ByTape, C>),
    /// a reverse-mode tape through the accepted steps
    "tape" => Tape(through_solver::TapeThroughSolver),
    /// dual numbers through the accepted steps
    "dual" => Dual(through_solver::DualThroughSolver),
    /// central differences of the solve with its steps held
    "fd" => FiniteDifference(finite_difference::FiniteDifference),
}
