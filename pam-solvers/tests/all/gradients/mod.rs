//! Gradients through the solver: every method on every problem, orders of convergence, and known traps.

mod case;
mod continuous;
mod convergence;
mod fields;
mod inputs;
mod matrix;
mod named;
mod one_by_one;
mod requests;
mod traps;
