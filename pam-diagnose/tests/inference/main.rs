//! The inference by class of problem, on systems whose truth is known: a linear regression, and a vector field with a
//! hidden term. The expected numbers are theory (least squares, binomial rates, Parseval's theorem) written out here.

mod confirmation;
mod coverage;
mod field;
mod laws;
mod linear;
mod noise;
mod null_test;
mod residual;
mod ripples;
mod roles;
mod simulations;
mod spectrum;
mod subsets;
mod verdict;
