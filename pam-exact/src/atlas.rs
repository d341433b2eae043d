//! The patterns of a network on a plane, found as they are needed and kept.

use crate::cell::{Cell, Clip, HalfPlane, Window};
use crate::network::{LANES, PiecewiseNetwork, Plane};
use pam_core::simd::arch;
use pulp::{Simd, WithSimd};
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// No pattern.
pub(crate) const NONE: u32 = u32::MAX;
/// A pattern this many flips away from one that was computed afresh is computed afresh, so that
/// rounding does not build up.
const LONGEST_CHAIN: u16 = 32;
/// Half-planes that miss the cell by less than this part of its size count as its sides.
const SIDE_TOLERANCE: f64 = 1e-9;

/// Up to [`LANES`] sides of a cell. Unused places have an infinite margin.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Sides {
    pub(crate) alpha: [f64; LANES],
    pub(crate) beta: [f64; LANES],
    pub(crate) gamma: [f64; LANES],
    /// The unit that changes sign across the side.
    pub(crate) unit: [u32; LANES],
    /// The pattern behind the side, if it is known.
    pub(crate) neighbour: [u32; LANES],
}

impl Sides {
    const EMPTY: Self = Self {
        alpha: [f64::INFINITY; LANES],
        beta: [0.0; LANES],
        gamma: [0.0; LANES],
        unit: [NONE; LANES],
        neighbour: [NONE; LANES],
    };

    #[inline(always)]
    pub(crate) fn half_plane(&self, lane: usize) -> HalfPlane {
        HalfPlane { alpha: self.alpha[lane], beta: self.beta[lane], gamma: self.gamma[lane] }
    }
}

/// One activation pattern.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pattern {
    /// The force in the pattern, `a + b p + c r`.
    pub(crate) force: [f64; 3],
    /// First block of its sides.
    pub(crate) sides: u32,
    pub(crate) side_blocks: u32,
    hash: u64,
    /// Another pattern with the same hash.
    same_hash: u32,
    chain: u16,
}

/// Hashes are used as they are.
#[derive(Default)]
struct Identity(u64);

impl Hasher for Identity {
    fn finish(&self) -> u64 {
        self.0
    }
    fn write(&mut self, _: &[u8]) {
        unreachable!("only u64 keys are hashed")
    }
    fn write_u64(&mut self, value: u64) {
        self.0 = value;
    }
}

type Index = HashMap<u64, u32, BuildHasherDefault<Identity>>;

/// The patterns of a network on a plane. Memory is kept when the atlas is restarted.
#[derive(Debug)]
pub(crate) struct Atlas<'n> {
    pub(crate) network: &'n PiecewiseNetwork,
    window: Window,
    store: AtlasMemory,
}

/// The memory of an [`Atlas`].
#[derive(Debug, Default)]
pub(crate) struct AtlasMemory {
    pub(crate) patterns: Vec<Pattern>,
    pub(crate) sides: Vec<Sides>,
    /// Pre-activations `α | β | γ` of every unit, pattern by pattern.
    tables: Vec<f64>,
    /// Signs of the units, pattern by pattern.
    bits: Vec<u64>,
    index: Index,
    first: [Vec<f64>; 3],
    scratch: Scratch,
}

#[derive(Debug, Default)]
struct Scratch {
    table: Vec<f64>,
    bits: Vec<u64>,
    slopes: Vec<f64>,
    change: Vec<f64>,
    next_change: Vec<f64>,
    signed: Vec<f64>,
    /// Units of the places in `signed`.
    candidates: Vec<u32>,
    /// Units whose borders were tried, and whether they left nothing.
    processed: Vec<(u32, HalfPlane, bool)>,
    cell: Cell,
}

fn word(unit: usize) -> (usize, u64) {
    (unit / 64, 1 << (unit % 64))
}

/// A well-mixed number for each unit (splitmix64); a pattern's hash is the exclusive or of those of its
/// positive units.
fn unit_hash(unit: usize) -> u64 {
    let mut z = (unit as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl<'n> Atlas<'n> {
    /// An empty atlas in the memory of an earlier one.
    pub(crate) fn new(
        network: &'n PiecewiseNetwork,
        plane: Plane,
        window: Window,
        mut store: AtlasMemory,
    ) -> Self {
        store.patterns.clear();
        store.sides.clear();
        store.tables.clear();
        store.bits.clear();
        store.index.clear();
        store.first = network.first_layer(&plane);
        Self { network, window, store }
    }

    pub(crate) fn into_memory(self) -> AtlasMemory {
        self.store
    }

    #[inline(always)]
    pub(crate) fn len(&self) -> usize {
        self.store.patterns.len()
    }

    #[inline(always)]
    pub(crate) fn pattern(&self, id: u32) -> &Pattern {
        &self.store.patterns[id as usize]
    }

    #[inline(always)]
    pub(crate) fn sides(&self, pattern: &Pattern) -> &[Sides] {
        &self.store.sides[pattern.sides as usize..][..pattern.side_blocks as usize]
    }

    /// The table `α | β | γ` of a pattern.
    pub(crate) fn table(&self, id: u32) -> &[f64] {
        let len = 3 * self.network.units();
        &self.store.tables[id as usize * len..][..len]
    }

    fn words(&self) -> usize {
        self.network.units().div_ceil(64)
    }

    /// Writes the slope of each unit in a pattern.
    pub(crate) fn slopes_into(&self, id: u32, slopes: &mut Vec<f64>) {
        let words = self.words();
        let bits = &self.store.bits[id as usize * words..][..words];
        write_slopes(bits, self.network.slope, self.network.units(), slopes);
    }

    /// The pattern at a point; a unit that is zero there counts as negative.
    pub(crate) fn at(&mut self, point: [f64; 2]) -> u32 {
        let network = self.network;
        let (units, words) = (network.units(), self.words());
        let scratch = &mut self.store.scratch;
        scratch.table.clear();
        scratch.table.resize(3 * units, 0.0);
        scratch.bits.clear();
        scratch.bits.resize(words, 0);
        scratch.slopes.clear();
        scratch.slopes.resize(units, network.slope);
        let mut start = 0;
        let mut hash = 0;
        for (l, layer) in network.hidden.iter().enumerate() {
            build_layer(network, l, start, &self.store.first, scratch);
            let (alpha, rest) = scratch.table.split_at(units);
            let (beta, gamma) = rest.split_at(units);
            for unit in start..start + layer.outputs {
                let z = alpha[unit] + beta[unit] * point[0] + gamma[unit] * point[1];
                if z > 0.0 {
                    let (w, bit) = word(unit);
                    scratch.bits[w] |= bit;
                    scratch.slopes[unit] = 1.0;
                    hash ^= unit_hash(unit);
                }
            }
            start += layer.stride;
        }
        match self.find(hash) {
            Some(id) => id,
            None => self.insert(hash, 0),
        }
    }

    /// The pattern with the scratch's bits.
    fn find(&self, hash: u64) -> Option<u32> {
        let words = self.words();
        let mut id = *self.store.index.get(&hash)?;
        while id != NONE {
            if self.store.bits[id as usize * words..][..words] == self.store.scratch.bits[..] {
                return Some(id);
            }
            id = self.store.patterns[id as usize].same_hash;
        }
        None
    }

    /// The pattern behind a side of `id`.
    #[inline(always)]
    pub(crate) fn behind(&mut self, id: u32, block: usize, lane: usize) -> u32 {
        let first = self.store.patterns[id as usize].sides as usize;
        let known = self.store.sides[first + block].neighbour[lane];
        if known != NONE { known } else { self.look_behind(id, block, lane) }
    }

    #[cold]
    #[inline(never)]
    fn look_behind(&mut self, id: u32, block: usize, lane: usize) -> u32 {
        let words = self.words();
        let old = self.store.patterns[id as usize];
        let place = old.sides as usize + block;
        let unit = self.store.sides[place].unit[lane];
        let (w, bit) = word(unit as usize);
        let scratch = &mut self.store.scratch;
        scratch.bits.clear();
        scratch.bits.extend_from_slice(&self.store.bits[id as usize * words..][..words]);
        scratch.bits[w] ^= bit;
        let hash = old.hash ^ unit_hash(unit as usize);
        let new = match self.find(hash) {
            Some(new) => new,
            None => {
                self.flip(id, unit as usize);
                let chain = if old.chain >= LONGEST_CHAIN { 0 } else { old.chain + 1 };
                self.insert(hash, chain)
            }
        };
        self.store.sides[place].neighbour[lane] = new;
        new
    }

    /// Makes the scratch's table that of pattern `id` with one unit flipped; its bits are set already.
    fn flip(&mut self, id: u32, unit: usize) {
        let network = self.network;
        let units = network.units();
        let chain = self.store.patterns[id as usize].chain;
        let len = 3 * units;
        let store = &mut self.store;
        write_slopes(&store.scratch.bits, network.slope, units, &mut store.scratch.slopes);
        store.scratch.table.clear();
        if chain >= LONGEST_CHAIN {
            store.scratch.table.resize(len, 0.0);
            let mut start = 0;
            for (l, layer) in network.hidden.iter().enumerate() {
                build_layer(network, l, start, &store.first, &mut store.scratch);
                start += layer.stride;
            }
            return;
        }
        store.scratch.table.extend_from_slice(&store.tables[id as usize * len..][..len]);
        arch().dispatch(RankOne { network, unit, scratch: &mut store.scratch });
    }

    /// Keeps the pattern of the scratch.
    fn insert(&mut self, hash: u64, chain: u16) -> u32 {
        let id = self.store.patterns.len() as u32;
        let units = self.network.units();
        let store = &mut self.store;
        let force = output(self.network, &store.scratch);
        let first = store.sides.len() as u32;
        find_sides(units, &self.window, &mut store.scratch, &mut store.sides);
        store.tables.extend_from_slice(&store.scratch.table);
        store.bits.extend_from_slice(&store.scratch.bits);
        let same_hash = store.index.insert(hash, id).unwrap_or(NONE);
        let side_blocks = store.sides.len() as u32 - first;
        store.patterns.push(Pattern { force, sides: first, side_blocks, hash, same_hash, chain });
        id
    }

    /// The polygon of a pattern within the window, counter-clockwise; empty if nothing of it is there.
    pub(crate) fn polygon(&mut self, id: u32) -> Vec<[f64; 2]> {
        let pattern = self.store.patterns[id as usize];
        let cell = &mut self.store.scratch.cell;
        cell.restart(&self.window);
        for sides in &self.store.sides[pattern.sides as usize..][..pattern.side_blocks as usize] {
            for lane in (0..LANES).filter(|&l| sides.unit[l] != NONE) {
                if cell.clip(&sides.half_plane(lane)) == Clip::Nothing {
                    return Vec::new();
                }
            }
        }
        cell.vertices.clone()
    }
}

fn write_slopes(bits: &[u64], slope: f64, units: usize, slopes: &mut Vec<f64>) {
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
        self.slopes.clear();
        self.slopes.resize(self.units, self.slope);
        for (block, bits) in self.slopes.chunks_mut(64).zip(self.bits) {
            for (i, value) in block.iter_mut().enumerate() {
                *value = if (bits >> i) & 1 == 1 { 1.0 } else { self.slope };
            }
        }
    }
}

/// Computes the pre-activations of layer `l` from those of the one before it.
fn build_layer(
    network: &PiecewiseNetwork,
    l: usize,
    start: usize,
    first: &[Vec<f64>; 3],
    scratch: &mut Scratch,
) {
    arch().dispatch(BuildLayer { network, l, start, first, scratch });
}

struct BuildLayer<'a> {
    network: &'a PiecewiseNetwork,
    l: usize,
    start: usize,
    first: &'a [Vec<f64>; 3],
    scratch: &'a mut Scratch,
}

impl WithSimd for BuildLayer<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { network, l, start, first, scratch } = self;
        let units = network.units();
        let layer = &network.hidden[l];
        for (k, first) in first.iter().enumerate() {
            let table = &mut scratch.table[k * units..(k + 1) * units];
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
            let inputs = before[from..].iter().zip(&scratch.slopes[from..]);
            for ((z, slope), column) in inputs.zip(layer.columns.chunks_exact(layer.stride)) {
                let h = z * slope;
                for (o, w) in here.iter_mut().zip(column) {
                    *o += h * w;
                }
            }
        }
    }
}

/// The change of all tables when one unit changes its slope: its change `Δd (α, β, γ)` times a vector
/// that goes through the layers once.
struct RankOne<'a> {
    network: &'a PiecewiseNetwork,
    unit: usize,
    scratch: &'a mut Scratch,
}

impl WithSimd for RankOne<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { network, unit, scratch } = self;
        let units = network.units();
        let (mut start, mut l) = (0, 0);
        while unit >= start + network.hidden[l].stride {
            start += network.hidden[l].stride;
            l += 1;
        }
        let change = (1.0 - network.slope) * if scratch.slopes[unit] == 1.0 { 1.0 } else { -1.0 };
        let own: [f64; 3] = std::array::from_fn(|k| scratch.table[k * units + unit]);
        let mut next = start + network.hidden[l].stride;
        for (depth, layer) in network.hidden.iter().enumerate().skip(l + 1) {
            scratch.next_change.clear();
            if depth == l + 1 {
                let column = &layer.columns[(unit - start) * layer.stride..][..layer.stride];
                scratch.next_change.extend(column.iter().map(|w| w * change));
            } else {
                scratch.next_change.resize(layer.stride, 0.0);
                let slopes = &scratch.slopes[next - network.hidden[depth - 1].stride..];
                let inputs = scratch.change.iter().zip(slopes);
                for ((r, slope), column) in inputs.zip(layer.columns.chunks_exact(layer.stride)) {
                    let r = r * slope;
                    for (o, w) in scratch.next_change.iter_mut().zip(column) {
                        *o += r * w;
                    }
                }
            }
            std::mem::swap(&mut scratch.change, &mut scratch.next_change);
            for (k, own) in own.iter().enumerate() {
                let table = &mut scratch.table[k * units + next..][..layer.stride];
                for (z, r) in table.iter_mut().zip(&scratch.change) {
                    *z += r * own;
                }
            }
            next += layer.stride;
        }
    }
}

/// The affine force of the scratch's table.
fn output(network: &PiecewiseNetwork, scratch: &Scratch) -> [f64; 3] {
    arch().dispatch(Output { network, scratch })
}

struct Output<'a> {
    network: &'a PiecewiseNetwork,
    scratch: &'a Scratch,
}

impl WithSimd for Output<'_> {
    type Output = [f64; 3];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> [f64; 3] {
        let Self { network, scratch } = self;
        let units = network.units();
        let start = units - network.output.len();
        let (slopes, _) = scratch.slopes[start..units].as_chunks::<LANES>();
        let (weights, _) = network.output.as_chunks::<LANES>();
        let sum = |k: usize| -> f64 {
            let (z, _) = scratch.table[k * units + start..(k + 1) * units].as_chunks::<LANES>();
            let mut sums = [0.0; LANES];
            for ((z, slope), w) in z.iter().zip(slopes).zip(weights) {
                for i in 0..LANES {
                    sums[i] += z[i] * slope[i] * w[i];
                }
            }
            sums.iter().sum()
        };
        [network.output_bias + sum(0), sum(1), sum(2)]
    }
}

/// Finds the sides of the cell of the scratch's table: clips a window with the half-plane that comes
/// closest to the middle of what is left, until none can cut the rectangle around it.
fn find_sides(units: usize, window: &Window, scratch: &mut Scratch, out: &mut Vec<Sides>) {
    let Scratch { table, bits, signed, candidates, processed, cell, .. } = scratch;
    arch().dispatch(Orient { units, table, bits, signed });
    candidates.clear();
    candidates.extend(0..units as u32);
    processed.clear();
    cell.restart(window);
    let mut len = units;
    let mut round = 0;
    loop {
        let (middle, half) = cell.bounds();
        round += 1;
        if round % COMPACT_EVERY == 0 {
            len = compact(signed, candidates, units, len, middle, half);
        }
        let found = arch().dispatch(Closest { signed, units, len, middle, half });
        let Some(place) = found else { break };
        let plane = HalfPlane {
            alpha: signed[place],
            beta: signed[units + place],
            gamma: signed[2 * units + place],
        };
        let nothing = cell.clip(&plane) == Clip::Nothing;
        processed.push((candidates[place], plane, nothing));
        signed[place] = f64::INFINITY;
    }
    let (_, half) = cell.bounds();
    let mut sides = Sides::EMPTY;
    let mut lane = 0;
    for &(unit, plane, forced) in &*processed {
        let least = cell.vertices.iter().map(|&v| plane.margin(v)).fold(f64::INFINITY, f64::min);
        let reach = plane.beta.abs() * half[0] + plane.gamma.abs() * half[1];
        if least > SIDE_TOLERANCE * reach && !forced {
            continue;
        }
        if lane == LANES {
            out.push(sides);
            (sides, lane) = (Sides::EMPTY, 0);
        }
        sides.alpha[lane] = plane.alpha;
        sides.beta[lane] = plane.beta;
        sides.gamma[lane] = plane.gamma;
        sides.unit[lane] = unit;
        lane += 1;
    }
    out.push(sides);
}

/// Rounds of clipping after which the half-planes that can cut no more are dropped.
const COMPACT_EVERY: usize = 4;

/// Turns the pre-activations so that all are positive inside the cell.
struct Orient<'a> {
    units: usize,
    table: &'a [f64],
    bits: &'a [u64],
    signed: &'a mut Vec<f64>,
}

impl WithSimd for Orient<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Self { units, table, bits, signed } = self;
        signed.clear();
        signed.extend_from_slice(table);
        for part in signed.chunks_exact_mut(units) {
            for (block, bits) in part.chunks_mut(64).zip(bits) {
                for (i, value) in block.iter_mut().enumerate() {
                    let negative = !(bits >> i) & 1;
                    *value = f64::from_bits(value.to_bits() ^ (negative << 63));
                }
            }
        }
    }
}

/// Moves the half-planes that still enter a rectangle to the front, and returns how many these are, up
/// to a whole vector.
fn compact(
    signed: &mut [f64],
    candidates: &mut [u32],
    units: usize,
    len: usize,
    middle: [f64; 2],
    half: [f64; 2],
) -> usize {
    let mut kept = 0;
    for i in 0..len {
        let (alpha, beta, gamma) = (signed[i], signed[units + i], signed[2 * units + i]);
        let margin = alpha + beta * middle[0] + gamma * middle[1];
        let reach = beta.abs() * half[0] + gamma.abs() * half[1];
        if margin < (1.0 + SIDE_TOLERANCE) * reach {
            signed[kept] = alpha;
            signed[units + kept] = beta;
            signed[2 * units + kept] = gamma;
            candidates[kept] = candidates[i];
            kept += 1;
        }
    }
    let whole = kept.next_multiple_of(LANES).min(units);
    signed[kept..whole].fill(f64::INFINITY);
    whole
}

/// The half-plane whose border comes closest to the middle of a rectangle, in parts of its reach over
/// the rectangle, of those that enter it. (Half-planes that reach nowhere never do.)
struct Closest<'a> {
    signed: &'a [f64],
    units: usize,
    len: usize,
    middle: [f64; 2],
    half: [f64; 2],
}

impl WithSimd for Closest<'_> {
    type Output = Option<usize>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> Option<usize> {
        let Self { signed, units, len, middle, half } = self;
        let (alpha, rest) = signed.split_at(units);
        let (beta, gamma) = rest.split_at(units);
        let (alpha, _) = alpha[..len].as_chunks::<LANES>();
        let (beta, _) = beta[..len].as_chunks::<LANES>();
        let (gamma, _) = gamma[..len].as_chunks::<LANES>();
        // The least ratio margin : reach of each lane, as a fraction, so that nothing is divided.
        let mut best = [1.0 + SIDE_TOLERANCE; LANES];
        let mut best_reach = [1.0; LANES];
        let mut at = [-1.0; LANES];
        for (chunk, ((a, b), c)) in alpha.iter().zip(beta).zip(gamma).enumerate() {
            let chunk = chunk as f64;
            for i in 0..LANES {
                let margin = a[i] + b[i] * middle[0] + c[i] * middle[1];
                let reach = b[i].abs() * half[0] + c[i].abs() * half[1];
                let closer = margin * best_reach[i] < best[i] * reach;
                best[i] = if closer { margin } else { best[i] };
                best_reach[i] = if closer { reach } else { best_reach[i] };
                at[i] = if closer { chunk } else { at[i] };
            }
        }
        let mut found = None;
        let mut least = f64::INFINITY;
        for i in 0..LANES {
            let ratio = best[i] / best_reach[i];
            if at[i] >= 0.0 && ratio < least {
                least = ratio;
                found = Some(at[i] as usize * LANES + i);
            }
        }
        found
    }
}
