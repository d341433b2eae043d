//! Affine pieces: the pre-activations `α + β p + γ r` of all units in one pattern.
//!
//! A table holds `α | β | γ`, each for all units layer by layer, padding included. Changing the sign of
//! one unit changes the tables of deeper layers by a matrix of rank one.

use crate::network::{LANES, PiecewiseNetwork};
use pam_core::simd::arch;
use pulp::{Simd, WithSimd};

/// Word and bit of a unit in a pattern's signs.
#[inline(always)]
pub(crate) fn word(unit: usize) -> (usize, u64) {
    (unit / 64, 1 << (unit % 64))
}

/// Memory for changes of a table.
#[derive(Debug, Default)]
pub(crate) struct Buffers {
    pub(crate) slopes: Vec<f64>,
    change: Vec<f64>,
    next_change: Vec<f64>,
}

/// Writes the slope of each unit.
pub(crate) fn write_slopes(bits: &[u64], slope: f64, units: usize, slopes: &mut Vec<f64>) {
    arch().dispatch(Slopes { bits, slope, units, slopes });
}

struct Slopes<'a> {
    bits: &'a [u64],
    slope: f64,
    units: usize,
    slopes: &'a mut Vec<f64>,
}

impl WithSimd for Slopes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        self.slopes.resize(self.units, self.slope);
        slopes_into(self.bits, self.slope, self.slopes);
    }
}

/// Writes the slope of each unit.
#[inline(always)]
pub(crate) fn slopes_into(bits: &[u64], slope: f64, slopes: &mut [f64]) {
    for (block, bits) in slopes.chunks_mut(64).zip(bits) {
        for (i, value) in block.iter_mut().enumerate() {
            *value = if (bits >> i) & 1 == 1 { 1.0 } else { slope };
        }
    }
}

/// Computes the pre-activations of layer `l`, whose units begin at `start`, from those of the layer
/// before it and their `slopes`; those of the first layer are `first`.
pub(crate) fn build_layer(
    network: &PiecewiseNetwork,
    l: usize,
    start: usize,
    first: &[Vec<f64>; 3],
    slopes: &[f64],
    table: &mut [f64],
) {
    arch().dispatch(BuildLayer { network, l, start, first, slopes, table });
}

struct BuildLayer<'a> {
    network: &'a PiecewiseNetwork,
    l: usize,
    start: usize,
    first: &'a [Vec<f64>; 3],
    slopes: &'a [f64],
    table: &'a mut [f64],
}

impl WithSimd for BuildLayer<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { network, l, start, first, slopes, table } = self;
        let units = network.units();
        let layer = &network.hidden[l];
        for (k, first) in first.iter().enumerate() {
            let table = &mut table[k * units..(k + 1) * units];
            let (before, here) = table.split_at_mut(start);
            let here = &mut here[..layer.stride];
            if l == 0 {
                here.copy_from_slice(first);
                continue;
            }
            if k == 0 {
                here.copy_from_slice(&layer.bias);
            } else {
                here.fill(0.0);
            }
            let from = start - network.hidden[l - 1].stride;
            let inputs = before[from..].iter().zip(&slopes[from..]);
            for ((z, slope), column) in inputs.zip(layer.columns.chunks_exact(layer.stride)) {
                let h = z * slope;
                for (o, w) in here.iter_mut().zip(column) {
                    *o += h * w;
                }
            }
        }
    }
}

/// Computes a whole table afresh from the signs of its pattern.
pub(crate) fn build(
    network: &PiecewiseNetwork,
    bits: &[u64],
    first: &[Vec<f64>; 3],
    buffers: &mut Buffers,
    table: &mut [f64],
) {
    write_slopes(bits, network.slope, network.units(), &mut buffers.slopes);
    let mut start = 0;
    for (l, layer) in network.hidden.iter().enumerate() {
        build_layer(network, l, start, first, &buffers.slopes, table);
        start += layer.stride;
    }
}

/// Changes a table to that of the pattern in which `unit` has changed its sign; `bits` are the signs
/// after it.
pub(crate) fn flip(
    network: &PiecewiseNetwork,
    unit: usize,
    bits: &[u64],
    buffers: &mut Buffers,
    table: &mut [f64],
) {
    let (mut start, mut l) = (0, 0);
    while unit >= start + network.hidden[l].stride {
        start += network.hidden[l].stride;
        l += 1;
    }
    if l + 1 == network.hidden.len() {
        return; // Nothing but the force depends on it.
    }
    if l + 2 < network.hidden.len() {
        write_slopes(bits, network.slope, network.units(), &mut buffers.slopes);
    }
    arch().dispatch(RankOne { network, unit, l, start, bits, buffers, table });
}

/// The change of all tables when one unit changes its slope: its change `Δd (α, β, γ)` times a vector
/// that goes through the layers once.
struct RankOne<'a> {
    network: &'a PiecewiseNetwork,
    unit: usize,
    /// The unit's layer, and where that begins.
    l: usize,
    start: usize,
    bits: &'a [u64],
    buffers: &'a mut Buffers,
    table: &'a mut [f64],
}

impl WithSimd for RankOne<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { network, unit, l, start, bits, buffers, table } = self;
        let units = network.units();
        let (w, bit) = word(unit);
        let change = (1.0 - network.slope) * if bits[w] & bit != 0 { 1.0 } else { -1.0 };
        let own: [f64; 3] = std::array::from_fn(|k| change * table[k * units + unit]);
        let mut next = start + network.hidden[l].stride;
        for (depth, layer) in network.hidden.iter().enumerate().skip(l + 1) {
            let stride = layer.stride;
            if depth == l + 1 {
                let column = &layer.columns[(unit - start) * stride..][..stride];
                for (k, own) in own.iter().enumerate() {
                    let table = &mut table[k * units + next..][..stride];
                    for (z, r) in table.iter_mut().zip(column) {
                        *z += r * own;
                    }
                }
                if depth + 1 < network.hidden.len() {
                    buffers.change.clear();
                    buffers.change.extend_from_slice(column);
                }
            } else {
                buffers.next_change.clear();
                buffers.next_change.resize(stride, 0.0);
                let slopes = &buffers.slopes[next - network.hidden[depth - 1].stride..];
                let inputs = buffers.change.iter().zip(slopes);
                for ((r, slope), column) in inputs.zip(layer.columns.chunks_exact(stride)) {
                    let r = r * slope;
                    for (o, w) in buffers.next_change.iter_mut().zip(column) {
                        *o += r * w;
                    }
                }
                std::mem::swap(&mut buffers.change, &mut buffers.next_change);
                for (k, own) in own.iter().enumerate() {
                    let table = &mut table[k * units + next..][..stride];
                    for (z, r) in table.iter_mut().zip(&buffers.change) {
                        *z += r * own;
                    }
                }
            }
            next += stride;
        }
    }
}

/// The affine force `a + b p + c r` of a table.
pub(crate) fn output(network: &PiecewiseNetwork, table: &[f64], bits: &[u64]) -> [f64; 3] {
    arch().dispatch(Output { network, table, bits })
}

struct Output<'a> {
    network: &'a PiecewiseNetwork,
    table: &'a [f64],
    bits: &'a [u64],
}

impl WithSimd for Output<'_> {
    type Output = [f64; 3];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> [f64; 3] {
        let Self { network, table, bits } = self;
        let units = network.units();
        let start = units - network.output.len();
        let weights = network.output.as_chunks::<LANES>().0;
        let part = |k: usize| table[k * units + start..(k + 1) * units].as_chunks::<LANES>().0;
        let (alpha, beta, gamma) = (part(0), part(1), part(2));
        let mut sums = [[0.0; LANES]; 3];
        for (chunk, w) in weights.iter().enumerate() {
            let first = start + chunk * LANES;
            let signs = bits[first / 64] >> (first % 64);
            for i in 0..LANES {
                let w = w[i] * if (signs >> i) & 1 == 1 { 1.0 } else { network.slope };
                sums[0][i] += alpha[chunk][i] * w;
                sums[1][i] += beta[chunk][i] * w;
                sums[2][i] += gamma[chunk][i] * w;
            }
        }
        let sum = |k: usize| sums[k].iter().sum::<f64>();
        [network.output_bias + sum(0), sum(1), sum(2)]
    }
}
