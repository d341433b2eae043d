//! All candidates at once, to first order.
//!
//! At a fitted hypothesis every candidate has directions: the change of the whitened residual by each of its parameters, and
//! by switching it on, at each of its starting values. Cleared of what nuisances and the members of the hypothesis can
//! imitate, their inner products tell for *every* set of candidates what it would explain, by least
//! squares, without a further simulation. So no pair is missed of which neither member shows alone, and the null
//! distribution of the largest score needs no fits ([`NullTest`](crate::rejection::NullTest)).

mod gram;
mod subsets;

pub(crate) use gram::{Column, HELD, Linearised, Products, Start, all_starts, directions};
pub(crate) use subsets::{Imitators, Subset};
