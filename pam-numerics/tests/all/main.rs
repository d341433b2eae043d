//! Factorisations, hashes and statistics against published values.

mod cholesky;
mod fourier;
mod hash;
mod statistics;
