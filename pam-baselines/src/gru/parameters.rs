//! Sizes and numbers of the network.

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Numbers of an input: state and force.
pub const INPUTS: usize = 5;
/// Numbers of an output: the next state.
pub const OUTPUTS: usize = 4;

/// Layers and width of the network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shape {
    /// Width of each recurrent layer and of the head; a multiple of 16.
    pub hidden: usize,
    /// Number of recurrent layers.
    pub layers: usize,
}

/// One array of the network.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// Its name in PyTorch.
    pub name: String,
    /// Its shape.
    pub shape: Vec<usize>,
    /// Where it lies among all numbers.
    pub range: std::ops::Range<usize>,
}

impl Shape {
    /// Inputs of a recurrent layer.
    #[must_use]
    pub fn inputs(&self, layer: usize) -> usize {
        if layer == 0 { INPUTS } else { self.hidden }
    }

    /// The arrays in PyTorch's names, shapes (row by row) and order. Gates stand in the order reset,
    /// update, new.
    #[must_use]
    pub fn parts(&self) -> Vec<Part> {
        let h = self.hidden;
        let mut named: Vec<(String, Vec<usize>)> = Vec::new();
        for l in 0..self.layers {
            named.push((format!("gru.weight_ih_l{l}"), vec![3 * h, self.inputs(l)]));
            named.push((format!("gru.weight_hh_l{l}"), vec![3 * h, h]));
            named.push((format!("gru.bias_ih_l{l}"), vec![3 * h]));
            named.push((format!("gru.bias_hh_l{l}"), vec![3 * h]));
        }
        named.push(("head.0.weight".into(), vec![h, h]));
        named.push(("head.0.bias".into(), vec![h]));
        named.push(("head.2.weight".into(), vec![OUTPUTS, h]));
        named.push(("head.2.bias".into(), vec![OUTPUTS]));
        let mut at = 0;
        named
            .into_iter()
            .map(|(name, shape)| {
                let len: usize = shape.iter().product();
                at += len;
                Part { name, shape, range: at - len..at }
            })
            .collect()
    }

    /// Number of numbers.
    #[must_use]
    pub fn len(&self) -> usize {
        self.parts().last().map_or(0, |p| p.range.end)
    }

    /// True if there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Random numbers as PyTorch draws them: uniform within `±1/√hidden`, which is the number of inputs of
    /// the head's layers too.
    #[must_use]
    pub fn random(&self, seed: u64) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let bound = 1.0 / (self.hidden as f64).sqrt();
        (0..self.len()).map(|_| random.random_range(-bound..bound)).collect()
    }
}
