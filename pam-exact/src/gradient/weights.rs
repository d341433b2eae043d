//! The gradient with respect to the network, from the moments of all regions.
//!
//! A region contributes one outer product to each layer: the derivatives of the force by the layer's
//! pre-activations, times the moments of the layer's inputs. Three shortcuts avoid most of these products:
//!
//! - Regions form a tree, in which each differs from its parent by the sign of one unit. The derivative of the
//!   force by a unit of the *last* hidden layer is its output weight, times the slope if it is inactive. So
//!   each unit needs the moments summed over the regions in which it is active, and these follow from sums
//!   over subtrees: one vector per region in place of a matrix.
//! - The derivatives by the layer *before* it change by one row of weights if a unit of the last layer has
//!   flipped, and not at all otherwise.
//! - Only layers further down need one outer product per region.

use super::costate::RegionMoments;
use crate::network::pattern::{is_active, sign, slopes_into};
use crate::network::preactivations::PreActivations;
use crate::network::{Layer, ReluNetwork};
use crate::regions::cache::Origin;
use crate::regions::facets::NONE;
use crate::simd::{LANES, zero};
use crate::trajectory::motion::MotionRegions;
use pam_core::simd::arch;
use pulp::{Simd, WithSimd};

/// Sums over the regions of one trajectory.
#[derive(Debug, Default)]
pub(crate) struct WeightWorkspace {
    /// Of each hidden layer but the last: columns, then the bias. Columns of the first layer are those
    /// of x and ẋ alone.
    layers: Vec<Vec<f64>>,
    /// Of the output's weights.
    output: Vec<f64>,
    /// For each region, summed over its subtree: moments of `1`, x and ẋ, then of the inputs of the last
    /// hidden layer.
    subtrees: Vec<f64>,
    /// For each unit of the last hidden layer, the sum over the regions in which it is active.
    active: Vec<f64>,
    /// For each region, the derivatives of the force by the outputs of the last hidden layer but one.
    by_outputs: Vec<f64>,
    slopes: Vec<f64>,
    carried: Vec<f64>,
    next: Vec<f64>,
    gathered: Vec<f64>,
}

/// The gradient of one trajectory with respect to the network.
pub(crate) struct WeightGradient<'a, 'n> {
    regions: &'a MotionRegions<'n>,
    network: &'a ReluNetwork,
    masses_g: [f64; 2],
    moments: &'a [RegionMoments],
    sums: &'a mut WeightWorkspace,
    /// The first unit of the last hidden layer.
    last: usize,
    /// Padded width of the layer before it; zero if there is none.
    before: usize,
}

impl<'a, 'n> WeightGradient<'a, 'n> {
    pub(crate) fn new(
        regions: &'a MotionRegions<'n>,
        masses_g: [f64; 2],
        moments: &'a [RegionMoments],
        sums: &'a mut WeightWorkspace,
    ) -> Self {
        let network = &regions.motion.network;
        let before = match &network.hidden[..] {
            [.., before, _] => before.stride,
            _ => 0,
        };
        let last = network.last_start();
        Self { regions, network, masses_g, moments, sums, last, before }
    }

    /// Adds to the gradient (weights in the order of [`ParametricForce`](pam_core::ParametricForce)) and
    /// returns the derivatives by the two masses.
    pub(crate) fn add_to(self, gradient: &mut [f64]) -> [f64; 2] {
        arch().dispatch(All { job: self, gradient })
    }
}

struct All<'a, 'n, 'g> {
    job: WeightGradient<'a, 'n>,
    gradient: &'g mut [f64],
}

impl WithSimd for All<'_, '_, '_> {
    type Output = [f64; 2];

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, _simd: S) -> [f64; 2] {
        self.job.prepare();
        for id in 0..self.job.moments.len() {
            self.job.add_region(id);
        }
        self.job.sum_subtrees();
        self.job.write(self.gradient)
    }
}

impl WeightGradient<'_, '_> {
    /// Moments of `1`, x and ẋ, padded, then those of the inputs of the last hidden layer.
    fn width(&self) -> usize {
        LANES + self.before
    }

    fn prepare(&mut self) {
        let (width, count) = (self.width(), self.moments.len());
        let Self { network, sums, before, .. } = self;
        sums.layers.resize_with(network.hidden.len() - 1, Vec::new);
        for (l, (sum, layer)) in sums.layers.iter_mut().zip(&network.hidden).enumerate() {
            let columns = if l == 0 { 2 } else { layer.inputs };
            zero(sum, (columns + 1) * layer.stride);
        }
        zero(&mut sums.output, network.output.len());
        zero(&mut sums.active, network.output.len() * width);
        zero(&mut sums.slopes, network.units());
        sums.subtrees.resize(count * width, 0.0);
        sums.by_outputs.resize(count * *before, 0.0);
    }

    /// Adds the contribution of one region, later than that of its parent.
    #[inline(always)]
    fn add_region(&mut self, id: usize) {
        if self.before > 0 {
            self.write_by_outputs(id);
        }
        let width = self.width();
        let scale = -1.0 / self.regions.motion.mass_kg;
        let Self { regions, network, sums, last, before, .. } = self;
        let (network, last, before) = (*network, *last, *before);
        let (own, incoming) = sums.subtrees[id * width..][..width].split_at_mut(LANES);
        let m = &self.moments[id];
        let m = [scale * m.one, scale * m.x, scale * m.v];
        own.fill(0.0);
        own[..3].copy_from_slice(&m);
        if m == [0.0; 3] {
            incoming.fill(0.0);
            return;
        }
        slopes_into(regions.cache.pattern(id as u32), network.slope, &mut sums.slopes);
        let table = regions.cache.table(id as u32);
        let outputs = Moments { table, slopes: &sums.slopes, m };
        outputs.gather(last, &mut sums.output, true);
        if before == 0 {
            return;
        }
        outputs.gather(last - before, incoming, false);
        let by_outputs = &sums.by_outputs[id * before..][..before];
        let slopes = &sums.slopes[last - before..last];
        if network.hidden.len() == 2 {
            let (columns, bias) = sums.layers[0].split_at_mut(2 * before);
            let (x, v) = columns.split_at_mut(before);
            for i in 0..before {
                let carried = by_outputs[i] * slopes[i];
                bias[i] += carried * m[0];
                x[i] += carried * m[1];
                v[i] += carried * m[2];
            }
            return;
        }
        sums.carried.clear();
        sums.carried.extend(by_outputs.iter().zip(slopes).map(|(e, d)| e * d));
        self.add_deep_layers(table, m);
    }

    /// Writes the derivatives of the force by the outputs of the last hidden layer but one, from the
    /// parent's.
    #[inline(always)]
    fn write_by_outputs(&mut self, id: usize) {
        let Self { regions, network, sums, last, before, .. } = self;
        let (last, before) = (*last, *before);
        let pattern = regions.cache.pattern(id as u32);
        let Origin { parent, unit } = regions.cache.region(id as u32).origin;
        let (known, rest) = sums.by_outputs.split_at_mut(id * before);
        let own = &mut rest[..before];
        if parent == NONE {
            own.fill(0.0);
            let rows = network.last_rows.chunks_exact(before);
            for (k, (row, w)) in rows.zip(&network.output).enumerate() {
                let slope = if is_active(pattern, last + k) { 1.0 } else { network.slope };
                add_scaled(own, row, slope * w);
            }
            return;
        }
        own.copy_from_slice(&known[parent as usize * before..][..before]);
        if unit as usize >= last {
            let k = unit as usize - last;
            let change = sign(pattern, last + k) * (1.0 - network.slope) * network.output[k];
            add_scaled(own, &network.last_rows[k * before..][..before], change);
        }
    }

    /// Adds the outer products of all hidden layers but the last, for more than two. The derivatives by the
    /// pre-activations of the layer before the last are in `carried`.
    #[inline(always)]
    fn add_deep_layers(&mut self, table: PreActivations<'_>, m: [f64; 3]) {
        let Self { network, sums, last, before, .. } = self;
        let mut start = *last - *before;
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
            Moments { table, slopes: &sums.slopes, m }.gather(start, &mut sums.gathered, false);
            zero(&mut sums.next, stride);
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

    /// Sums over subtrees, from the last region to the first, and for each unit of the last layer over the
    /// regions in which it is active.
    #[inline(always)]
    fn sum_subtrees(&mut self) {
        let width = self.width();
        let Self { regions, network, sums, last, .. } = self;
        let last = *last;
        for id in (0..self.moments.len()).rev() {
            let Origin { parent, unit } = regions.cache.region(id as u32).origin;
            let pattern = regions.cache.pattern(id as u32);
            let (earlier, own) = sums.subtrees.split_at_mut(id * width);
            let own = &own[..width];
            if parent == NONE {
                for k in (0..network.output.len()).filter(|&k| is_active(pattern, last + k)) {
                    add_scaled(&mut sums.active[k * width..][..width], own, 1.0);
                }
                continue;
            }
            add_scaled(&mut earlier[parent as usize * width..][..width], own, 1.0);
            if unit as usize >= last {
                let k = unit as usize - last;
                let sign = sign(pattern, last + k);
                add_scaled(&mut sums.active[k * width..][..width], own, sign);
            }
        }
    }

    /// The sum over all regions, in the layout of a subtree.
    #[inline(always)]
    fn total(&self) -> Vec<f64> {
        let width = self.width();
        let mut total = vec![0.0; width];
        for id in 0..self.moments.len() {
            if self.regions.cache.region(id as u32).origin.parent == NONE {
                add_scaled(&mut total, &self.sums.subtrees[id * width..][..width], 1.0);
            }
        }
        total
    }

    /// Adds the sums to the gradient, in the order of the network's parameters.
    #[inline(always)]
    fn write(&self, gradient: &mut [f64]) -> [f64; 2] {
        let (network, sums, width) = (self.network, &*self.sums, self.width());
        let total = self.total();
        // For unit k of the last hidden layer, the outer product with place `i` of a subtree.
        let last_layer = |k: usize, i: usize| {
            let active = sums.active[k * width + i];
            network.output[k] * (network.slope * total[i] + (1.0 - network.slope) * active)
        };
        let mut out = gradient.iter_mut();
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
                // By the weights of x and of ẋ, and by the bias.
                let column = |i: usize, k: usize| {
                    let stride = layer.stride;
                    if is_last {
                        last_layer(k, (i + 1) % 3)
                    } else {
                        sums.layers[0][i * stride + k]
                    }
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
                    outputs.clone().for_each(|k| add(last_layer(k, LANES + i)));
                }
                outputs.for_each(|k| add(last_layer(k, 0)));
            } else {
                for column in sums.layers[l].chunks_exact(layer.stride) {
                    column[..layer.outputs].iter().for_each(|g| add(*g));
                }
            }
        }
        let Layer { outputs, .. } = network.hidden[network.hidden.len() - 1];
        sums.output[..outputs].iter().for_each(|g| add(*g));
        add(total[0]);
        masses
    }
}

/// The moments `[one, x, v]` of a region, to be turned into those of the units' outputs.
#[derive(Clone, Copy)]
struct Moments<'a> {
    table: PreActivations<'a>,
    slopes: &'a [f64],
    m: [f64; 3],
}

impl Moments<'_> {
    /// Writes the moments of the outputs of the units from `start` on, as many as there is room for, or adds
    /// them.
    #[inline(always)]
    fn gather(self, start: usize, out: &mut [f64], add: bool) {
        let Self { table, slopes, m } = self;
        let len = out.len();
        let [alpha, beta, gamma] = table.units_from(start, len);
        let slopes = &slopes[start..][..len];
        for i in 0..len {
            let own = slopes[i] * gamma[i].mul_add(m[2], beta[i].mul_add(m[1], alpha[i] * m[0]));
            out[i] = if add { out[i] + own } else { own };
        }
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
