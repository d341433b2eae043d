//! The patterns of a network on a plane, found as they are needed and kept.

use crate::affine::{Buffers, Table, build, build_layer, flip, output, word, write_slopes};
use crate::cell::{Cell, Clip, Window};
use crate::network::{LANES, PiecewiseNetwork, Plane};
use crate::sides::{SideFinder, Sides};
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// No pattern, no unit.
pub(crate) const NONE: u32 = u32::MAX;
/// A table this many flips away from one that was computed afresh is computed afresh, so that
/// rounding does not build up.
const LONGEST_CHAIN: u16 = 32;

/// One activation pattern.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pattern {
    /// The force in the pattern, `a + b p + c r`.
    pub(crate) force: [f64; 3],
    /// First block of its sides.
    pub(crate) sides: u32,
    pub(crate) side_blocks: u32,
    /// The pattern from which it was met first, an earlier one, and the unit by which they differ.
    pub(crate) parent: u32,
    pub(crate) flipped: u32,
    hash: u64,
    /// Another pattern with the same hash.
    same_hash: u32,
    /// Its table, and how many changes that is away from one that was computed afresh.
    table: u32,
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
    units: usize,
    words: usize,
    /// Numbers of a table.
    table_len: usize,
    store: AtlasMemory,
}

/// The memory of an [`Atlas`].
#[derive(Debug, Default)]
pub(crate) struct AtlasMemory {
    patterns: Vec<Pattern>,
    sides: Vec<Sides>,
    /// Tables one after the other; the last may be in the making. A pattern shares that of the pattern
    /// from which it was met, if no more than a sign of the last layer is between them.
    tables: Vec<f64>,
    /// Signs of the units, pattern by pattern.
    bits: Vec<u64>,
    index: Index,
    first: [Vec<f64>; 3],
    /// Signs of a pattern that is looked for.
    wanted: Vec<u64>,
    buffers: Buffers,
    finder: SideFinder,
    cell: Cell,
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
        let units = network.units();
        let table_len = 3 * (units - network.start(1));
        Self { network, window, units, words: units.div_ceil(64), table_len, store }
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
    pub(crate) fn sides(&self, first: u32, blocks: u32) -> &[Sides] {
        &self.store.sides[first as usize..][..blocks as usize]
    }

    /// The pre-activations of a pattern.
    #[inline(always)]
    pub(crate) fn table(&self, id: u32) -> Table<'_> {
        let place = self.store.patterns[id as usize].table as usize * self.table_len;
        Table { first: &self.store.first, deeper: &self.store.tables[place..][..self.table_len] }
    }

    /// Signs of the units of a pattern.
    #[inline(always)]
    pub(crate) fn bits(&self, id: u32) -> &[u64] {
        &self.store.bits[id as usize * self.words..][..self.words]
    }

    /// Writes the slope of each unit in a pattern.
    pub(crate) fn slopes_into(&self, id: u32, slopes: &mut Vec<f64>) {
        write_slopes(self.bits(id), self.network.slope, self.units, slopes);
    }

    /// The pattern at a point; a unit that is zero there counts as negative.
    pub(crate) fn at(&mut self, point: [f64; 2]) -> u32 {
        let (network, units) = (self.network, self.units);
        let store = &mut self.store;
        let place = store.tables.len();
        store.tables.resize(place + self.table_len, 0.0);
        store.wanted.clear();
        store.wanted.resize(self.words, 0);
        let slopes = &mut store.buffers.slopes;
        slopes.clear();
        slopes.resize(units, network.slope);
        let mut hash = 0;
        for (l, layer) in network.hidden.iter().enumerate() {
            let deeper = &mut store.tables[place..];
            if l > 0 {
                build_layer(network, l, &store.first, slopes, deeper);
            }
            let table = Table { first: &store.first, deeper };
            let start = network.start(l);
            let [alpha, beta, gamma] = table.units_from(start, layer.outputs);
            for i in 0..layer.outputs {
                let z = alpha[i] + beta[i] * point[0] + gamma[i] * point[1];
                if z > 0.0 {
                    let unit = start + i;
                    let (w, bit) = word(unit);
                    store.wanted[w] |= bit;
                    slopes[unit] = 1.0;
                    hash ^= unit_hash(unit);
                }
            }
        }
        if let Some(id) = self.find(hash) {
            self.store.tables.truncate(place);
            return id;
        }
        let table = self.last_table();
        self.insert(hash, (table, 0), (NONE, NONE), Some(point))
    }

    /// The table that was added last.
    fn last_table(&self) -> u32 {
        (self.store.tables.len().checked_div(self.table_len)).map_or(0, |count| count as u32 - 1)
    }

    /// The pattern with the signs that are looked for.
    fn find(&self, hash: u64) -> Option<u32> {
        let mut id = *self.store.index.get(&hash)?;
        while id != NONE {
            if self.bits(id) == &self.store.wanted[..] {
                return Some(id);
            }
            id = self.store.patterns[id as usize].same_hash;
        }
        None
    }

    /// The pattern behind a side of `id`. If it is new, a point of the side that also lies in the new
    /// pattern's cell makes its sides cheap to find.
    #[inline(always)]
    pub(crate) fn behind(
        &mut self,
        id: u32,
        block: usize,
        lane: usize,
        entry: Option<[f64; 2]>,
    ) -> u32 {
        let first = self.store.patterns[id as usize].sides as usize;
        let known = self.store.sides[first + block].neighbour[lane];
        if known != NONE { known } else { self.look_behind(id, block, lane, entry) }
    }

    #[cold]
    #[inline(never)]
    fn look_behind(&mut self, id: u32, block: usize, lane: usize, entry: Option<[f64; 2]>) -> u32 {
        let old = self.store.patterns[id as usize];
        let place = old.sides as usize + block;
        let unit = self.store.sides[place].unit[lane];
        let (w, bit) = word(unit as usize);
        let store = &mut self.store;
        store.wanted.clear();
        store.wanted.extend_from_slice(&store.bits[id as usize * self.words..][..self.words]);
        store.wanted[w] ^= bit;
        let hash = old.hash ^ unit_hash(unit as usize);
        let new = match self.find(hash) {
            Some(new) => new,
            None => {
                let table = self.make_table(&old, unit as usize);
                self.insert(hash, table, (id, unit), entry)
            }
        };
        self.store.sides[place].neighbour[lane] = new;
        new
    }

    /// The table of a pattern with one unit flipped, and its distance from one that was computed afresh.
    fn make_table(&mut self, old: &Pattern, unit: usize) -> (u32, u16) {
        if unit >= self.network.start(self.network.hidden.len() - 1) {
            return (old.table, old.chain);
        }
        let store = &mut self.store;
        let len = self.table_len;
        let place = store.tables.len();
        if old.chain >= LONGEST_CHAIN {
            store.tables.resize(place + len, 0.0);
            let table = &mut store.tables[place..];
            build(self.network, &store.wanted, &store.first, &mut store.buffers, table);
            return (self.last_table(), 0);
        }
        let from = old.table as usize * len;
        store.tables.extend_from_within(from..from + len);
        let table = &mut store.tables[place..];
        flip(self.network, unit, &store.wanted, &store.first, &mut store.buffers, table);
        (self.last_table(), old.chain + 1)
    }

    /// Keeps the pattern whose signs are those looked for, with its table.
    fn insert(
        &mut self,
        hash: u64,
        (table, chain): (u32, u16),
        (parent, flipped): (u32, u32),
        entry: Option<[f64; 2]>,
    ) -> u32 {
        let id = self.store.patterns.len() as u32;
        let store = &mut self.store;
        let place = table as usize * self.table_len;
        let deeper = &store.tables[place..][..self.table_len];
        let seen = Table { first: &store.first, deeper };
        let force = output(self.network, seen, &store.wanted);
        let first = store.sides.len() as u32;
        let known = entry.map(|point| (point, flipped));
        store.finder.find(&self.window, seen, &store.wanted, known, &mut store.sides);
        store.bits.extend_from_slice(&store.wanted);
        let same_hash = store.index.insert(hash, id).unwrap_or(NONE);
        let side_blocks = store.sides.len() as u32 - first;
        store.patterns.push(Pattern {
            force,
            sides: first,
            side_blocks,
            parent,
            flipped,
            hash,
            same_hash,
            table,
            chain,
        });
        id
    }

    /// The polygon of a pattern within the window, counter-clockwise; empty if nothing of it is there.
    pub(crate) fn polygon(&mut self, id: u32) -> Vec<[f64; 2]> {
        let pattern = self.store.patterns[id as usize];
        let cell = &mut self.store.cell;
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
