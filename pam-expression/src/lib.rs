//! Expressions over named numbers, evaluated with any scalar.
//!
//! The text is read by [`pam_vocabulary::expression`]. A tree becomes a [`Graph`], in which equal parts are one node and which
//! is differentiated where a rule needs a slope, and that a [`Program`] over a few registers: with plain numbers it simulates,
//! with dual numbers and tape variables it is differentiated, and nothing is allocated.
//!
//! [`Compiled`] is one expression over a list of names. [`Terms`] are expressions that are added to the rates of any
//! [`VectorField`](pam_core::VectorField), each with parameters of its own, which can be fitted, trained and diagnosed like
//! the field's.

mod compiled;
mod graph;
mod program;
mod slopes;
mod terms;

pub use compiled::{Compiled, too_long};
pub use graph::{Graph, Id};
pub use program::{Inputs, MOST_REGISTERS, Program};
pub use terms::{Term, Terms, WithTerms};
