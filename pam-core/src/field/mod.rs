//! Vector fields `ẏ = f(t, y, u)` with an exogenous input `u`.

mod friction;
mod names;

pub use friction::DryFriction;
pub use names::FieldNames;

use crate::scalar::Scalar;

/// A vector field `ẏ = f(t, y, u)` over any scalar.
///
/// `y` has [`state_len`](VectorField::state_len) entries and `u` has
/// [`input_len`](VectorField::input_len). The caller supplies scratch memory, so that an
/// evaluation allocates nothing and the field can be shared between threads.
///
/// Time is always `f64`: a 70 s recording at 1 kHz is past what `f32` resolves, and times are where
/// steps are placed, not what is differentiated.
///
/// ```
/// use pam_core::{Scalar, VectorField};
///
/// /// `ẋ = v`, `v̇ = u − x`.
/// struct Oscillator;
///
/// impl<S: Scalar> VectorField<S> for Oscillator {
///     fn state_len(&self) -> usize {
///         2
///     }
///     fn input_len(&self) -> usize {
///         1
///     }
///     fn eval_into(&self, _t: f64, y: &[S], u: &[S], dy: &mut [S], _work: &mut [S]) {
///         dy[0] = y[1];
///         dy[1] = u[0] - y[0];
///     }
/// }
///
/// let mut dy = [0.0; 2];
/// Oscillator.eval_into(0.0, &[1.0, 2.0], &[3.0], &mut dy, &mut []);
/// assert_eq!(dy, [2.0, 2.0]);
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no vector field over `{S}`",
    label = "a vector field over `{S}` is needed here",
    note = "implement `VectorField<S>` for it with `impl<S: Scalar>`, or wrap a closure: \
            `FieldFn::new(states, inputs, |t, y: &[f64], u: &[f64], dy: &mut [f64]| …)`"
)]
pub trait VectorField<S: Scalar> {
    /// Number of states.
    fn state_len(&self) -> usize;

    /// Number of inputs.
    fn input_len(&self) -> usize;

    /// Number of scratch scalars that [`eval_into`](VectorField::eval_into) needs.
    fn work_len(&self) -> usize {
        0
    }

    /// Writes `f(t, y, u)` to `dy`; `work` holds at least [`work_len`](VectorField::work_len)
    /// scalars of any content.
    fn eval_into(&self, t: f64, y: &[S], u: &[S], dy: &mut [S], work: &mut [S]);

    /// Number of outputs `h(t, y, u)` that the field has beside its states; none unless it says so.
    fn output_len(&self) -> usize {
        0
    }

    /// Writes the outputs `h(t, y, u)` to `out`, which has [`output_len`](VectorField::output_len) entries: what a
    /// sensor shows that is no state, such as a force, an acceleration or a voltage. Written over the scalar, so
    /// that derivatives go through.
    fn outputs_into(&self, t: f64, y: &[S], u: &[S], out: &mut [S]) {
        let _ = (t, y, u, out);
    }
}

impl<S: Scalar, F: VectorField<S> + ?Sized> VectorField<S> for &F {
    fn state_len(&self) -> usize {
        (**self).state_len()
    }
    fn input_len(&self) -> usize {
        (**self).input_len()
    }
    fn work_len(&self) -> usize {
        (**self).work_len()
    }
    fn eval_into(&self, t: f64, y: &[S], u: &[S], dy: &mut [S], work: &mut [S]) {
        (**self).eval_into(t, y, u, dy, work);
    }
    fn output_len(&self) -> usize {
        (**self).output_len()
    }
    fn outputs_into(&self, t: f64, y: &[S], u: &[S], out: &mut [S]) {
        (**self).outputs_into(t, y, u, out);
    }
}

/// A vector field whose numbers can be exchanged: with dual numbers or tape variables in place of its
/// parameters it differentiates, with other floats it is another member of the family.
///
/// A field written as a struct over its scalar is one in a few lines:
///
/// ```
/// use pam_core::{ParametricField, Scalar, VectorField};
///
/// /// `ẍ = μ (1 − x²) ẋ − x`
/// struct VanDerPol<S> {
///     mu: S,
/// }
///
/// impl<S: Scalar> VectorField<S> for VanDerPol<S> {
///     fn state_len(&self) -> usize {
///         2
///     }
///     fn input_len(&self) -> usize {
///         0
///     }
///     fn eval_into(&self, _t: f64, y: &[S], _u: &[S], dy: &mut [S], _work: &mut [S]) {
///         dy[0] = y[1];
///         dy[1] = self.mu * (S::constant(1.0) - y[0] * y[0]) * y[1] - y[0];
///     }
/// }
///
/// impl ParametricField for VanDerPol<f64> {
///     type With<S: Scalar> = VanDerPol<S>;
///     fn parameters(&self) -> Vec<f64> {
///         vec![self.mu]
///     }
///     fn with_parameters<S: Scalar>(&self, parameters: &[S]) -> VanDerPol<S> {
///         VanDerPol { mu: parameters[0] }
///     }
/// }
/// ```
#[diagnostic::on_unimplemented(
    message = "the numbers of `{Self}` cannot be exchanged, so that it cannot be differentiated",
    label = "a field with parameters is needed here",
    note = "make the field a struct over its scalar and implement `ParametricField` for the one over `f64`; \
            a closure (`FieldFn`) can be solved but not differentiated, use `field_fn!` in its place"
)]
pub trait ParametricField: VectorField<f64> {
    /// The same field over another scalar.
    type With<S: Scalar>: VectorField<S>;

    /// The parameters as they are, in the field's fixed order.
    fn parameters(&self) -> Vec<f64>;

    /// Number of parameters.
    fn parameter_len(&self) -> usize {
        self.parameters().len()
    }

    /// The field with other numbers, given in the order of [`parameters`](Self::parameters).
    ///
    /// # Panics
    /// If there are not [`parameter_len`](Self::parameter_len) of them.
    fn with_parameters<S: Scalar>(&self, parameters: &[S]) -> Self::With<S>;

    /// Names of states, inputs, outputs and parameters, for reports, sentences and files; `state_0`, `input_0`, …
    /// where there are none.
    fn names(&self) -> FieldNames {
        FieldNames::default()
    }

    /// The dry friction in the field, with which it sticks; none unless it says so.
    fn dry_friction(&self) -> Option<DryFriction> {
        None
    }
}

impl<F: ParametricField> ParametricField for &F {
    type With<S: Scalar> = F::With<S>;
    fn parameters(&self) -> Vec<f64> {
        (**self).parameters()
    }
    fn parameter_len(&self) -> usize {
        (**self).parameter_len()
    }
    fn with_parameters<S: Scalar>(&self, parameters: &[S]) -> Self::With<S> {
        (**self).with_parameters(parameters)
    }
    fn names(&self) -> FieldNames {
        (**self).names()
    }
    fn dry_friction(&self) -> Option<DryFriction> {
        (**self).dry_friction()
    }
}

/// A vector field from something like a closure `|t, y, u, p, dy|` that differentiates too: with parameters
/// `p` for the ones given, states, inputs, and a body that runs over any scalar.
///
/// `field_fn!([PARAMETERS], INPUTS => STATES, |t, y, u, p, dy| BODY)` is an expression whose type implements
/// [`VectorField`] and [`ParametricField`]. Unlike a closure's, the body sees no variables of its surroundings
/// (it is a function over a scalar `S`): what varies is a parameter, what does not is written down as
/// `S::constant(9.81)`. Numbers of states and inputs are constants. Functions like `sin` are those of
/// `num_dual::DualNum`, which must be in scope.
///
/// ```
/// use num_dual::DualNum;
/// use pam_core::{ParametricField, Scalar, VectorField, field_fn};
///
/// // A pendulum with damping p[0], driven by u: `ẍ = u − p ẋ − 9.81 sin x`.
/// let pendulum = field_fn!([0.1], 1 => 2, |_t, y, u, p, dy| {
///     dy[0] = y[1];
///     dy[1] = u[0] - p[0] * y[1] - S::constant(9.81) * y[0].sin();
/// });
/// let mut dy = [0.0; 2];
/// pendulum.eval_into(0.0, &[0.0, 2.0], &[1.0], &mut dy, &mut []);
/// assert_eq!(dy, [2.0, 0.8]);
/// assert_eq!(pendulum.parameters(), [0.1]);
/// ```
#[macro_export]
macro_rules! field_fn {
    ([$($parameter:expr),* $(,)?], $inputs:expr => $states:expr,
     |$t:pat_param, $y:pat_param, $u:pat_param, $p:pat_param, $dy:pat_param| $body:expr) => {{
        #[derive(Debug, Clone)]
        struct FieldOfParameters<S>(::std::vec::Vec<S>);

        impl<S: $crate::Scalar> $crate::VectorField<S> for FieldOfParameters<S> {
            fn state_len(&self) -> usize {
                $states
            }
            fn input_len(&self) -> usize {
                $inputs
            }
            fn eval_into(&self, $t: f64, $y: &[S], $u: &[S], $dy: &mut [S], _work: &mut [S]) {
                let $p: &[S] = &self.0;
                $body;
            }
        }

        impl $crate::ParametricField for FieldOfParameters<f64> {
            type With<S: $crate::Scalar> = FieldOfParameters<S>;
            fn parameters(&self) -> ::std::vec::Vec<f64> {
                self.0.clone()
            }
            fn parameter_len(&self) -> usize {
                self.0.len()
            }
            fn with_parameters<S: $crate::Scalar>(&self, parameters: &[S]) -> FieldOfParameters<S> {
                assert_eq!(parameters.len(), self.0.len(), "as many parameters as the field has");
                FieldOfParameters(parameters.to_vec())
            }
        }

        FieldOfParameters::<f64>(::std::vec![$($parameter),*])
    }};
}

/// A vector field from a closure `|t, y, u, dy|`. It can be solved; one that can be differentiated too is
/// made by [`field_fn!`](crate::field_fn).
///
/// ```
/// use pam_core::{FieldFn, VectorField};
/// let decay = FieldFn::new(1, 0, |_t, y: &[f64], _u: &[f64], dy: &mut [f64]| dy[0] = -y[0]);
/// let mut dy = [0.0];
/// decay.eval_into(0.0, &[2.0], &[], &mut dy, &mut []);
/// assert_eq!(dy, [-2.0]);
/// ```
#[derive(Debug, Clone, Copy)]
pub struct FieldFn<F> {
    state_len: usize,
    input_len: usize,
    function: F,
}

impl<F> FieldFn<F> {
    /// A field of `state_len` states and `input_len` inputs.
    pub fn new(state_len: usize, input_len: usize, function: F) -> Self {
        Self { state_len, input_len, function }
    }
}

impl<S: Scalar, F: Fn(f64, &[S], &[S], &mut [S])> VectorField<S> for FieldFn<F> {
    fn state_len(&self) -> usize {
        self.state_len
    }
    fn input_len(&self) -> usize {
        self.input_len
    }
    fn eval_into(&self, t: f64, y: &[S], u: &[S], dy: &mut [S], _work: &mut [S]) {
        (self.function)(t, y, u, dy);
    }
}
