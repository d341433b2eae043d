//! The stencil of a ReLU network as one affine map, kept up to date from kink to kink.
//!
//! Inside one activation pattern of its five points, `g` and K̂ are affine in the masses and in the motion.
//! With the pattern, the values of every layer before its activation are affine in
//! `(m_f, m_e, x, ẋ, 1)`: five numbers per neuron determine them, so a neighbouring sample costs five products per
//! neuron where the network costs a row of weights. Where a neuron changes its side, the layer above changes by
//! one outer product. The next kink on a straight line of masses is the smallest positive `−z / ż`.

use super::landscape::Landscape;
use super::problem::{SynthesisSettings, Target};
use super::stencil::{Inertia, Local, OFFSETS, POINTS};
use pam_core::simd::gemm::{Finish, Layout, Product, Start};
use pam_core::simd::{arch, padded};
use pam_core::{ActivationFunction, NetworkForce};
use pulp::{Simd, WithSimd};

/// Inputs of an affine map: m_f, m_e, x, ẋ and one.
const INPUTS: usize = 5;
/// Changes of side after which everything is computed anew, so that rounding does not add up.
const MOST_CHANGES: usize = 4096;

/// A ReLU network laid out for its kinks.
#[derive(Debug, Clone)]
pub(super) struct ReluLayout {
    slope: f64,
    /// The first layer as an affine map, `[INPUTS][rows]`.
    first: Vec<f64>,
    /// Hidden layers after the first.
    hidden: Vec<HiddenLayer>,
    last: Vec<f64>,
    last_bias: f64,
}

#[derive(Debug, Clone)]
struct HiddenLayer {
    inputs: usize,
    rows: usize,
    /// Weights, `[inputs][rows]`.
    columns: Vec<f64>,
    /// Zeros and, for the constant input, the bias, `[INPUTS][rows]`.
    start: Vec<f64>,
}

fn padded_columns(columns: &[f64], outputs: usize) -> Vec<f64> {
    let mut out = Vec::with_capacity(columns.len() / outputs * padded(outputs));
    for column in columns.chunks_exact(outputs) {
        out.extend_from_slice(column);
        out.resize(out.len() + padded(outputs) - outputs, 0.0);
    }
    out
}

impl ReluLayout {
    /// Lays out a network; none if its activation is no (leaky) ReLU or it has no hidden layer.
    pub(super) fn new(force: &NetworkForce<f64>) -> Option<Self> {
        let mlp = force.mlp();
        let slope = mlp.activation().relu_slope()?;
        let (last, layers) = mlp.layers().split_last()?;
        let (first, hidden) = layers.split_first()?;
        let mut affine = padded_columns(first.weight_columns(), first.outputs());
        affine.extend(padded_columns(first.bias(), first.outputs()));
        let hidden = hidden.iter().map(|layer| {
            let rows = padded(layer.outputs());
            let mut start = vec![0.0; INPUTS * rows];
            start[(INPUTS - 1) * rows..][..layer.outputs()].copy_from_slice(layer.bias());
            let columns = padded_columns(layer.weight_columns(), layer.outputs());
            HiddenLayer { inputs: layer.inputs(), rows, columns, start }
        });
        let hidden: Vec<HiddenLayer> = hidden.collect();
        let widest = hidden.last().map_or(affine.len() / INPUTS, |layer| layer.rows);
        let mut weights = last.weight_columns().to_vec();
        weights.resize(widest, 0.0);
        Some(Self { slope, first: affine, hidden, last: weights, last_bias: last.bias()[0] })
    }

    fn gate(&self, side: f64) -> f64 {
        if side > 0.0 { 1.0 } else { self.slope }
    }
}

/// One hidden layer at one point of the stencil.
#[derive(Debug, Clone)]
struct Layer {
    /// Values before the activation as an affine map of the inputs, `[INPUTS][rows]`.
    affine: Vec<f64>,
    /// These values, `[rows]`.
    values: Vec<f64>,
    /// Sides on which the neurons are, 1 or −1, `[rows]`.
    sides: Vec<f64>,
}

/// One point of the stencil.
#[derive(Debug, Clone)]
struct StencilPoint {
    layers: Vec<Layer>,
    /// The force, mN, as an affine map of the inputs.
    force: [f64; INPUTS],
}

/// The stencil of one target after the other.
pub(super) struct ReluStencil<'a> {
    network: &'a ReluLayout,
    inertia: Inertia,
    step_mm: f64,
    points: Vec<StencilPoint>,
    /// Displacement and velocity of the target, mm and mm/s.
    motion: [f64; 2],
    inertial_mn: f64,
    /// An affine map after the activation.
    after: Vec<f64>,
    changes: usize,
    restart: bool,
}

impl<'a> ReluStencil<'a> {
    pub(super) fn new(
        network: &'a ReluLayout,
        inertia: Inertia,
        settings: &SynthesisSettings,
    ) -> Self {
        let layer = |affine: &[f64]| {
            let rows = affine.len() / INPUTS;
            Layer { affine: affine.to_vec(), values: vec![0.0; rows], sides: vec![1.0; rows] }
        };
        let above = network.hidden.iter().map(|h| layer(&h.start));
        let layers: Vec<Layer> = std::iter::once(layer(&network.first)).chain(above).collect();
        let widest = layers.iter().map(|l| l.affine.len()).max().unwrap_or(0);
        Self {
            network,
            inertia,
            step_mm: settings.stiffness_step_mm,
            points: vec![StencilPoint { layers, force: [0.0; INPUTS] }; POINTS],
            motion: [0.0; 2],
            inertial_mn: 0.0,
            after: vec![0.0; widest],
            changes: 0,
            restart: true,
        }
    }

    /// Computes everything anew at the next pair of masses.
    pub(super) fn refresh(&mut self) {
        (self.restart, self.changes) = (true, 0);
    }

    /// Turns to a target.
    pub(super) fn aim(&mut self, target: &Target) {
        self.motion = [target.displacement_mm, target.velocity_mm_s];
        self.inertial_mn = self.inertia.force_mn(target);
    }

    fn inputs(&self, point: usize, [m_f, m_e]: [f64; 2]) -> [f64; INPUTS] {
        [m_f, m_e, self.motion[0] + OFFSETS[point] * self.step_mm, self.motion[1], 1.0]
    }

    /// Values at a pair of masses by the pieces found last; true only if it lies in them.
    pub(super) fn extended(&self, u: [f64; 2]) -> Local {
        let mut forces_mn = [0.0; POINTS];
        for (p, force_mn) in forces_mn.iter_mut().enumerate() {
            let inputs = self.inputs(p, u);
            *force_mn = self.points[p].force.iter().zip(inputs).map(|(a, q)| a * q).sum();
        }
        let slope = |p: usize| [self.points[p].force[0], self.points[p].force[1]];
        Local::of(&forces_mn, slope, self.inertial_mn, self.step_mm)
    }

    /// Finds the pieces in which a pair of masses lies.
    fn settle(&mut self, u: [f64; 2]) {
        if self.changes > MOST_CHANGES {
            self.refresh();
        }
        for p in 0..POINTS {
            let inputs = self.inputs(p, u);
            let Self { network, points, after, restart, changes, .. } = self;
            let StencilPoint { layers, force } = &mut points[p];
            // True once the affine map of the present layer has changed.
            let mut changed = *restart;
            let mut bends = changed;
            for k in 0..layers.len() {
                let (below, above) = layers.split_at_mut(k + 1);
                let layer = &mut below[k];
                let values = Values { layer, inputs };
                let stays = arch().dispatch(values) >= 0.0;
                bends |= changed || !stays;
                if stays && !changed {
                    continue;
                }
                let upper = above.first_mut().map(|l| (l, &network.hidden[k]));
                let mut upper = upper.map(|(l, weights)| (&mut l.affine, weights));
                let rows = layer.sides.len();
                for i in 0..rows {
                    if layer.values[i] * layer.sides[i] >= 0.0 {
                        continue;
                    }
                    *changes += 1;
                    let before = network.gate(layer.sides[i]);
                    layer.sides[i] = -layer.sides[i];
                    let change = network.gate(layer.sides[i]) - before;
                    if let (false, Some((affine, weights))) = (changed, &mut upper) {
                        let column = &weights.columns[i * weights.rows..][..weights.rows];
                        for (c, row) in affine.chunks_exact_mut(weights.rows).enumerate() {
                            let factor = change * layer.affine[c * rows + i];
                            row.iter_mut().zip(column).for_each(|(a, w)| *a += factor * w);
                        }
                    }
                }
                if let (true, Some((affine, weights))) = (changed, upper) {
                    after_activation(network, layer, after);
                    Product {
                        rows: weights.rows,
                        inner: weights.inputs,
                        columns: INPUTS,
                        a: &weights.columns,
                        b: after,
                        layout: Layout::Columns,
                        b_stride: rows,
                        start: Start::Columns(&weights.start),
                        finish: Finish::Store,
                        c: affine,
                    }
                    .run();
                }
                changed = true;
            }
            if bends {
                let layer = &layers[layers.len() - 1];
                after_activation(network, layer, after);
                for (f, row) in force.iter_mut().zip(after.chunks_exact(layer.sides.len())) {
                    *f = network.last.iter().zip(row).map(|(w, h)| w * h).sum();
                }
                force[INPUTS - 1] += network.last_bias;
            }
        }
        self.restart = false;
    }
}

/// Writes a layer's affine map after the activation.
fn after_activation(network: &ReluLayout, layer: &Layer, after: &mut [f64]) {
    let rows = layer.sides.len();
    for (to, from) in after.chunks_exact_mut(rows).zip(layer.affine.chunks_exact(rows)) {
        for ((to, from), side) in to.iter_mut().zip(from).zip(&layer.sides) {
            *to = network.gate(*side) * from;
        }
    }
}

impl Landscape for ReluStencil<'_> {
    fn at(&mut self, u: [f64; 2]) -> Local {
        self.settle(u);
        self.extended(u)
    }

    fn reach(&mut self, direction: [f64; 2]) -> f64 {
        let layers = self.points.iter().flat_map(|point| &point.layers);
        layers.fold(f64::INFINITY, |least, layer| {
            least.min(arch().dispatch(Reach { layer, direction }))
        })
    }

    fn is_piecewise_affine(&self) -> bool {
        true
    }
}

/// Vector registers are filled by this many numbers side by side.
const SIDE_BY_SIDE: usize = 8;

/// Computes a layer's values; gives the least of value times side, negative where a neuron is no longer on
/// its side.
struct Values<'a> {
    layer: &'a mut Layer,
    inputs: [f64; INPUTS],
}

impl WithSimd for Values<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> f64 {
        let Layer { affine, values, sides } = self.layer;
        let rows = values.len();
        let (f, rest) = affine.split_at(rows);
        let (e, rest) = rest.split_at(rows);
        let (x, rest) = rest.split_at(rows);
        let (v, one) = rest.split_at(rows);
        let [q_f, q_e, q_x, q_v, _] = self.inputs;
        let mut least = [f64::INFINITY; SIDE_BY_SIDE];
        for at in (0..rows).step_by(SIDE_BY_SIDE) {
            let part = at..at + SIDE_BY_SIDE;
            let (f, e, x) = (&f[part.clone()], &e[part.clone()], &x[part.clone()]);
            let (v, one) = (&v[part.clone()], &one[part.clone()]);
            let (values, sides) = (&mut values[part.clone()], &sides[part]);
            for i in 0..SIDE_BY_SIDE {
                let z = (f[i] * q_f + e[i] * q_e) + (x[i] * q_x + v[i] * q_v) + one[i];
                values[i] = z;
                let margin = z * sides[i];
                least[i] = if margin < least[i] { margin } else { least[i] };
            }
        }
        least.into_iter().fold(f64::INFINITY, f64::min)
    }
}

/// The distance to the next change of side along a direction.
struct Reach<'a> {
    layer: &'a Layer,
    direction: [f64; 2],
}

impl WithSimd for Reach<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> f64 {
        let Layer { affine, values, .. } = self.layer;
        let rows = values.len();
        let (f, rest) = affine.split_at(rows);
        let e = &rest[..rows];
        let [t_f, t_e] = self.direction;
        let mut least = [f64::INFINITY; SIDE_BY_SIDE];
        for at in (0..rows).step_by(SIDE_BY_SIDE) {
            let part = at..at + SIDE_BY_SIDE;
            let (f, e, z) = (&f[part.clone()], &e[part.clone()], &values[part]);
            for i in 0..SIDE_BY_SIDE {
                let rate = f[i] * t_f + e[i] * t_e;
                let distance = if z[i] * rate < 0.0 { -z[i] / rate } else { f64::INFINITY };
                least[i] = if distance < least[i] { distance } else { least[i] };
            }
        }
        least.into_iter().fold(f64::INFINITY, f64::min)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthesis::batch::NetworkBatch;
    use crate::synthesis::problem::MassBounds;
    use crate::synthesis::stencil::Evaluator;
    use pam_core::force::Dense;
    use pam_core::{Activation, Mlp};

    fn network(sizes: &[usize]) -> NetworkForce<f64> {
        let value = |k: usize| ((3.0 + k as f64 * 1.313).sin() * 917.13).fract();
        let layer = |k: usize| {
            let (inputs, outputs) = (sizes[k], sizes[k + 1]);
            let weights: Vec<f64> = (0..inputs * outputs).map(|i| value(1000 * k + i)).collect();
            let bias = (0..outputs).map(|i| value(7919 + 1000 * k + i)).collect();
            Dense::from_rows(&weights, bias).unwrap()
        };
        let layers = (0..sizes.len() - 1).map(layer).collect();
        let activation = Activation::from_name("leaky_relu").unwrap();
        NetworkForce::new(Mlp::new(layers, activation).unwrap()).unwrap()
    }

    /// Along a wandering path the maps kept up to date equal the network, for one, two and three hidden
    /// layers, and jumps as well as small steps.
    #[test]
    fn follows_the_network() {
        for sizes in [&[4, 24, 1][..], &[4, 40, 24, 1], &[4, 24, 40, 17, 1]] {
            let force = network(sizes);
            let inertia = Inertia { mass_kg: 250.0, damping_kg_s: 3.0 };
            let bounds = MassBounds::new(0.1, 2.0).unwrap();
            let settings = SynthesisSettings::published(bounds);
            let laid_out = ReluLayout::new(&force).unwrap();
            let mut stencil = ReluStencil::new(&laid_out, inertia, &settings);
            let batch = NetworkBatch::new(&force);
            let mut evaluator = Evaluator::new(&batch, inertia, &settings, 1);
            for k in 0..3000 {
                let t = f64::from(k) * if k % 500 == 0 { 1.0 } else { 0.01 };
                let target = Target {
                    time_s: t,
                    displacement_mm: 2.0 * t.sin(),
                    velocity_mm_s: 3.0 * (1.3 * t).cos(),
                    acceleration_mm_s2: t.cos(),
                    stiffness_n_mm: 1.0,
                    load_mn: 2.0,
                };
                let u = [1.0 + 0.8 * (1.7 * t).sin(), 1.0 + 0.8 * (2.3 * t).cos()];
                stencil.aim(&target);
                let (found, expected) = (stencil.at(u), evaluator.at(&target, u));
                assert!((found.g - expected.g).abs() < 1e-10, "{sizes:?} {found:?} {expected:?}");
                assert!((found.k - expected.k).abs() < 1e-12, "{sizes:?} {found:?} {expected:?}");
                for i in 0..2 {
                    assert!((found.dg[i] - expected.dg[i]).abs() < 1e-10);
                    assert!((found.dk[i] - expected.dk[i]).abs() < 1e-12);
                }
            }
            assert!(stencil.changes > 50, "the path crosses kinks");
        }
    }
}
