//! Small numerical helpers that several crates share: descriptive statistics and the paired t-test
//! ([`statistics`]), Cholesky solves of scaled normal equations ([`cholesky`], [`least_squares()`]), and a stable
//! hash of content ([`hash`]).

pub mod cholesky;
pub mod hash;
pub mod least_squares;
pub mod statistics;

pub use cholesky::ScaledCholesky;
pub use hash::ContentHash;
pub use least_squares::least_squares;
