//! Derivatives of whole functions, one file for each kind.
//!
//! | want | function | work |
//! |---|---|---|
//! | `f'` of one number | [`derivative`] | one run with a dual number |
//! | gradient | [`gradient`] | one recorded run, one sweep |
//! | `J v` | [`jvp`] | one run with dual numbers |
//! | `wᵀ J` | [`vjp`] | one recorded run, one sweep |
//! | Jacobian `[m, n]`, few inputs | [`jacobian_forward`] | a run with chunks for every 8 inputs |
//! | Jacobian `[m, n]`, few outputs | [`jacobian_reverse`] | one recorded run, `m` sweeps |
//! | `H v` | [`hessian_vector`] | one recorded run and sweep with dual numbers |
//! | Hessian | [`hessian`] | `n (n + 1) / 2` runs with hyper-dual numbers |
//!
//! Roughly, in plain runs: with dual numbers 2 to 7, with a chunk 35, with hyper-duals 15, recorded and
//! swept 10. The upper ends are those of a network, whose plain run has vector instructions.
//!
//! A Rust closure cannot be generic over the scalar, so these take a [`Function`], which is a type with
//! one generic method; [`gradient_of`] takes a closure over tape variables.
//! Functions named `…_into` write to the caller's memory and allocate nothing once their workspace,
//! a [`Recorder`] or a [`Point`], has seen a call of the size.

mod derivative;
mod function;
mod gradient;
mod hessian;
mod hessian_vector;
mod jacobian;
mod jvp;
mod vjp;
mod workspace;

pub use derivative::derivative;
pub use function::Function;
pub use gradient::{gradient, gradient_into, gradient_of};
pub use hessian::hessian;
pub use hessian_vector::{hessian_vector, hessian_vector_into};
pub use jacobian::{
    CHUNK, jacobian_forward, jacobian_forward_into, jacobian_reverse, jacobian_reverse_into,
};
pub use jvp::{jvp, jvp_into};
pub use vjp::{vjp, vjp_into};
pub use workspace::{Point, Recorder};
