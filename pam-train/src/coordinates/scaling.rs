//! Inputs and output of a force network on a common scale.

use pam_core::NetworkForce;
use pam_data::Subject;
use serde::{Deserialize, Serialize};

/// Centres and widths of the inputs `(m_f, m_e, x, ẋ)` and the scale of the force:
///
/// ```text
/// f(z) = force · N((z − centre)/width)
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Scaling {
    /// Centres (g, g, mm, mm/s).
    pub centre: [f64; 4],
    /// Widths (g, g, mm, mm/s).
    pub width: [f64; 4],
    /// Scale of the force, mN.
    pub force_mn: f64,
}

impl Scaling {
    /// Weights as they are.
    #[must_use]
    pub fn none() -> Self {
        Self { centre: [0.0; 4], width: [1.0; 4], force_mn: 1.0 }
    }

    /// Mean and standard deviation of masses and motion over recordings, and the standard deviation of
    /// the force. A spread of zero (one recording has one pair of masses) counts as the mean itself.
    #[must_use]
    pub fn of_data(subjects: &[Subject]) -> Self {
        let mut sums = [[0.0; 2]; 5];
        let mut count = 0.0;
        for s in subjects {
            let r = &s.recording;
            for k in 0..r.len() {
                let values = [
                    s.masses.flexor_g,
                    s.masses.extensor_g,
                    r.displacement_mm[k],
                    r.velocity_mm_s[k],
                    r.force_mn[k],
                ];
                for (sum, v) in sums.iter_mut().zip(values) {
                    sum[0] += v;
                    sum[1] += v * v;
                }
                count += 1.0;
            }
        }
        let moments = sums.map(|[a, b]| {
            let mean = a / f64::max(count, 1.0);
            let spread = (b / f64::max(count, 1.0) - mean * mean).max(0.0).sqrt();
            let spread = if spread > 1e-9 * mean.abs() { spread } else { mean.abs() };
            [mean, if spread > 0.0 { spread } else { 1.0 }]
        });
        Self {
            centre: std::array::from_fn(|i| moments[i][0]),
            width: std::array::from_fn(|i| moments[i][1]),
            force_mn: moments[4][1],
        }
    }

    /// From weights of the network to those of the scaled one, in place.
    pub(super) fn scale_weights(&self, network: &NetworkForce<f64>, at: &mut [f64]) {
        let (n, _) = first(network);
        let (columns, bias) = at[..5 * n].split_at_mut(4 * n);
        for (i, column) in columns.chunks_exact_mut(n).enumerate() {
            for (w, b) in column.iter_mut().zip(bias.iter_mut()) {
                *b += *w * self.centre[i];
                *w *= self.width[i];
            }
        }
        self.scale_last(network, at, 1.0 / self.force_mn);
    }

    /// From weights of the scaled network to those of the network, in place.
    pub(super) fn unscale_weights(&self, network: &NetworkForce<f64>, at: &mut [f64]) {
        let (n, _) = first(network);
        let (columns, bias) = at[..5 * n].split_at_mut(4 * n);
        for (i, column) in columns.chunks_exact_mut(n).enumerate() {
            for (w, b) in column.iter_mut().zip(bias.iter_mut()) {
                *w /= self.width[i];
                *b -= *w * self.centre[i];
            }
        }
        self.scale_last(network, at, self.force_mn);
    }

    /// From the gradient by the network's weights to that by the scaled ones, in place.
    pub(super) fn pull_back(&self, network: &NetworkForce<f64>, gradient: &mut [f64]) {
        let (n, _) = first(network);
        let (columns, bias) = gradient[..5 * n].split_at_mut(4 * n);
        for (i, column) in columns.chunks_exact_mut(n).enumerate() {
            for (w, b) in column.iter_mut().zip(bias.iter()) {
                *w = (*w - b * self.centre[i]) / self.width[i];
            }
        }
        self.scale_last(network, gradient, self.force_mn);
    }

    /// Multiplies weights and bias of the last layer.
    fn scale_last(&self, network: &NetworkForce<f64>, at: &mut [f64], factor: f64) {
        let (_, last) = first(network);
        let start = at.len().min(network.mlp().parameter_count()) - last;
        for w in &mut at[start..start + last] {
            *w *= factor;
        }
    }
}

/// Outputs of the first layer, and numbers of the last.
fn first(network: &NetworkForce<f64>) -> (usize, usize) {
    let layers = network.mlp().layers();
    let last = &layers[layers.len() - 1];
    (layers[0].outputs(), last.inputs() * last.outputs() + last.outputs())
}
