//! Hand-written derivatives of many points at once.
//!
//! - [`network`]: values, cotangents and tangents of a multilayer perceptron over a batch, as matrix
//!   products, in `f32` or `f64`, for every activation;
//! - [`field`]: the trait [`BatchField`] of batched vector fields;
//! - [`sealed_motion`]: the joint with sealed chambers as a batched field of two states;
//! - [`pointwise`]: any [`DifferentiableField`](crate::DifferentiableField) as a batched field.
//!
//! The tests compare the batched models with the generic-scalar models of `pam-core`.

pub mod field;
pub mod network;
pub mod pointwise;
pub mod sealed_motion;

pub use field::{BatchField, ParameterSums, Points};
pub use network::{BatchNetwork, NetworkBlock, NetworkSums};
pub use pointwise::Pointwise;
pub use sealed_motion::SealedMotion;
