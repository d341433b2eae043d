//! Factorisations, hashes and statistics against published values.

mod cholesky;
mod hash;
mod statistics;
