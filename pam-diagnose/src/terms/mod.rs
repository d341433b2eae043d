//! Terms that nobody listed: what may be added to a system whose error no listed cause explains.
//!
//! A [`Term`] is a coefficient times functions of the system's [`Variable`]s, at a [`Place`] where it acts. A
//! [`Definition`] makes of terms what a system can simulate and fit, and a [`TermSpace`] is a system that takes definitions
//! for candidates beside those that it has. [`remainder`](crate::remainder) learns a smooth sum of many terms,
//! [`law`](crate::law) looks for a few that say the same.

mod definition;
mod function;
mod relaxing;
mod repeating;
mod space;
mod term;
mod unit;

pub(crate) use definition::as_quotient;
pub use definition::{Definition, Remembered, TermParameter};
pub use function::Function;
pub(crate) use relaxing::relaxing;
pub(crate) use repeating::{repeating, waves_along};
pub(crate) use space::is_dry_level;
pub use space::{Place, TermSpace, Variable, VariableKind};
pub(crate) use term::grouped;
pub use term::{Factor, Lag, Term};
pub use unit::Unit;
