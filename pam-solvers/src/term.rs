//! The right-hand side of a solve: a vector field with its input.

use crate::input::{Input, Side};
use pam_core::{Scalar, VectorField};

/// A vector field `f(t, y, u)` and its input `u(t)`.
///
/// ```
/// use pam_core::FieldFn;
/// use pam_solvers::{InputFn, Integrator, PidController, SaveAt, Tableau, Term};
///
/// // ẏ = u(t) with u = cos t has y = sin t.
/// let field = FieldFn::new(1, 1, |_t, _y: &[f64], u: &[f64], dy: &mut [f64]| dy[0] = u[0]);
/// let term = Term::new(field, InputFn::new(1, |t: f64, u: &mut [f64]| u[0] = t.cos()));
/// let integrator = Integrator::new(Tableau::tsit5(), PidController::new(1e-9, 1e-9));
/// let run = integrator.solve(&term, 0.0, 2.0, &[0.0], SaveAt::End)?;
/// assert!((run.state(0)[0] - 2.0_f64.sin()).abs() < 1e-7);
/// # Ok::<(), Box<pam_solvers::SolveError<f64>>>(())
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Term<F, I> {
    /// The vector field.
    pub field: F,
    /// The input.
    pub input: I,
}

impl<F, I> Term<F, I> {
    /// Joins a field and an input; the number of inputs is checked when a solve starts.
    pub fn new(field: F, input: I) -> Self {
        Self { field, input }
    }

    /// Writes `f(t, y, u(t±))` to `dy`. `u` and `work` are scratch memory of the lengths that input
    /// and field ask for.
    #[inline]
    pub fn eval_into<S: Scalar>(
        &self,
        t: f64,
        side: Side,
        y: &[S],
        dy: &mut [S],
        u: &mut [S],
        work: &mut [S],
    ) where
        F: VectorField<S>,
        I: Input<S>,
    {
        self.input.value_into(t, side, u);
        self.field.eval_into(t, y, u, dy, work);
    }
}
