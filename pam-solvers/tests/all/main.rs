//! Solvers and gradients through them: orders, analytic solutions, failures, and batches beside single lanes.

mod batched;
mod convergence;
mod dual;
mod failures;
mod gradients;
mod joint;
mod order_conditions;
mod replay;
mod sampled_input;
mod sticking;
mod zero_order_hold;
