//! Small numerical helpers that several crates share: descriptive statistics and the paired t-test
//! ([`statistics`]), Cholesky solves of scaled normal equations ([`cholesky`]), and a stable hash of content
//! ([`hash`]).

pub mod cholesky;
pub mod hash;
pub mod statistics;

pub use cholesky::ScaledCholesky;
pub use hash::ContentHash;
