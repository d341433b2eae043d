//! The table of a neighbouring pattern.
//!
//! If one unit of layer `l` changes its slope by `Δd`, its output changes by `Δd (α + β p + γ r)`, and the
//! pre-activations of layer `k > l` change by the outer product of
//!
//! ```text
//! Δd (α, β, γ)    and    Wₖ Dₖ₋₁ … Wₗ₊₂ Dₗ₊₁ Wₗ₊₁ eᵢ
//! ```
//!
//! with the weights `W`, the slopes `D` and the unit vector `eᵢ`: a matrix of rank one. The vector passes
//! through the layers once.

use super::pattern::{sign, slopes_into};
use super::preactivations::PreActivations;
use super::relu_network::ReluNetwork;
use crate::simd::zero;
use pam_core::simd::arch;
use pulp::{Simd, WithSimd};

/// Buffers of an update.
#[derive(Debug, Default)]
pub(crate) struct Buffers {
    pub(crate) slopes: Vec<f64>,
    change: Vec<f64>,
    next_change: Vec<f64>,
}

/// Turns a table into that of the pattern in which one unit, not of the last layer, has changed its sign.
pub(crate) struct RankOneUpdate<'a> {
    pub(crate) network: &'a ReluNetwork,
    pub(crate) unit: usize,
    /// The pattern after the sign change.
    pub(crate) pattern: &'a [u64],
    pub(crate) first: &'a [Vec<f64>; 3],
    pub(crate) buffers: &'a mut Buffers,
    pub(crate) deeper: &'a mut [f64],
}

impl RankOneUpdate<'_> {
    pub(crate) fn run(self) {
        arch().dispatch(self);
    }
}

impl WithSimd for RankOneUpdate<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { network, unit, pattern, first, buffers, deeper } = self;
        let l = network.layer_of(unit);
        if l + 2 < network.hidden.len() {
            buffers.slopes.resize(network.units(), 0.0);
            slopes_into(pattern, network.slope, &mut buffers.slopes);
        }
        let change = (1.0 - network.slope) * sign(pattern, unit);
        let mut own = PreActivations { first, deeper }.unit(unit);
        for own in &mut own {
            *own *= change;
        }
        let len = deeper.len() / 3;
        for depth in l + 1..network.hidden.len() {
            let layer = &network.hidden[depth];
            let stride = layer.stride;
            let next = network.start(depth) - first[0].len();
            if depth == l + 1 {
                let column = &layer.columns[(unit - network.start(l)) * stride..][..stride];
                for (k, own) in own.iter().enumerate() {
                    let table = &mut deeper[k * len + next..][..stride];
                    for (z, r) in table.iter_mut().zip(column) {
                        *z = r.mul_add(*own, *z);
                    }
                }
                if depth + 1 < network.hidden.len() {
                    buffers.change.clear();
                    buffers.change.extend_from_slice(column);
                }
            } else {
                zero(&mut buffers.next_change, stride);
                let slopes = &buffers.slopes[network.start(depth - 1)..];
                let inputs = buffers.change.iter().zip(slopes);
                for ((r, slope), column) in inputs.zip(layer.columns.chunks_exact(stride)) {
                    let r = r * slope;
                    for (o, w) in buffers.next_change.iter_mut().zip(column) {
                        *o += r * w;
                    }
                }
                std::mem::swap(&mut buffers.change, &mut buffers.next_change);
                for (k, own) in own.iter().enumerate() {
                    let table = &mut deeper[k * len + next..][..stride];
                    for (z, r) in table.iter_mut().zip(&buffers.change) {
                        *z += r * own;
                    }
                }
            }
        }
    }
}
