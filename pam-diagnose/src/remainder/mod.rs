//! What no listed cause explains: a smooth correction that is learned through the simulation.
//!
//! A correction is a sum of terms of low order in everything that the system knows: powers, directions and bends of its
//! variables, products of two, and what is remembered of them. Its coefficients are fitted by Levenberg–Marquardt with the
//! sensitivities of the simulation, as those of a cause are, with a Gaussian prior about zero whose width the validation data
//! choose. Where a correction acts (on the forces, in the air, at a sensor; in the rate of one state of a field) is chosen in
//! the same way. Leaving out all terms of a variable, on blocks of data that were not fitted, shows whether the correction
//! depends on it.
//!
//! [`law`](crate::law) looks for a short expression that says the same.

mod basis;
mod dependence;
mod ground;
mod learn;
mod learned;
mod lines;
mod result;
mod sparse;

pub(crate) use dependence::dependence;
#[cfg(feature = "laws")]
pub(crate) use ground::{Budget, is_replaceable, named_and_settled, nothing_left};
pub(crate) use ground::{Dyn, Ground, most_left};
pub(crate) use learn::{learn, learn_again};
pub(crate) use learned::{Learned, validation_errors};
pub use result::{Correction, Dependence, Remainder, RemainderOutcome};
