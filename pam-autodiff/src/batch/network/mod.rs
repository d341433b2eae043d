//! A multilayer perceptron over a batch of points.
//!
//! Points lie one after the other, each padded to whole vectors, so that a layer is one matrix product
//! with the weights on the left. [`NetworkBlock`] holds what the backward pass needs of one block of
//! points; [`NetworkSums`] gathers weight cotangents.
//!
//! The backward pass comes in two halves. [`BatchNetwork::pull_back`] takes cotangents of the output
//! to cotangents of the input and keeps those of the layers; [`BatchNetwork::accumulate`] then weighs
//! each point by a number and sums the weight cotangents. A solver's adjoint needs it so: the output
//! is one force, the weights of the points follow only from a recursion through time, and with the
//! network's slopes known beforehand for a whole block of steps that recursion is a few numbers a
//! stage.

mod layer;
mod pass;
mod sums;

pub use pass::NetworkBlock;
pub use sums::NetworkSums;

use layer::Layer;
use pam_core::simd::Float;
use pam_core::{Activation, ActivationFunction, Mlp};

/// A network whose weights are laid out for batches.
///
/// The first `constants` inputs are the same for all points of one condition (the air masses of one
/// recording) and are folded into the first bias by [`fold`](BatchNetwork::fold); the others vary from
/// point to point.
#[derive(Debug, Clone)]
pub struct BatchNetwork<T, A = Activation> {
    layers: Vec<Layer<T>>,
    /// Columns of the first weight matrix for the constant inputs.
    constant_columns: Vec<Vec<T>>,
    activation: A,
}

impl<T: Float, A: ActivationFunction> BatchNetwork<T, A> {
    /// Lays out the weights of `mlp`.
    ///
    /// # Panics
    /// If no input is left that varies.
    #[must_use]
    pub fn new(mlp: &Mlp<f64, A>, constants: usize) -> Self {
        assert!(constants < mlp.inputs(), "no input is left that varies");
        let skip = |k: usize| if k == 0 { constants } else { 0 };
        let layers: Vec<Layer<T>> =
            mlp.layers().iter().enumerate().map(|(k, dense)| Layer::new(dense, skip(k))).collect();
        let constant_columns = (0..constants).map(|i| Layer::column(&mlp.layers()[0], i)).collect();
        Self { layers, constant_columns, activation: *mlp.activation() }
    }

    /// Number of inputs that vary from point to point.
    #[must_use]
    pub fn inputs(&self) -> usize {
        self.layers[0].inputs
    }

    /// Distance between points in an input batch.
    #[must_use]
    pub fn input_stride(&self) -> usize {
        self.layers[0].input_stride
    }

    /// Number of outputs.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.last().outputs
    }

    /// Distance between points in an output batch.
    #[must_use]
    pub fn output_stride(&self) -> usize {
        self.last().output_stride
    }

    /// Number of weights and biases, those of the constant inputs included.
    #[must_use]
    pub fn parameter_len(&self) -> usize {
        let constants = self.constant_columns.len() * self.layers[0].outputs;
        self.layers.iter().map(|l| (l.inputs + 1) * l.outputs).sum::<usize>() + constants
    }

    /// The first bias with the constant inputs folded in, `b + Σ_i W_i constants_i`, padded.
    #[must_use]
    pub fn fold(&self, constants: &[f64]) -> Vec<T> {
        let mut bias: Vec<f64> = self.layers[0].bias.iter().map(|b| b.widen()).collect();
        for (column, &c) in self.constant_columns.iter().zip(constants) {
            for (b, w) in bias.iter_mut().zip(column) {
                *b += w.widen() * c;
            }
        }
        bias.into_iter().map(T::narrow).collect()
    }

    fn last(&self) -> &Layer<T> {
        &self.layers[self.layers.len() - 1]
    }

    fn hidden(&self) -> usize {
        self.layers.len() - 1
    }
}
