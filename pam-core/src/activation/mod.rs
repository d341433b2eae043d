//! Activation functions of the learned force, one file each.
//!
//! Smooth activations give a stiffness that varies continuously; piecewise-linear ones (LeakyReLU,
//! ReLU) give a force that is piecewise affine, with a stiffness that is constant inside one
//! activation pattern and jumps between patterns.
//!
//! To add one: write its file with a type that implements [`ActivationFunction`], and add one line
//! to the list at the end of this module. It can then be named in files and on the command line.
//! A type of another crate gets a name with [`NamedActivation`] and [`register`]. One that only a script needs is given to
//! [`Mlp`](crate::Mlp) directly, without a name.

mod batch;
mod elu;
mod gelu;
mod leaky_relu;
mod own;
mod relu;
mod silu;
mod sine;
mod softplus;
mod tanh;

pub use own::{ChosenActivation, NamedActivation, OwnActivation, register, registered};

use crate::error::ModelError;
use crate::scalar::Scalar;
use crate::simd::Float;
use num_dual::Dual;
use std::fmt;

/// An elementwise nonlinearity `σ(z)`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no activation",
    note = "implement `ActivationFunction` with `fn value<S: Scalar>(&self, z: S) -> S`; the type must be \
            `Copy + Send + Sync + 'static`"
)]
pub trait ActivationFunction: Copy + Send + Sync + 'static {
    /// The slope for negative `z` if `σ` is a (leaky) ReLU, `max(z, slope · z)` with a slope from 0 to 1:
    /// batches then need no pass of their own for it.
    fn relu_slope(&self) -> Option<f64> {
        None
    }

    /// `σ(z)` for any scalar; at a kink the derivative is that of the left side.
    fn value<S: Scalar>(&self, z: S) -> S;

    /// `(σ(z), σ'(z))` of a plain float, for batches. An override without branches and calls, as
    /// the named activations have (see [`simd::math`](crate::simd::math)), runs on whole vectors; the
    /// dual number that stands in otherwise is as exact but slower.
    #[inline(always)]
    fn value_and_slope<T: Float>(&self, z: T) -> (T, T)
    where
        Self: Sized,
    {
        let y = self.value(Dual::new(z, T::narrow(1.0)));
        (y.re, y.eps)
    }

    /// Replaces each `z` by `σ(z)`.
    fn apply_to_batch<T: Float>(&self, z: &mut [T])
    where
        Self: Sized,
    {
        batch::values(self, z);
    }

    /// Replaces each `z` by `σ(z)` and writes `σ'(z)` to `slopes`.
    ///
    /// # Panics
    /// If the lengths differ.
    fn apply_to_batch_with_slopes<T: Float>(&self, z: &mut [T], slopes: &mut [T])
    where
        Self: Sized,
    {
        batch::values_and_slopes(self, z, slopes);
    }
}

macro_rules! activations {
    ($($(#[$doc:meta])* $name:literal => $variant:ident($module:ident::$type:ident)),+ $(,)?) => {
        /// The activations that have a name in files and on the command line.
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub enum Activation {
            $($(#[$doc])* $variant($module::$type),)+
            /// One of another crate.
            Own(OwnActivation),
        }

        $(pub use $module::$type;)+

        impl Activation {
            /// Every built-in name, in the order of the list. [`names`](Self::names) has those of other crates besides.
            pub const NAMES: &'static [&'static str] = &[$($name),+];

            /// The activation of this name with its default parameters.
            ///
            /// # Errors
            /// [`ModelError::UnknownPart`] with the names that exist.
            pub fn from_name(name: &str) -> Result<Self, ModelError> {
                match name {
                    $($name => Ok(Self::$variant($module::$type::default())),)+
                    _ => Self::registered_as(name).map(Self::Own),
                }
            }

            /// The parameters of the activation as JSON, `null` if it has none.
            #[must_use]
            pub fn parameters_json(&self) -> String {
                match self {
                    // Numbers and names are what JSON can hold.
                    $(Self::$variant(a) => serde_json::to_string(a).unwrap_or_default(),)+
                    Self::Own(a) => a.parameters_json(),
                }
            }

            /// The activation of this name with the parameters of [`parameters_json`](Self::parameters_json).
            ///
            /// # Errors
            /// [`ModelError`] if there is no such activation or the parameters are not its own.
            pub fn from_name_and_json(name: &str, parameters: &str) -> Result<Self, ModelError> {
                let wrong = |e: serde_json::Error| {
                    ModelError::Shape(format!("parameters of activation {name}: {e}"))
                };
                match name {
                    $($name => serde_json::from_str(parameters).map(Self::$variant).map_err(wrong),)+
                    _ => Self::registered_as(name)?.with_parameters_json(parameters).map(Self::Own),
                }
            }

            /// The name that [`from_name`](Activation::from_name) understands.
            #[must_use]
            pub fn name(&self) -> &'static str {
                match self { $(Self::$variant(_) => $name,)+ Self::Own(a) => a.name() }
            }
        }

        impl ActivationFunction for Activation {
            #[inline]
            fn value<S: Scalar>(&self, z: S) -> S {
                match self { $(Self::$variant(a) => a.value(z),)+ Self::Own(a) => a.value(z) }
            }
            fn relu_slope(&self) -> Option<f64> {
                match self { $(Self::$variant(a) => a.relu_slope(),)+ Self::Own(a) => a.relu_slope() }
            }
            #[inline(always)]
            fn value_and_slope<T: Float>(&self, z: T) -> (T, T) {
                match self { $(Self::$variant(a) => a.value_and_slope(z),)+ Self::Own(a) => a.value_and_slope(z) }
            }
            fn apply_to_batch<T: Float>(&self, z: &mut [T]) {
                T::activate(self, z);
            }
            fn apply_to_batch_with_slopes<T: Float>(&self, z: &mut [T], slopes: &mut [T]) {
                T::activate_with_slopes(self, z, slopes);
            }
        }

        impl Activation {
            /// Implements [`Float::activate`].
            pub(crate) fn apply_to_any_batch<T: Float>(&self, z: &mut [T]) {
                match self {
                    $(Self::$variant(a) => a.apply_to_batch(z),)+
                    Self::Own(a) => T::activate_own(a, z),
                }
            }

            /// Implements [`Float::activate_with_slopes`].
            pub(crate) fn apply_to_any_batch_with_slopes<T: Float>(
                &self,
                z: &mut [T],
                slopes: &mut [T],
            ) {
                match self {
                    $(Self::$variant(a) => a.apply_to_batch_with_slopes(z, slopes),)+
                    Self::Own(a) => T::activate_own_with_slopes(a, z, slopes),
                }
            }
        }

        impl Activation {
            /// Applies the activation in place; the choice of function is made once.
            #[inline]
            pub fn apply<S: Scalar>(&self, values: &mut [S]) {
                match self { $(Self::$variant(a) => apply(a, values),)+ Self::Own(a) => apply(a, values) }
            }
        }
    };
}

impl Activation {
    /// Every name that [`from_name`](Self::from_name) understands: the built-in ones, then those that were
    /// [registered](register).
    #[must_use]
    pub fn names() -> Vec<&'static str> {
        let own = registered();
        Self::NAMES.iter().copied().chain(own.iter().map(OwnActivation::name)).collect()
    }

    fn registered_as(name: &str) -> Result<OwnActivation, ModelError> {
        registered().into_iter().find(|own| own.name() == name).ok_or_else(|| {
            ModelError::UnknownPart {
                kind: "activation",
                name: name.to_owned(),
                known: Self::names().join(", "),
            }
        })
    }
}

/// Applies any activation function in place.
#[inline]
pub fn apply<S: Scalar, A: ActivationFunction>(activation: &A, values: &mut [S]) {
    for v in values {
        *v = activation.value(*v);
    }
}

impl fmt::Display for Activation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

activations! {
    /// `max(z, 0) + 0.01 min(z, 0)`; the published weights use it.
    "leaky_relu" => LeakyRelu(leaky_relu::LeakyRelu),
    /// `max(z, 0)`.
    "relu" => Relu(relu::Relu),
    /// Hyperbolic tangent.
    "tanh" => Tanh(tanh::Tanh),
    /// `ln(1 + eᶻ)`.
    "softplus" => Softplus(softplus::Softplus),
    /// `z / (1 + e⁻ᶻ)`.
    "silu" => Silu(silu::Silu),
    /// `z Φ(z)` in its tanh form.
    "gelu" => Gelu(gelu::Gelu),
    /// `z` for positive `z`, `eᶻ − 1` otherwise.
    "elu" => Elu(elu::Elu),
    /// `sin z`.
    "sine" => Sine(sine::Sine),
}
