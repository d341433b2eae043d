//! Automatic differentiation straight through the solver: the replayed solve with other numbers.

mod dual;
mod tape;

pub use dual::DualThroughSolver;
pub use tape::TapeThroughSolver;
