//! Small numerical helpers that several crates share: descriptive statistics and the paired t-test
//! ([`statistics`]), Cholesky solves of scaled normal equations ([`cholesky`], [`least_squares()`]), [`eigenvalues()`], and a stable
//! hash of content ([`hash`]).

pub mod cholesky;
pub mod eigenvalues;
pub mod hash;
pub mod least_squares;
pub mod square;
pub mod statistics;

pub use cholesky::ScaledCholesky;
pub use eigenvalues::eigenvalues;
pub use hash::ContentHash;
pub use least_squares::least_squares;
pub use square::SquareMatrix;
