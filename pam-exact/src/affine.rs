//! Affine pieces: the pre-activations `α + β p + γ r` of all units in one pattern.
//!
//! Those of the first layer are the same in all patterns, and a sign of the last layer changes none: a
//! table holds `α | β | γ` of the layers after the first, each unit by unit, padding included, and
//! patterns may share it. Changing the sign of one unit changes the tables of deeper layers by a matrix
//! of rank one.

use crate::network::{LANES, PiecewiseNetwork};
use pam_core::simd::arch;
use pulp::{Simd, WithSimd};

/// The pre-activations of all units in one pattern.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Table<'a> {
    /// `α`, `β` and `γ` of the first layer.
    pub(crate) first: &'a [Vec<f64>; 3],
    /// `α | β | γ` of the other layers.
    pub(crate) deeper: &'a [f64],
}

impl<'a> Table<'a> {
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
}

/// Word and bit of a unit in a pattern's signs.
#[inline(always)]
pub(crate) fn word(unit: usize) -> (usize, u64) {
    (unit / 64, 1 << (unit % 64))
}

/// The first of two values if a bit is one, else the second; without a jump, since nobody can guess signs.
#[inline(always)]
pub(crate) fn either(bit: u64, one: f64, zero: f64) -> f64 {
    let mask = bit.wrapping_neg();
    f64::from_bits((one.to_bits() & mask) | (zero.to_bits() & !mask))
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
            *value = either((bits >> i) & 1, 1.0, slope);
        }
    }
}

/// Computes the pre-activations of layer `l`, not the first, from those of the layer before it and the
/// slopes of all units.
pub(crate) fn build_layer(
    network: &PiecewiseNetwork,
    l: usize,
    first: &[Vec<f64>; 3],
    slopes: &[f64],
    deeper: &mut [f64],
) {
    arch().dispatch(BuildLayer { network, l, first, slopes, deeper });
}

struct BuildLayer<'a> {
    network: &'a PiecewiseNetwork,
    l: usize,
    first: &'a [Vec<f64>; 3],
    slopes: &'a [f64],
    deeper: &'a mut [f64],
}

impl WithSimd for BuildLayer<'_> {
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

impl BuildLayer<'_> {
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

/// Computes a whole table afresh from the signs of its pattern.
pub(crate) fn build(
    network: &PiecewiseNetwork,
    bits: &[u64],
    first: &[Vec<f64>; 3],
    buffers: &mut Buffers,
    deeper: &mut [f64],
) {
    write_slopes(bits, network.slope, network.units(), &mut buffers.slopes);
    for l in 1..network.hidden.len() {
        build_layer(network, l, first, &buffers.slopes, deeper);
    }
}

/// Changes a table to that of the pattern in which `unit`, not of the last layer, has changed its sign;
/// `bits` are the signs after it.
pub(crate) fn flip(
    network: &PiecewiseNetwork,
    unit: usize,
    bits: &[u64],
    first: &[Vec<f64>; 3],
    buffers: &mut Buffers,
    deeper: &mut [f64],
) {
    let l = network.layer_of(unit);
    if l + 2 < network.hidden.len() {
        write_slopes(bits, network.slope, network.units(), &mut buffers.slopes);
    }
    arch().dispatch(RankOne { network, unit, l, bits, first, buffers, deeper });
}

/// The change of all tables when one unit changes its slope: its change `Δd (α, β, γ)` times a vector
/// that goes through the layers once.
struct RankOne<'a> {
    network: &'a PiecewiseNetwork,
    unit: usize,
    /// The unit's layer.
    l: usize,
    bits: &'a [u64],
    first: &'a [Vec<f64>; 3],
    buffers: &'a mut Buffers,
    deeper: &'a mut [f64],
}

impl WithSimd for RankOne<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { network, unit, l, bits, first, buffers, deeper } = self;
        let (w, bit) = word(unit);
        let change = (1.0 - network.slope) * if bits[w] & bit != 0 { 1.0 } else { -1.0 };
        let mut own = Table { first, deeper }.unit(unit);
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
                buffers.next_change.clear();
                buffers.next_change.resize(stride, 0.0);
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

/// The affine force `a + b p + c r` of a table.
pub(crate) fn output(network: &PiecewiseNetwork, table: Table<'_>, bits: &[u64]) -> [f64; 3] {
    arch().dispatch(Output { network, table, bits })
}

struct Output<'a> {
    network: &'a PiecewiseNetwork,
    table: Table<'a>,
    bits: &'a [u64],
}

impl WithSimd for Output<'_> {
    type Output = [f64; 3];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [f64; 3] {
        let Self { network, table, bits } = self;
        let start = network.start(network.hidden.len() - 1);
        let weights = network.output.as_chunks::<LANES>().0;
        let [alpha, beta, gamma] = table.units_from(start, network.output.len());
        let (alpha, beta) = (alpha.as_chunks::<LANES>().0, beta.as_chunks::<LANES>().0);
        let gamma = gamma.as_chunks::<LANES>().0;
        let mut sums = [simd.splat_f64s(0.0); 3];
        for (chunk, weights) in weights.iter().enumerate() {
            let first = start + chunk * LANES;
            let signs = bits[first / 64] >> (first % 64);
            let mut slopes = [0.0; LANES];
            for (i, slope) in slopes.iter_mut().enumerate() {
                *slope = either((signs >> i) & 1, 1.0, network.slope);
            }
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
