//! The pre-activations `α + β p + γ r` of all units in one activation pattern, and the force.
//!
//! Those of the first layer are the same in all patterns, and the signs of the last layer change none. So a
//! table holds `α | β | γ` of the layers after the first, unit by unit with padding, and patterns that
//! differ in the last layer alone share it.

use super::pattern::slopes_into;
use super::relu_network::ReluNetwork;
use crate::simd::LANES;
use pam_core::simd::arch;
use pulp::{Simd, WithSimd};

/// The pre-activations of all units in one pattern.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PreActivations<'a> {
    /// `α`, `β` and `γ` of the first layer.
    pub(crate) first: &'a [Vec<f64>; 3],
    /// `α | β | γ` of the other layers.
    pub(crate) deeper: &'a [f64],
}

impl<'a> PreActivations<'a> {
    /// Number of units, padding included.
    #[inline(always)]
    pub(crate) fn units(&self) -> usize {
        self.first[0].len() + self.deeper.len() / 3
    }

    /// `α`, `β` and `γ` of the first layer, then of the other layers.
    #[inline(always)]
    pub(crate) fn parts(&self) -> [[&'a [f64]; 3]; 2] {
        let [alpha, beta, gamma] = self.first;
        let len = self.deeper.len() / 3;
        let (one, rest) = self.deeper.split_at(len);
        let (two, three) = rest.split_at(len);
        [[alpha, beta, gamma], [one, two, three]]
    }

    /// `α`, `β` and `γ` of `len` units of one layer, from the unit `start` on.
    #[inline(always)]
    pub(crate) fn units_from(&self, start: usize, len: usize) -> [&'a [f64]; 3] {
        let first = self.first[0].len();
        let [here, deeper] = self.parts();
        let (part, start) = if start < first { (here, start) } else { (deeper, start - first) };
        let [alpha, beta, gamma] = part;
        [&alpha[start..][..len], &beta[start..][..len], &gamma[start..][..len]]
    }

    /// `α`, `β` and `γ` of a unit.
    #[inline(always)]
    pub(crate) fn unit(&self, unit: usize) -> [f64; 3] {
        let [alpha, beta, gamma] = self.units_from(unit, 1);
        [alpha[0], beta[0], gamma[0]]
    }

    /// The affine force `[a, b, c]` of a pattern with these pre-activations.
    pub(crate) fn force(self, network: &ReluNetwork, pattern: &[u64]) -> [f64; 3] {
        arch().dispatch(Output { network, table: self, pattern })
    }
}

/// Computes the pre-activations of layer `l`, not the first, from those of the layer before it.
pub(crate) struct ComputeLayer<'a> {
    pub(crate) network: &'a ReluNetwork,
    pub(crate) l: usize,
    pub(crate) first: &'a [Vec<f64>; 3],
    /// `dσ/dz` of all units.
    pub(crate) slopes: &'a [f64],
    pub(crate) deeper: &'a mut [f64],
}

impl ComputeLayer<'_> {
    pub(crate) fn run(self) {
        arch().dispatch(self);
    }
}

impl WithSimd for ComputeLayer<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _simd: S) {
        let blocks = self.network.hidden[self.l].stride / LANES;
        let paired = blocks - blocks % 2;
        for block in (0..paired).step_by(2) {
            self.sums::<2>(block);
        }
        if paired < blocks {
            self.sums::<1>(paired);
        }
    }
}

impl ComputeLayer<'_> {
    /// Computes `B` blocks of [`LANES`] units from a block on. The sums stay in registers over all inputs.
    #[inline(always)]
    fn sums<const B: usize>(&mut self, block: usize) {
        let Self { network, l, first, slopes, ref mut deeper } = *self;
        let (len, layer) = (deeper.len() / 3, &network.hidden[l]);
        let from = network.start(l - 1);
        let here = network.start(l) - first[0].len() + block * LANES;
        let before = |k: usize| match l {
            1 => &first[k][..],
            _ => &deeper[k * len..][from - first[0].len()..],
        };
        let before = [before(0), before(1), before(2)];
        let mut sums = [[[0.0; LANES]; B]; 3];
        let bias = layer.bias.as_chunks::<LANES>().0;
        sums[0].copy_from_slice(&bias[block..][..B]);
        for (i, column) in layer.columns.chunks_exact(layer.stride).enumerate() {
            let column = &column.as_chunks::<LANES>().0[block..][..B];
            let slope = slopes[from + i];
            for k in 0..3 {
                let value = before[k][i] * slope;
                for b in 0..B {
                    for lane in 0..LANES {
                        sums[k][b][lane] = value.mul_add(column[b][lane], sums[k][b][lane]);
                    }
                }
            }
        }
        for (k, sums) in sums.iter().enumerate() {
            deeper[k * len + here..][..B * LANES].copy_from_slice(sums.as_flattened());
        }
    }
}

struct Output<'a> {
    network: &'a ReluNetwork,
    table: PreActivations<'a>,
    pattern: &'a [u64],
}

impl WithSimd for Output<'_> {
    type Output = [f64; 3];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [f64; 3] {
        let Self { network, table, pattern } = self;
        let start = network.last_start();
        let weights = network.output.as_chunks::<LANES>().0;
        let [alpha, beta, gamma] = table.units_from(start, network.output.len());
        let (alpha, beta) = (alpha.as_chunks::<LANES>().0, beta.as_chunks::<LANES>().0);
        let gamma = gamma.as_chunks::<LANES>().0;
        let mut sums = [simd.splat_f64s(0.0); 3];
        for (chunk, weights) in weights.iter().enumerate() {
            let first = start + chunk * LANES;
            let signs = pattern[first / 64] >> (first % 64);
            let mut slopes = [0.0; LANES];
            slopes_into(&[signs], network.slope, &mut slopes);
            let weights = S::as_simd_f64s(weights).0.iter().zip(S::as_simd_f64s(&slopes).0);
            let parts = [&alpha[chunk], &beta[chunk], &gamma[chunk]];
            for (i, (&weight, &slope)) in weights.enumerate() {
                let weight = simd.mul_f64s(weight, slope);
                for (sum, part) in sums.iter_mut().zip(parts) {
                    *sum = simd.mul_add_f64s(weight, S::as_simd_f64s(part).0[i], *sum);
                }
            }
        }
        let [a, b, c] = sums;
        let (a, b, c) = (simd.reduce_sum_f64s(a), simd.reduce_sum_f64s(b), simd.reduce_sum_f64s(c));
        [network.output_bias + a, b, c]
    }
}
