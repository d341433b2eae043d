//! Number types that carry derivatives, beside those of `num-dual`.
//!
//! - [`chunk`]: forward mode for `N` directions at once;
//! - [`complex`]: complex numbers for the complex-step method;
//! - the reverse-mode variable is in [`tape`](crate::tape).
//!
//! `num-dual` asks a number for some forty operator and function traits. They are written once here:
//! the operators for any type that can add, multiply and divide, and the elementary functions for
//! any type that knows the chain rule for one and for two arguments. The value of every function is
//! that of the inner number's own function, so a run with derivatives and a plain run see the same
//! values bit by bit.

#[macro_use]
mod operators;
#[macro_use]
mod chain;
pub mod chunk;
pub mod complex;
pub(crate) mod rules;
mod spherical;

pub(crate) use chain::ChainRule;
pub use chunk::Chunk;
pub use complex::ComplexStep;
pub(crate) use operators::{Arithmetic, lift};
