//! The backward pass: costates by the transposed propagators, moments pattern by pattern.

use crate::forcing::Piece;
use crate::fundamental::{Response, StepMoments, spectral_bound, terms};
use crate::motion::Laws;
use crate::network::LANES;
use crate::solve::Segment;
use pam_core::simd::arch;
use pulp::{Simd, WithSimd};

/// Integrals of the velocity's costate times `1`, `x` and `ẋ` over all the time spent in a pattern.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PatternMoments {
    pub(crate) one: f64,
    pub(crate) x: f64,
    pub(crate) v: f64,
}

/// What the backward pass gives besides the moments.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct AdjointSums {
    /// With respect to the state at the start.
    pub(crate) start: [f64; 2],
    /// With respect to m and B.
    pub(crate) mass: f64,
    pub(crate) damping: f64,
}

/// The backward pass of one trajectory.
pub(crate) struct Adjoint<'a, 'n> {
    pub(crate) laws: &'a Laws<'n>,
    pub(crate) pieces: &'a [Piece],
    pub(crate) segments: &'a [Segment],
    /// Cotangents of the observed states, `[observation, (x, ẋ)]`.
    pub(crate) cotangents: &'a [f64],
    /// One for each pattern, zeros on entry.
    pub(crate) moments: &'a mut [PatternMoments],
}

impl Adjoint<'_, '_> {
    pub(crate) fn run(self) -> AdjointSums {
        arch().dispatch(self)
    }
}

impl WithSimd for Adjoint<'_, '_> {
    type Output = AdjointSums;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> AdjointSums {
        let mass = self.laws.motion.mass_kg;
        let inverse_mass = 1.0 / mass;
        let mut costate = [0.0; 2];
        let mut sums = AdjointSums::default();
        let mut piece_index = u32::MAX;
        let mut observation = self.cotangents.len() / 2;
        let (mut force, mut along_v) = (0.0, 0.0);
        let mut end = self.segments.len();
        while end > 0 {
            // The run of segments of one pattern.
            let pattern = self.segments[end - 1].pattern;
            let law = &self.laws.laws[pattern as usize];
            let mut own = PatternMoments::default();
            while end > 0 && self.segments[end - 1].pattern == pattern {
                let s = &self.segments[end - 1];
                end -= 1;
                let piece = &self.pieces[s.piece as usize];
                if s.piece != piece_index {
                    piece_index = s.piece;
                    if piece.observed {
                        observation -= 1;
                        costate[0] += self.cotangents[2 * observation];
                        costate[1] += self.cotangents[2 * observation + 1];
                    }
                }
                let w =
                    [(s.force_mn - law.offset_mn) * inverse_mass, piece.rate_mn_s * inverse_mass];
                let own_step;
                let (e, q) = if s.length_s == 0.0 {
                    (&law.usual, &law.squared)
                } else {
                    let count = if s.length_s <= self.laws.usual_s {
                        law.terms as usize
                    } else {
                        terms(spectral_bound(law.kappa, law.zeta) * s.length_s)
                    };
                    own_step = Response::with_square(law.kappa, law.zeta, s.length_s, count);
                    (&own_step.0, &own_step.1)
                };
                let m = StepMoments::new((e, q), (law.kappa, law.zeta), [s.x, s.v], w, costate);
                costate = e.pull_back(law.kappa, costate);
                own.one += m.one;
                own.x += m.x;
                own.v += m.v;
                force += w[0] * m.one + w[1] * m.time;
            }
            force -= law.kappa * own.x + law.zeta * own.v;
            along_v += own.v;
            let total = &mut self.moments[pattern as usize];
            total.one += own.one;
            total.x += own.x;
            total.v += own.v;
        }
        sums.start = costate;
        // ẍ = (u − f − B ẋ)/m: its derivatives are −ẍ/m and −ẋ/m.
        sums.mass = -force * inverse_mass;
        sums.damping = -along_v * inverse_mass;
        sums
    }
}

/// Sums of one trajectory's gradient with respect to the network, in padded layout.
#[derive(Debug, Default)]
pub(crate) struct NetworkSums {
    /// Columns of each hidden layer with its bias at the end, then the output's weights and bias.
    sums: Vec<f64>,
    slopes: Vec<f64>,
    carried: Vec<f64>,
    next: Vec<f64>,
    gathered: Vec<f64>,
}

/// Adds the gradient of all patterns: per pattern and layer one outer product.
pub(crate) struct PullBack<'a, 'n> {
    pub(crate) laws: &'a Laws<'n>,
    pub(crate) masses_g: [f64; 2],
    pub(crate) moments: &'a [PatternMoments],
    pub(crate) sums: &'a mut NetworkSums,
}

impl PullBack<'_, '_> {
    /// Adds to `shared` (weights in the order of
    /// [`ParametricForce`](pam_core::ParametricForce)) and returns the part of the two masses.
    pub(crate) fn run(mut self, shared: &mut [f64]) -> [f64; 2] {
        let network = &self.laws.motion.network;
        let len: usize = network.hidden.iter().map(|l| (l.inputs + 1) * l.stride).sum();
        self.sums.sums.clear();
        self.sums.sums.resize(len + network.output.len() + 1, 0.0);
        let masses = arch().dispatch(PullBackAll(&mut self));
        let mut sums = &self.sums.sums[..];
        let mut out = shared.iter_mut();
        for layer in &network.hidden {
            let (own, rest) = sums.split_at((layer.inputs + 1) * layer.stride);
            sums = rest;
            for column in own.chunks_exact(layer.stride) {
                for (g, o) in column[..layer.outputs].iter().zip(out.by_ref()) {
                    *o += g;
                }
            }
        }
        let outputs = network.hidden[network.hidden.len() - 1].outputs;
        for (g, o) in sums[..outputs].iter().zip(out.by_ref()) {
            *o += g;
        }
        if let Some(o) = out.next() {
            *o += sums[sums.len() - 1];
        }
        masses
    }
}

struct PullBackAll<'p, 'a, 'n>(&'p mut PullBack<'a, 'n>);

impl WithSimd for PullBackAll<'_, '_, '_> {
    type Output = [f64; 2];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> [f64; 2] {
        let Self(job) = self;
        let network = &job.laws.motion.network;
        let units = network.units();
        let scale = -1.0 / job.laws.motion.mass_kg;
        let mut masses = [0.0; 2];
        let NetworkSums { sums, slopes, carried, next, gathered } = &mut *job.sums;
        for (id, m) in job.moments.iter().enumerate() {
            if m.one == 0.0 && m.x == 0.0 && m.v == 0.0 {
                continue;
            }
            let m = [scale * m.one, scale * m.x, scale * m.v];
            job.laws.atlas.slopes_into(id as u32, slopes);
            let table = job.laws.atlas.table(id as u32);
            let (alpha, rest) = table.split_at(units);
            let (beta, gamma) = rest.split_at(units);
            gathered.clear();
            gathered.extend(
                (0..units)
                    .map(|i| slopes[i] * (alpha[i] * m[0] + beta[i] * m[1] + gamma[i] * m[2])),
            );
            let mut place = sums.len() - network.output.len() - 1;
            let mut start = units - network.output.len();
            for (o, g) in sums[place..].iter_mut().zip(&gathered[start..]) {
                *o += g;
            }
            let last = sums.len() - 1;
            sums[last] += m[0];
            carried.clear();
            carried.extend(network.output.iter().zip(&slopes[start..]).map(|(w, d)| w * d));
            for (l, layer) in network.hidden.iter().enumerate().rev() {
                place -= (layer.inputs + 1) * layer.stride;
                let own = &mut sums[place..][..(layer.inputs + 1) * layer.stride];
                let (columns, bias) = own.split_at_mut(layer.inputs * layer.stride);
                add_scaled(bias, carried, m[0]);
                if l == 0 {
                    let inputs = [job.masses_g[0] * m[0], job.masses_g[1] * m[0], m[1], m[2]];
                    for (column, value) in columns.chunks_exact_mut(layer.stride).zip(inputs) {
                        add_scaled(column, carried, value);
                    }
                    for (sum, column) in
                        masses.iter_mut().zip(layer.columns.chunks_exact(layer.stride))
                    {
                        *sum += m[0] * dot(column, carried);
                    }
                    break;
                }
                let before = network.hidden[l - 1].stride;
                start -= before;
                next.clear();
                next.resize(before, 0.0);
                let inputs = gathered[start..].iter().zip(&slopes[start..]).zip(next.iter_mut());
                for (((g, d), next), (sum, weights)) in inputs.zip(
                    columns
                        .chunks_exact_mut(layer.stride)
                        .zip(layer.columns.chunks_exact(layer.stride)),
                ) {
                    add_scaled(sum, carried, *g);
                    *next = d * dot(weights, carried);
                }
                std::mem::swap(carried, next);
            }
        }
        masses
    }
}

#[inline(always)]
fn add_scaled(sum: &mut [f64], values: &[f64], scale: f64) {
    for (s, v) in sum.iter_mut().zip(values) {
        *s += v * scale;
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
