//! Vector fields `ẏ = f(t, y, u)` with an exogenous input `u`.

use crate::scalar::Scalar;

/// A vector field `ẏ = f(t, y, u)` over any scalar.
///
/// `y` has [`state_len`](VectorField::state_len) entries and `u` has
/// [`input_len`](VectorField::input_len). The caller supplies scratch memory, so that an
/// evaluation allocates nothing and the field can be shared between threads.
///
/// Time is always `f64`: a 70 s recording at 1 kHz is past what `f32` resolves, and times are where
/// steps are placed, not what is differentiated.
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
            a closure (`FieldFn`) can be solved but not differentiated"
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
}

/// A vector field from a closure `|t, y, u, dy|`.
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
