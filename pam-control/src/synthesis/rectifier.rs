//! The stencil of a rectifier network with the distance to its next kink.
//!
//! Inside one activation pattern of its five points, `g` and K̂ are affine in the two masses. With every
//! neuron's value `z` and its slopes along both masses at hand, the next kink on a straight line is the
//! smallest positive `−z / ż`.

use super::problem::{SynthesisSettings, Target};
use super::stencil::{Inertia, Local, OFFSETS, POINTS};
use super::trace::Landscape;
use pam_core::simd::gemm::{Finish, Layout, Product, Start};
use pam_core::simd::{arch, padded};
use pam_core::{ActivationFunction, NetworkForce};
use pulp::{Simd, WithSimd};

/// Columns of a layer: the values at each point, then their slopes along m_f, then along m_e.
const COLUMNS: usize = 3 * POINTS;

/// A rectifier network laid out for its kinks.
#[derive(Debug, Clone)]
pub(super) struct RectifierNetwork {
    slope: f64,
    /// Columns of the first layer for m_f, m_e, x and ẋ, and its bias, padded.
    first: [Vec<f64>; 5],
    /// Hidden layers after the first.
    hidden: Vec<HiddenLayer>,
    last: Vec<f64>,
    last_bias: f64,
}

#[derive(Debug, Clone)]
struct HiddenLayer {
    inputs: usize,
    rows: usize,
    columns: Vec<f64>,
    /// The bias under the values and zeros under the slopes, `[COLUMNS][rows]`.
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

impl RectifierNetwork {
    /// Lays out a network; none if its activation is no rectifier or it has no hidden layer.
    pub(super) fn new(force: &NetworkForce<f64>) -> Option<Self> {
        let mlp = force.mlp();
        let slope = mlp.activation().rectifier_slope()?;
        let (last, layers) = mlp.layers().split_last()?;
        let (first, hidden) = layers.split_first()?;
        let n = first.outputs();
        let column = |i: usize| padded_columns(&first.weight_columns()[i * n..(i + 1) * n], n);
        let hidden = hidden.iter().map(|layer| {
            let rows = padded(layer.outputs());
            let mut start = vec![0.0; COLUMNS * rows];
            for point in start.chunks_exact_mut(rows).take(POINTS) {
                point[..layer.outputs()].copy_from_slice(layer.bias());
            }
            let columns = padded_columns(layer.weight_columns(), layer.outputs());
            HiddenLayer { inputs: layer.inputs(), rows, columns, start }
        });
        Some(Self {
            slope,
            first: [column(0), column(1), column(2), column(3), padded_columns(first.bias(), n)],
            hidden: hidden.collect(),
            last: last.weight_columns().to_vec(),
            last_bias: last.bias()[0],
        })
    }

    fn first_rows(&self) -> usize {
        self.first[4].len()
    }
}

/// The stencil of one target.
pub(super) struct RectifierStencil<'a> {
    network: &'a RectifierNetwork,
    inertial_mn: f64,
    step_mm: f64,
    /// The first layer's values without the masses' part, `[POINTS][rows]`.
    base: Vec<f64>,
    /// Values and slopes of each hidden layer before the rectifier, `[COLUMNS][rows]`.
    before: Vec<Vec<f64>>,
    /// The same of one layer after it.
    after: Vec<f64>,
}

impl<'a> RectifierStencil<'a> {
    pub(super) fn new(network: &'a RectifierNetwork, settings: &SynthesisSettings) -> Self {
        let rows =
            std::iter::once(network.first_rows()).chain(network.hidden.iter().map(|h| h.rows));
        let widest = rows.clone().max().unwrap_or(0);
        Self {
            network,
            inertial_mn: 0.0,
            step_mm: settings.stiffness_step_mm,
            base: vec![0.0; POINTS * network.first_rows()],
            before: rows.map(|rows| vec![0.0; COLUMNS * rows]).collect(),
            after: vec![0.0; COLUMNS * widest],
        }
    }

    /// Turns to a target.
    pub(super) fn aim(&mut self, target: &Target, inertia: Inertia) {
        self.inertial_mn = inertia.force_mn(target);
        let [_, _, by_x, by_v, bias] = &self.network.first;
        for (row, offset) in self.base.chunks_exact_mut(bias.len()).zip(OFFSETS) {
            let x = target.displacement_mm + offset * self.step_mm;
            for (i, z) in row.iter_mut().enumerate() {
                *z = bias[i] + by_x[i] * x + by_v[i] * target.velocity_mm_s;
            }
        }
    }
}

impl Landscape for RectifierStencil<'_> {
    fn at(&mut self, u: [f64; 2]) -> Local {
        let network = self.network;
        let first = FirstLayer {
            base: &self.base,
            by: [&network.first[0], &network.first[1]],
            u,
            slope: network.slope,
            before: &mut self.before[0],
            after: &mut self.after,
        };
        arch().dispatch(first);
        for (k, layer) in network.hidden.iter().enumerate() {
            let width = self.before[k].len() / COLUMNS;
            let target = &mut self.before[k + 1];
            Product {
                rows: layer.rows,
                inner: layer.inputs,
                columns: COLUMNS,
                a: &layer.columns,
                b: &self.after,
                layout: Layout::Columns,
                b_stride: width,
                start: Start::Columns(&layer.start),
                finish: Finish::Store,
                c: target,
            }
            .run();
            let rectify = Rectify { before: target, after: &mut self.after, slope: network.slope };
            arch().dispatch(rectify);
        }
        let rows = self.before[self.before.len() - 1].len() / COLUMNS;
        let mut sums = [0.0; COLUMNS];
        for (sum, column) in sums.iter_mut().zip(self.after.chunks_exact(rows)) {
            *sum = network.last.iter().zip(column).map(|(w, h)| w * h).sum();
        }
        sums[..POINTS].iter_mut().for_each(|f| *f += network.last_bias);
        let slope = |p: usize| [sums[POINTS + p], sums[2 * POINTS + p]];
        Local::of(&sums[..POINTS], slope, self.inertial_mn, self.step_mm)
    }

    fn reach(&mut self, direction: [f64; 2]) -> f64 {
        self.before.iter().fold(f64::INFINITY, |least, before| {
            least.min(arch().dispatch(Reach { before, direction }))
        })
    }

    fn is_piecewise_affine(&self) -> bool {
        true
    }
}

struct FirstLayer<'a> {
    base: &'a [f64],
    by: [&'a [f64]; 2],
    u: [f64; 2],
    slope: f64,
    before: &'a mut [f64],
    after: &'a mut [f64],
}

impl WithSimd for FirstLayer<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let rows = self.by[0].len();
        let block = POINTS * rows;
        let [by_f, by_e] = self.by;
        for p in 0..POINTS {
            let at = p * rows;
            for i in 0..rows {
                let z = self.base[at + i] + by_f[i] * self.u[0] + by_e[i] * self.u[1];
                let gate = if z > 0.0 { 1.0 } else { self.slope };
                for (column, value) in [(0, z), (1, by_f[i]), (2, by_e[i])] {
                    self.before[column * block + at + i] = value;
                    self.after[column * block + at + i] = gate * value;
                }
            }
        }
    }
}

struct Rectify<'a> {
    before: &'a [f64],
    after: &'a mut [f64],
    slope: f64,
}

impl WithSimd for Rectify<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let block = self.before.len() / 3;
        let (z, rest) = self.before.split_at(block);
        let (by_f, by_e) = rest.split_at(block);
        let (h, rest) = self.after[..3 * block].split_at_mut(block);
        let (h_f, h_e) = rest.split_at_mut(block);
        for i in 0..block {
            let gate = if z[i] > 0.0 { 1.0 } else { self.slope };
            h[i] = gate * z[i];
            h_f[i] = gate * by_f[i];
            h_e[i] = gate * by_e[i];
        }
    }
}

/// The distance to the next change of sign along a direction.
struct Reach<'a> {
    before: &'a [f64],
    direction: [f64; 2],
}

impl WithSimd for Reach<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> f64 {
        let block = self.before.len() / 3;
        let (z, rest) = self.before.split_at(block);
        let (by_f, by_e) = rest.split_at(block);
        let [t_f, t_e] = self.direction;
        // Eight minima side by side become vector registers.
        let mut least = [f64::INFINITY; 8];
        for ((z, by_f), by_e) in
            z.chunks_exact(8).zip(by_f.chunks_exact(8)).zip(by_e.chunks_exact(8))
        {
            for lane in 0..8 {
                let rate = by_f[lane] * t_f + by_e[lane] * t_e;
                let distance = if z[lane] * rate < 0.0 { -z[lane] / rate } else { f64::INFINITY };
                least[lane] = if distance < least[lane] { distance } else { least[lane] };
            }
        }
        least.into_iter().fold(f64::INFINITY, f64::min)
    }
}
