//! Expressions: text in the notation of a formula, read into a tree.
//!
//! ```text
//! -(c1 + c2 * sign(v)) * v        1000 * if(t >= onset_s, 1, 0) * max(pf - p_atm, 0)
//! ```
//!
//! | | |
//! |---|---|
//! | operators | `+ - * / ^`, unary `-`, parentheses; `<  <=  >  >=  ==  !=`, which are 1 or 0 |
//! | one argument | `abs sign step exp expm1 log log1p sqrt sin cos tan asin acos atan sinh cosh tanh floor` |
//! | more arguments | `min(a, …)`, `max(a, …)`, `atan2(y, x)`, `clamp(a, low, high)`, `if(condition, a, b)` |
//! | constants | `pi`, `p_atm` (101.325 kPa) |
//!
//! `sign(0)` is 0, `step(u)` is 1 for `u ≥ 0`, and `if` takes `a` where the condition is not 0. `^` binds tighter than the
//! unary minus and associates to the right.
//!
//! This crate reads and does not evaluate. Who evaluates, does so with code of its own: a plant that hides a law and the
//! estimator that must find it share the notation and no arithmetic.
//!
//! ```
//! use pam_vocabulary::expression::{Expression, Scope};
//!
//! let names = ["v".to_owned(), "drag".to_owned()];
//! let scope = Scope::of(&names);
//! assert_eq!(Expression::parse("-drag * v * abs(v)", &scope)?.names(), [0, 1]);
//! let error = Expression::parse("-drag * w", &scope).expect_err("there is no w");
//! assert_eq!((error.line, error.column), (1, 9));
//! # Ok::<(), pam_vocabulary::expression::ExpressionError>(())
//! ```

mod error;
mod parse;
mod tokens;
mod tree;

pub use error::ExpressionError;
#[cfg(feature = "files")]
pub(crate) use error::nearest;
pub use parse::Scope;
pub use tree::{Binary, Expression, Function};

/// Names with a fixed value: π, and the atmospheric pressure in kPa.
pub const CONSTANTS: [(&str, f64); 2] = [("pi", std::f64::consts::PI), ("p_atm", 101.325)];
