//! Derivatives of whole functions, one file for each kind.
//!
//! | want | cheapest | cost in evaluations |
//! |---|---|---|
//! | `f'` of one number | [`derivative`] | 2 |
//! | gradient | [`gradient`] | about 5 |
//! | `J v` | [`jvp`] | about 3 |
//! | `wᵀ J` | [`vjp`] | about 5 |
//! | Jacobian `[m, n]`, few inputs | [`jacobian_forward`] | about 5 for every 8 inputs |
//! | Jacobian `[m, n]`, few outputs | [`jacobian_reverse`] | 3 and 2 for every output |
//! | `H v` | [`hessian_vector`] | about 12 |
//! | Hessian | [`hessian`] | about 5 for each of `n (n + 1) / 2` entries |
//!
//! A Rust closure cannot be generic over the scalar, so these take a [`Function`], which is a type with
//! one generic method. Where one number type is enough there is also a form for closures, named `…_of`.
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
pub use hessian_vector::{hessian_vector, hessian_vector_into, hessian_vector_of};
pub use jacobian::{
    CHUNK, jacobian_forward, jacobian_forward_into, jacobian_forward_of, jacobian_reverse,
    jacobian_reverse_into, jacobian_reverse_of,
};
pub use jvp::{jvp, jvp_into, jvp_of};
pub use vjp::{vjp, vjp_into, vjp_of};
pub use workspace::{Point, Recorder};
