//! Automatic differentiation straight through the solver: the replayed solve with other numbers.

mod dual;
mod tape;

pub use dual::{DualThroughSolver, DualsThroughSolver};
pub use tape::TapeThroughSolver;
