//! The gradient with respect to the network, from the moments of all patterns.
//!
//! A pattern's part of the gradient of a layer is one outer product: what the layer's units do to the
//! force, times the moments of what comes into it. Patterns form a tree, each but the first next to the
//! one from which it was met, with one unit between them. In the last hidden layer a unit's effect on the
//! force is its output weight, or that times the slope, so that the sum of the outer products over all
//! patterns needs, for each unit, the sum over the patterns in which it is positive: sums over subtrees,
//! one vector a pattern in place of a matrix. What the layer before it does to the force changes by one
//! row of weights when a unit of the last layer flips, and by nothing otherwise. Layers further down, if
//! there are any, have their outer product taken pattern by pattern.

use crate::adjoint::PatternMoments;
use crate::affine::{Table, slopes_into, word};
use crate::atlas::NONE;
use crate::motion::Laws;
use crate::network::{LANES, Layer};
use pam_core::simd::arch;
use pulp::{Simd, WithSimd};

/// Sums of one trajectory's gradient with respect to the network.
#[derive(Debug, Default)]
pub(crate) struct NetworkSums {
    /// Of each hidden layer but the last: columns, then the bias. Columns of the first layer are those
    /// of x and ẋ alone.
    layers: Vec<Vec<f64>>,
    /// Of the output's weights.
    output: Vec<f64>,
    /// For each pattern, summed over its subtree: moments of `1`, x and ẋ, then of what comes into the
    /// last hidden layer.
    subtrees: Vec<f64>,
    /// For each unit of the last hidden layer, the sum over the patterns in which it is positive.
    positive: Vec<f64>,
    /// For each pattern, the derivatives of the force by the outputs of the last hidden layer but one.
    effects: Vec<f64>,
    slopes: Vec<f64>,
    carried: Vec<f64>,
    next: Vec<f64>,
    gathered: Vec<f64>,
}

/// Adds the gradient of all patterns.
pub(crate) struct PullBack<'a, 'n> {
    pub(crate) laws: &'a Laws<'n>,
    pub(crate) masses_g: [f64; 2],
    pub(crate) moments: &'a [PatternMoments],
    pub(crate) sums: &'a mut NetworkSums,
}

impl PullBack<'_, '_> {
    /// Adds to `shared` (weights in the order of
    /// [`ParametricForce`](pam_core::ParametricForce)) and returns the part of the two masses.
    pub(crate) fn run(self, shared: &mut [f64]) -> [f64; 2] {
        arch().dispatch(All { job: self, shared })
    }
}

struct All<'a, 'n, 's> {
    job: PullBack<'a, 'n>,
    shared: &'s mut [f64],
}

impl WithSimd for All<'_, '_, '_> {
    type Output = [f64; 2];

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _simd: S) -> [f64; 2] {
        self.job.prepare();
        self.job.each_pattern();
        self.job.join_subtrees();
        self.job.write(self.shared)
    }
}

impl PullBack<'_, '_> {
    fn layers(&self) -> &[Layer] {
        &self.laws.motion.network.hidden
    }

    /// Padded width of the last hidden layer but one; zero if there is none.
    fn width_before(&self) -> usize {
        let layers = self.layers();
        if layers.len() > 1 { layers[layers.len() - 2].stride } else { 0 }
    }

    fn prepare(&mut self) {
        let network = &self.laws.motion.network;
        let count = self.moments.len();
        let (before, last) = (self.width_before(), network.output.len());
        let zero = |buffer: &mut Vec<f64>, len: usize| {
            buffer.clear();
            buffer.resize(len, 0.0);
        };
        let sums = &mut *self.sums;
        sums.layers.resize_with(network.hidden.len() - 1, Vec::new);
        for (l, (sum, layer)) in sums.layers.iter_mut().zip(&network.hidden).enumerate() {
            let columns = if l == 0 { 2 } else { layer.inputs };
            zero(sum, (columns + 1) * layer.stride);
        }
        zero(&mut sums.output, last);
        zero(&mut sums.positive, last * (LANES + before));
        zero(&mut sums.slopes, network.units());
        sums.subtrees.resize(count * (LANES + before), 0.0);
        sums.effects.resize(count * before, 0.0);
    }

    /// What each pattern adds by itself, from the first on.
    #[inline(always)]
    fn each_pattern(&mut self) {
        let network = &self.laws.motion.network;
        let units = network.units();
        let last = units - network.output.len();
        let before = self.width_before();
        let scale = -1.0 / self.laws.motion.mass_kg;
        let sums = &mut *self.sums;
        for (id, m) in self.moments.iter().enumerate() {
            let pattern = self.laws.atlas.pattern(id as u32);
            let bits = self.laws.atlas.bits(id as u32);
            // The derivatives of the force, from the parent's.
            if before > 0 {
                let (known, rest) = sums.effects.split_at_mut(id * before);
                let own = &mut rest[..before];
                if pattern.parent == NONE {
                    own.fill(0.0);
                    for (k, (row, w)) in
                        network.last_rows.chunks_exact(before).zip(&network.output).enumerate()
                    {
                        let (at, bit) = word(last + k);
                        let slope = if bits[at] & bit != 0 { 1.0 } else { network.slope };
                        add_scaled(own, row, slope * w);
                    }
                } else {
                    own.copy_from_slice(&known[pattern.parent as usize * before..][..before]);
                    if pattern.flipped as usize >= last {
                        let k = pattern.flipped as usize - last;
                        let (at, bit) = word(last + k);
                        let sign = if bits[at] & bit != 0 { 1.0 } else { -1.0 };
                        let change = sign * (1.0 - network.slope) * network.output[k];
                        add_scaled(own, &network.last_rows[k * before..][..before], change);
                    }
                }
            }
            let subtree = &mut sums.subtrees[id * (LANES + before)..][..LANES + before];
            let (own, incoming) = subtree.split_at_mut(LANES);
            let m = [scale * m.one, scale * m.x, scale * m.v];
            own.fill(0.0);
            own[..3].copy_from_slice(&m);
            if m == [0.0; 3] {
                incoming.fill(0.0);
                continue;
            }
            slopes_into(bits, network.slope, &mut sums.slopes);
            let table = self.laws.atlas.table(id as u32);
            gather(table, &sums.slopes, last, m, &mut sums.output, true);
            if before == 0 {
                continue;
            }
            let effects = &sums.effects[id * before..][..before];
            gather(table, &sums.slopes, last - before, m, incoming, false);
            let slopes = &sums.slopes[last - before..last];
            if network.hidden.len() == 2 {
                let (columns, bias) = sums.layers[0].split_at_mut(2 * before);
                let (x, v) = columns.split_at_mut(before);
                for i in 0..before {
                    let carried = effects[i] * slopes[i];
                    bias[i] += carried * m[0];
                    x[i] += carried * m[1];
                    v[i] += carried * m[2];
                }
                continue;
            }
            sums.carried.clear();
            sums.carried.extend(effects.iter().zip(slopes).map(|(e, d)| e * d));
            let mut start = last - before;
            for l in (0..network.hidden.len() - 1).rev() {
                let layer = &network.hidden[l];
                let own = &mut sums.layers[l];
                let columns = own.len() - layer.stride;
                let (columns, bias) = own.split_at_mut(columns);
                add_scaled(bias, &sums.carried, m[0]);
                if l == 0 {
                    let (x, v) = columns.split_at_mut(layer.stride);
                    add_scaled(x, &sums.carried, m[1]);
                    add_scaled(v, &sums.carried, m[2]);
                    break;
                }
                let stride = network.hidden[l - 1].stride;
                start -= stride;
                sums.gathered.resize(stride, 0.0);
                gather(table, &sums.slopes, start, m, &mut sums.gathered, false);
                sums.next.clear();
                sums.next.resize(stride, 0.0);
                let slopes = &sums.slopes[start..];
                let inputs = sums.gathered.iter().zip(slopes).zip(sums.next.iter_mut());
                let columns = columns.chunks_exact_mut(layer.stride);
                let weights = layer.columns.chunks_exact(layer.stride);
                for (((g, d), next), (sum, weights)) in inputs.zip(columns.zip(weights)) {
                    add_scaled(sum, &sums.carried, *g);
                    *next = d * dot(weights, &sums.carried);
                }
                std::mem::swap(&mut sums.carried, &mut sums.next);
            }
        }
    }

    /// Adds up the subtrees, from the last pattern to the first, and for each unit of the last layer the
    /// patterns in which it is positive.
    #[inline(always)]
    fn join_subtrees(&mut self) {
        let network = &self.laws.motion.network;
        let width = LANES + self.width_before();
        let last = network.units() - network.output.len();
        let sums = &mut *self.sums;
        for id in (0..self.moments.len()).rev() {
            let pattern = self.laws.atlas.pattern(id as u32);
            let bits = self.laws.atlas.bits(id as u32);
            let (earlier, own) = sums.subtrees.split_at_mut(id * width);
            let own = &own[..width];
            let positive = |k: usize| {
                let (at, bit) = word(last + k);
                bits[at] & bit != 0
            };
            if pattern.parent == NONE {
                for k in (0..network.output.len()).filter(|&k| positive(k)) {
                    add_scaled(&mut sums.positive[k * width..][..width], own, 1.0);
                }
                continue;
            }
            add_scaled(&mut earlier[pattern.parent as usize * width..][..width], own, 1.0);
            if pattern.flipped as usize >= last {
                let k = pattern.flipped as usize - last;
                let sign = if positive(k) { 1.0 } else { -1.0 };
                add_scaled(&mut sums.positive[k * width..][..width], own, sign);
            }
        }
    }

    /// Adds the sums to the gradient, in the order of the network's parameters.
    #[inline(always)]
    fn write(&mut self, shared: &mut [f64]) -> [f64; 2] {
        let network = &self.laws.motion.network;
        let width = LANES + self.width_before();
        let mut total = vec![0.0; width];
        for id in 0..self.moments.len() {
            if self.laws.atlas.pattern(id as u32).parent == NONE {
                add_scaled(&mut total, &self.sums.subtrees[id * width..][..width], 1.0);
            }
        }
        let sums = &*self.sums;
        // What unit k of the last layer gets from the place `i` of the incoming sums.
        let of = |k: usize, i: usize| {
            let positive = sums.positive[k * width + i];
            network.output[k] * (network.slope * total[i] + (1.0 - network.slope) * positive)
        };
        let mut out = shared.iter_mut();
        let mut add = |value: f64| {
            if let Some(o) = out.next() {
                *o += value;
            }
        };
        let mut masses = [0.0; 2];
        for (l, layer) in network.hidden.iter().enumerate() {
            let outputs = 0..layer.outputs;
            let is_last = l + 1 == network.hidden.len();
            if l == 0 {
                // By x, by ẋ, by the bias.
                let column = |i: usize, k: usize| {
                    let stride = layer.stride;
                    if is_last { of(k, (i + 1) % 3) } else { sums.layers[0][i * stride + k] }
                };
                for (mass, value) in self.masses_g.iter().enumerate() {
                    for k in outputs.clone() {
                        add(value * column(2, k));
                        masses[mass] += layer.columns[mass * layer.stride + k] * column(2, k);
                    }
                }
                (0..3).for_each(|i| outputs.clone().for_each(|k| add(column(i, k))));
            } else if is_last {
                for i in 0..layer.inputs {
                    outputs.clone().for_each(|k| add(of(k, LANES + i)));
                }
                outputs.for_each(|k| add(of(k, 0)));
            } else {
                for column in sums.layers[l].chunks_exact(layer.stride) {
                    column[..layer.outputs].iter().for_each(|g| add(*g));
                }
            }
        }
        let outputs = network.hidden[network.hidden.len() - 1].outputs;
        sums.output[..outputs].iter().for_each(|g| add(*g));
        add(total[0]);
        masses
    }
}

/// The moments of the outputs of the units from `start` on, as many as there is room for.
#[inline(always)]
fn gather(table: Table<'_>, slopes: &[f64], start: usize, m: [f64; 3], out: &mut [f64], add: bool) {
    let len = out.len();
    let [alpha, beta, gamma] = table.units_from(start, len);
    let slopes = &slopes[start..][..len];
    for i in 0..len {
        let own = slopes[i] * gamma[i].mul_add(m[2], beta[i].mul_add(m[1], alpha[i] * m[0]));
        out[i] = if add { out[i] + own } else { own };
    }
}

#[inline(always)]
fn add_scaled(sum: &mut [f64], values: &[f64], scale: f64) {
    for (s, v) in sum.iter_mut().zip(values) {
        *s = v.mul_add(scale, *s);
    }
}

/// A dot product in [`LANES`] partial sums; both lengths are whole vectors.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    for (a, b) in a.as_chunks::<LANES>().0.iter().zip(b.as_chunks::<LANES>().0) {
        for i in 0..LANES {
            sums[i] += a[i] * b[i];
        }
    }
    sums.iter().sum()
}
