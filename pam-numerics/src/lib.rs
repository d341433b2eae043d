//! Small numerical helpers that several crates share: descriptive statistics and the paired t-test
//! ([`statistics`]), Cholesky solves of scaled normal equations ([`cholesky`], [`least_squares()`]), [`eigenvalues()`], and a stable
//! hash of content ([`hash`]). The last two are behind features of their names, since each brings crates of its own.

pub mod cholesky;
#[cfg(feature = "eigenvalues")]
pub mod eigenvalues;
#[cfg(feature = "hash")]
pub mod hash;
pub mod least_squares;
pub mod square;
pub mod statistics;

pub use cholesky::ScaledCholesky;
#[cfg(feature = "eigenvalues")]
pub use eigenvalues::eigenvalues;
#[cfg(feature = "hash")]
pub use hash::ContentHash;
pub use least_squares::least_squares;
pub use square::SquareMatrix;
