//! The restoring force of a leaky ReLU network with two hidden layers.

use pam_core::{AnyForce, ForceModel};

/// Changes of the pattern after which the composed layer is formed anew, so that rounding does not add up.
const FRESH_AFTER: usize = 2000;

/// A network `f(m_f, m_e, x, ẋ)` that is affine between its kinks. While the signs of the first layer keep, the second
/// layer is one affine map of the inputs, which is stored; a sign that changes costs a rank-one update. The value is
/// that of the network up to rounding, at a tenth of its multiplications.
#[derive(Debug, Clone)]
pub(super) struct ReluNetwork {
    slope: f64,
    /// Columns of the first layer: four inputs and the bias.
    first: [Vec<f64>; 5],
    /// Columns of the second layer, one for each unit of the first.
    second: Vec<Vec<f64>>,
    second_bias: Vec<f64>,
    last: Vec<f64>,
    last_bias: f64,
    /// Signs of the first layer, for which `composed` holds.
    positive: Vec<bool>,
    /// Columns of the second layer as a function of the inputs and 1.
    composed: [Vec<f64>; 5],
    changes: usize,
}

impl ReluNetwork {
    /// The network of a model.
    ///
    /// # Panics
    /// If the force is no network with two hidden layers of leaky ReLU units.
    pub(super) fn of(force: &AnyForce<f64>) -> Self {
        let relu = force.relu_layers().expect("a network of leaky ReLU units");
        let [first, second, last] = relu.layers else { panic!("two hidden layers") };
        let hidden = [first, second].map(|l| (l.weight_rows(), l.bias().to_vec()));
        Self::new(relu.slope, hidden, (last.weight_rows(), last.bias()[0]))
    }

    /// A network of weights by rows and biases.
    pub(super) fn new(
        slope: f64,
        hidden: [(Vec<f64>, Vec<f64>); 2],
        (last, last_bias): (Vec<f64>, f64),
    ) -> Self {
        let [(w1, b1), (w2, second_bias)] = hidden;
        let (units, outputs) = (b1.len(), second_bias.len());
        let column = |k: usize| (0..units).map(|j| w1[4 * j + k]).collect::<Vec<f64>>();
        let first = [column(0), column(1), column(2), column(3), b1];
        let second = (0..units).map(|j| (0..outputs).map(|i| w2[units * i + j]).collect());
        let mut network = Self {
            slope,
            second: second.collect(),
            second_bias,
            last,
            last_bias,
            positive: vec![true; units],
            composed: first.clone().map(|_| vec![0.0; outputs]),
            first,
            changes: 0,
        };
        network.compose();
        network
    }

    /// Forms the second layer as a function of the inputs.
    fn compose(&mut self) {
        for (k, column) in self.composed.iter_mut().enumerate() {
            if k == 4 {
                column.copy_from_slice(&self.second_bias);
            } else {
                column.fill(0.0);
            }
        }
        for j in 0..self.positive.len() {
            let share = if self.positive[j] { 1.0 } else { self.slope };
            self.add(j, share);
        }
        self.changes = 0;
    }

    /// Adds a unit of the first layer with a slope to the composed columns.
    fn add(&mut self, unit: usize, share: f64) {
        for (column, first) in self.composed.iter_mut().zip(&self.first) {
            let factor = share * first[unit];
            column.iter_mut().zip(&self.second[unit]).for_each(|(c, w)| *c += factor * w);
        }
    }

    /// The restoring force, mN.
    pub(super) fn force_mn(&mut self, masses_g: [f64; 2], x: f64, v: f64) -> f64 {
        let z = [masses_g[0], masses_g[1], x, v];
        for j in 0..self.positive.len() {
            let [a, b, c, d, bias] = &self.first;
            let u = a[j] * z[0] + b[j] * z[1] + c[j] * z[2] + d[j] * z[3] + bias[j];
            if (u >= 0.0) != self.positive[j] {
                self.positive[j] = u >= 0.0;
                self.changes += 1;
                self.add(j, if u >= 0.0 { 1.0 - self.slope } else { self.slope - 1.0 });
            }
        }
        if self.changes > FRESH_AFTER {
            self.compose();
        }
        let [a, b, c, d, bias] = &self.composed;
        let mut force = self.last_bias;
        for i in 0..self.last.len() {
            let u = a[i] * z[0] + b[i] * z[1] + c[i] * z[2] + d[i] * z[3] + bias[i];
            force += self.last[i] * u.max(self.slope * u);
        }
        force
    }
}
