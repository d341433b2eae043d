//! Where the verdict falls: from the chosen set to names that stand.
//!
//! `naming` rejects names and describes the [`Cause`]s that are left; `outcome` has the rule of the [`Verdict`];
//! `explainable` measures how much any correction could remove.

mod cause;
mod explainable;
mod naming;
mod outcome;

pub(crate) use cause::ranking;
pub use cause::{Cause, Rank};
pub use explainable::ExplainableReference;
pub(crate) use naming::Naming;
pub(crate) use outcome::share;
pub use outcome::{ChiSquares, Verdict};
