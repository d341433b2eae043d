//! The saved points of a solve.

/// The points of a solution that are saved.
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
