//! Small numerical helpers that several crates share: descriptive statistics and the paired t-test ([`statistics`]), inner
//! products ([`dot()`]), Cholesky solves of scaled normal equations ([`cholesky`], [`least_squares()`]), [`eigenvalues()`],
//! Fourier transforms ([`fourier`]), and a stable hash of content ([`hash`]). Eigenvalues, Fourier transforms and hash are behind
//! features of their names, since each brings crates of its own.

pub mod cholesky;
mod dot;
#[cfg(feature = "eigenvalues")]
pub mod eigenvalues;
#[cfg(feature = "fourier")]
pub mod fourier;
#[cfg(feature = "hash")]
pub mod hash;
pub mod least_squares;
pub mod square;
pub mod statistics;

pub use cholesky::ScaledCholesky;
pub use dot::dot;
#[cfg(feature = "eigenvalues")]
pub use eigenvalues::eigenvalues;
#[cfg(feature = "hash")]
pub use hash::ContentHash;
pub use least_squares::least_squares;
pub use square::SquareMatrix;
