//! Activations of other crates that files and command lines know by name.

use super::{Activation, ActivationFunction};
use crate::error::ModelError;
use crate::scalar::Scalar;
use crate::simd::Float;
use num_dual::{Dual3, Dual64};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::any::TypeId;
use std::fmt;
use std::sync::{PoisonError, RwLock};

/// A custom activation with the name that it has in curricula, sweeps and model files.
///
/// Its parameters, if it has any, are its fields; model files keep them.
///
/// ```
/// use pam_core::activation::{NamedActivation, register};
/// use pam_core::{Activation, ActivationFunction, Scalar};
/// use serde::{Deserialize, Serialize};
///
/// /// `z + sin²(a z) / a` (Ziyin et al. 2020).
/// #[derive(Debug, Clone, Copy, Serialize, Deserialize)]
/// struct Snake {
///     frequency: f64,
/// }
///
/// impl ActivationFunction for Snake {
///     fn value<S: Scalar>(&self, z: S) -> S {
///         let s = z.scaled(self.frequency).sin();
///         z + (s * s).scaled(1.0 / self.frequency)
///     }
/// }
///
/// impl NamedActivation for Snake {
///     const NAME: &'static str = "snake";
/// }
///
/// register(&Snake { frequency: 2.0 })?;
/// let known = Activation::from_name("snake")?;
/// assert_eq!(known.value(0.3_f64), Snake { frequency: 2.0 }.value(0.3));
/// # Ok::<(), pam_core::ModelError>(())
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no activation with a name",
    note = "implement `ActivationFunction` and `NamedActivation` for it, and derive `serde::Serialize` and \
            `serde::Deserialize`"
)]
pub trait NamedActivation: ActivationFunction + Serialize + DeserializeOwned {
    /// Its name; none of the built-in ones ([`Activation::NAMES`]).
    const NAME: &'static str;
}

/// Batches of one float.
trait Batch<T> {
    fn values(&self, z: &mut [T]);
    fn values_and_slopes(&self, z: &mut [T], slopes: &mut [T]);
}

impl<A: ActivationFunction, T: Float> Batch<T> for A {
    fn values(&self, z: &mut [T]) {
        self.apply_to_batch(z);
    }
    fn values_and_slopes(&self, z: &mut [T], slopes: &mut [T]) {
        self.apply_to_batch_with_slopes(z, slopes);
    }
}

/// [`NamedActivation`] without its type. Numbers of any type get values and derivatives at a point, from which
/// [`OwnActivation`] makes the number again.
trait Erased: Batch<f32> + Batch<f64> + Send + Sync {
    fn name(&self) -> &'static str;
    fn type_id(&self) -> TypeId;
    fn parameters(&self) -> Result<String, ModelError>;
    fn with_parameters(&self, json: &str) -> Result<OwnActivation, ModelError>;
    fn slope_of_relu(&self) -> Option<f64>;
    fn plain(&self, z: f64) -> f64;
    /// `σ, σ'`.
    fn first(&self, z: f64) -> [f64; 2];
    /// `σ, σ', σ'', σ'''`.
    fn third(&self, z: f64) -> [f64; 4];
    /// Derivatives zero to six.
    fn sixth(&self, z: f64) -> [f64; 7];
}

impl<A: NamedActivation> Erased for A {
    fn name(&self) -> &'static str {
        A::NAME
    }
    fn type_id(&self) -> TypeId {
        TypeId::of::<A>()
    }
    fn parameters(&self) -> Result<String, ModelError> {
        serde_json::to_string(self).map_err(|e| wrong(A::NAME, &e))
    }
    fn with_parameters(&self, json: &str) -> Result<OwnActivation, ModelError> {
        OwnActivation::new::<A>(&serde_json::from_str(json).map_err(|e| wrong(A::NAME, &e))?)
    }
    fn slope_of_relu(&self) -> Option<f64> {
        self.relu_slope()
    }
    fn plain(&self, z: f64) -> f64 {
        self.value(z)
    }
    fn first(&self, z: f64) -> [f64; 2] {
        let y = self.value(Dual64::new(z, 1.0));
        [y.re, y.eps]
    }
    fn third(&self, z: f64) -> [f64; 4] {
        let y = self.value(Dual3::new(z, 1.0, 0.0, 0.0));
        [y.re, y.v1, y.v2, y.v3]
    }
    fn sixth(&self, z: f64) -> [f64; 7] {
        // The third derivatives of the third derivative.
        let inner = Dual3::new(z, 1.0, 0.0, 0.0);
        let constant = |v| Dual3::new(v, 0.0, 0.0, 0.0);
        let y = self.value(Dual3::new(inner, constant(1.0), constant(0.0), constant(0.0)));
        [y.re.re, y.re.v1, y.re.v2, y.re.v3, y.v3.v1, y.v3.v2, y.v3.v3]
    }
}

fn wrong(name: &str, error: &serde_json::Error) -> ModelError {
    ModelError::Shape(format!("parameters of activation {name}: {error}"))
}

/// A [`NamedActivation`] as a value of [`Activation`].
///
/// Values and slopes of batches run the code of the type itself. Any other number gets the Taylor polynomial at its real
/// part, from derivatives by dual numbers: exact up to the sixth derivative.
#[derive(Clone, Copy)]
pub struct OwnActivation(&'static dyn Erased);

/// Every activation that was made or registered, one for each type and parameters.
static MADE: RwLock<Vec<OwnActivation>> = RwLock::new(Vec::new());

/// Activations of [`Activation::from_name`] other than the built-in ones. Entries are added and never replaced.
static REGISTERED: RwLock<Vec<OwnActivation>> = RwLock::new(Vec::new());

impl OwnActivation {
    /// The activation as a value.
    ///
    /// # Errors
    /// [`ModelError::Shape`] if its parameters are not what JSON can hold.
    pub fn new<A: NamedActivation>(activation: &A) -> Result<Self, ModelError> {
        let parameters = activation.parameters()?;
        let mut made = MADE.write().unwrap_or_else(PoisonError::into_inner);
        let same = |o: &&Self| {
            o.0.type_id() == TypeId::of::<A>()
                && o.0.parameters().is_ok_and(|known| known == parameters)
        };
        if let Some(known) = made.iter().find(same) {
            return Ok(*known);
        }
        // Networks copy their activation and live as long as they like. There are as many of these as there are sets of
        // parameters, a few in a process.
        let own = Self(Box::leak(Box::new(*activation)));
        made.push(own);
        Ok(own)
    }

    /// Its name.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.0.name()
    }

    /// Its parameters as JSON; `null` without any.
    #[must_use]
    pub fn parameters_json(&self) -> String {
        self.0.parameters().unwrap_or_else(|_| "null".into())
    }

    /// The same with the parameters of [`parameters_json`](Self::parameters_json).
    ///
    /// # Errors
    /// [`ModelError::Shape`] if they are not those of this activation.
    pub fn with_parameters_json(&self, parameters: &str) -> Result<Self, ModelError> {
        self.0.with_parameters(parameters)
    }

    pub(crate) fn batch<T>(&self, z: &mut [T])
    where
        Self: OfFloat<T>,
    {
        self.values_of(z);
    }

    pub(crate) fn batch_with_slopes<T>(&self, z: &mut [T], slopes: &mut [T])
    where
        Self: OfFloat<T>,
    {
        self.slopes_of(z, slopes);
    }
}

/// Chooses the batch of one float.
pub(crate) trait OfFloat<T> {
    fn values_of(&self, z: &mut [T]);
    fn slopes_of(&self, z: &mut [T], slopes: &mut [T]);
}

macro_rules! of_float {
    ($($float:ty),+) => {
        $(impl OfFloat<$float> for OwnActivation {
            fn values_of(&self, z: &mut [$float]) {
                Batch::<$float>::values(self.0, z);
            }
            fn slopes_of(&self, z: &mut [$float], slopes: &mut [$float]) {
                Batch::<$float>::values_and_slopes(self.0, z, slopes);
            }
        })+
    };
}

of_float!(f32, f64);

/// `Σ derivatives[k] / k! · (z − real part)ᵏ`.
fn taylor<S: Scalar>(z: S, derivatives: &[f64]) -> S {
    let away = z - S::constant(z.real());
    let mut divisors = vec![1.0; derivatives.len()];
    for k in 1..divisors.len() {
        divisors[k] = divisors[k - 1] * k as f64;
    }
    let mut coefficients =
        derivatives.iter().zip(divisors).rev().map(|(d, divisor)| S::constant(d / divisor));
    let highest = coefficients.next().unwrap_or_else(S::zero);
    coefficients.fold(highest, |sum, c| sum * away + c)
}

impl ActivationFunction for OwnActivation {
    fn relu_slope(&self) -> Option<f64> {
        self.0.slope_of_relu()
    }

    fn value<S: Scalar>(&self, z: S) -> S {
        let at = z.real();
        match S::NDERIV {
            0 => S::constant(self.0.plain(at)),
            1 => {
                let [value, slope] = self.0.first(at);
                S::with_slopes(value, [&z], [slope])
            }
            2 | 3 => taylor(z, &self.0.third(at)),
            _ => taylor(z, &self.0.sixth(at)),
        }
    }

    fn apply_to_batch<T: Float>(&self, z: &mut [T]) {
        T::activate(&Activation::Own(*self), z);
    }

    fn apply_to_batch_with_slopes<T: Float>(&self, z: &mut [T], slopes: &mut [T]) {
        T::activate_with_slopes(&Activation::Own(*self), z, slopes);
    }
}

impl PartialEq for OwnActivation {
    fn eq(&self, other: &Self) -> bool {
        self.0.type_id() == other.0.type_id() && self.parameters_json() == other.parameters_json()
    }
}

impl fmt::Debug for OwnActivation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.name(), self.parameters_json())
    }
}

/// Makes an activation known by its name to everything in this process that reads names: curricula, sweeps, options and
/// model files. Its parameters are those that hold where a name stands alone. To do so twice is no error.
///
/// # Errors
/// [`ModelError::NameTaken`] if another activation, or this one with other parameters, has the name.
pub fn register<A: NamedActivation>(activation: &A) -> Result<Activation, ModelError> {
    let own = OwnActivation::new(activation)?;
    let taken = |what: String| {
        Err(ModelError::NameTaken { kind: "activation", name: A::NAME.to_owned(), what })
    };
    if Activation::NAMES.contains(&A::NAME) {
        return taken("a built-in one".into());
    }
    let mut registered = REGISTERED.write().unwrap_or_else(PoisonError::into_inner);
    match registered.iter().find(|o| o.name() == A::NAME) {
        Some(known) if *known == own => {}
        Some(known) => return taken(format!("one with parameters {}", known.parameters_json())),
        None => registered.push(own),
    }
    Ok(Activation::Own(own))
}

/// The activations that were [registered](register), in that order.
#[must_use]
pub fn registered() -> Vec<OwnActivation> {
    REGISTERED.read().unwrap_or_else(PoisonError::into_inner).clone()
}

/// A reference to an activation: its name, a value of [`Activation`], or a custom type, which is [registered](register).
pub trait ChosenActivation {
    /// The activation.
    ///
    /// # Errors
    /// [`ModelError`] if there is no activation of this name, or another one has it.
    fn choose(self) -> Result<Activation, ModelError>;
}

impl ChosenActivation for &str {
    fn choose(self) -> Result<Activation, ModelError> {
        Activation::from_name(self)
    }
}

impl ChosenActivation for Activation {
    fn choose(self) -> Result<Activation, ModelError> {
        Ok(self)
    }
}

impl<A: NamedActivation> ChosenActivation for A {
    fn choose(self) -> Result<Activation, ModelError> {
        register(&self)
    }
}
