//! The saved points of a solve.

/// The points of a solution that are saved.
///
/// ```
/// use pam_core::FieldFn;
/// use pam_solvers::{Integrator, NoInput, PidController, SaveAt, Tableau, Term};
///
/// // ẏ = −2 y from y = 1, at three times.
/// let decay = FieldFn::new(1, 0, |_t, y: &[f64], _u: &[f64], dy: &mut [f64]| dy[0] = -2.0 * y[0]);
/// let (term, times_s) = (Term::new(decay, NoInput), [0.0, 0.5, 1.0]);
/// let integrator = Integrator::new(Tableau::tsit5(), PidController::new(1e-9, 1e-9));
/// let run = integrator.solve(&term, 0.0, 1.0, &[1.0], SaveAt::Times(&times_s))?;
/// assert_eq!(run.times_s(), times_s);
/// assert!((run.state(1)[0] - (-1.0_f64).exp()).abs() < 1e-7);
///
/// // Nothing but the end.
/// let end = integrator.solve(&term, 0.0, 1.0, &[1.0], SaveAt::End)?;
/// assert_eq!(end.times_s(), [1.0]);
/// # Ok::<(), Box<pam_solvers::SolveError<f64>>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SaveAt<'a> {
    /// The final state only.
    End,
    /// The initial state and the end of every accepted step.
    Steps,
    /// The states at these times, increasing and inside the interval of the solve. Times inside a
    /// step are read from the method's interpolant.
    Times(&'a [f64]),
    /// Everything: the step ends, and the stages, from which
    /// [`DenseSolution`](crate::DenseSolution) evaluates the solution anywhere.
    Dense,
}
