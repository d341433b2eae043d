//! The linear regions of a network on a plane, found as they are needed and kept.

use super::facet_finder::FacetFinder;
use super::facets::{Borders, Entry, FacetBlock, FacetIndex, FacetRange, NONE};
use super::half_plane::Window;
use super::polygon::{Clip, ConvexPolygon};
use crate::network::pattern::{slopes_into, unit_hash, word_and_mask};
use crate::network::preactivations::{ComputeLayer, PreActivations};
use crate::network::rank_one::{Buffers, RankOneUpdate};
use crate::network::{Plane, ReluNetwork};
use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

/// Rank-one updates after which a table is computed afresh, so that rounding does not build up.
const MAX_UPDATES: u16 = 32;

/// One linear region.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Region {
    /// The force in the region, `a + b p + c r`.
    pub(crate) force: [f64; 3],
    pub(crate) facets: FacetRange,
    pub(crate) origin: Origin,
    hash: u64,
    /// Another region with the same hash.
    same_hash: u32,
    table: TableIndex,
}

/// The region from which a region was first met, an earlier one, and the unit by which they differ.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Origin {
    pub(crate) parent: u32,
    pub(crate) unit: u32,
}

/// The pre-activations of a region in the cache.
#[derive(Debug, Clone, Copy)]
struct TableIndex {
    index: u32,
    /// Rank-one updates since it was computed afresh.
    updates: u16,
}

impl TableIndex {
    #[inline(always)]
    fn read<'a>(
        self,
        first: &'a [Vec<f64>; 3],
        tables: &'a [f64],
        len: usize,
    ) -> PreActivations<'a> {
        PreActivations { first, deeper: &tables[self.index as usize * len..][..len] }
    }
}

/// The pattern is hashed already.
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

/// The regions of a network on a plane. Memory is kept when the cache is restarted.
#[derive(Debug)]
pub(crate) struct RegionCache<'n> {
    pub(crate) network: &'n ReluNetwork,
    window: Window,
    units: usize,
    /// Words of a pattern.
    words: usize,
    /// Numbers of a table.
    table_len: usize,
    store: RegionWorkspace,
}

/// The memory of a [`RegionCache`].
#[derive(Debug, Default)]
pub(crate) struct RegionWorkspace {
    regions: Vec<Region>,
    facets: Vec<FacetBlock>,
    /// Tables one after the other; the last may be incomplete. Regions that differ by signs of the last
    /// layer alone share one.
    tables: Vec<f64>,
    /// Activation patterns, region by region.
    patterns: Vec<u64>,
    /// The last region with each hash.
    index: HashMap<u64, u32, BuildHasherDefault<Identity>>,
    /// Pre-activations of the first layer.
    first: [Vec<f64>; 3],
    /// The pattern that is looked for.
    wanted: Vec<u64>,
    buffers: Buffers,
    finder: FacetFinder,
    polygon: ConvexPolygon,
}

impl<'n> RegionCache<'n> {
    /// An empty cache in the memory of an earlier one.
    pub(crate) fn new(
        network: &'n ReluNetwork,
        plane: Plane,
        window: Window,
        mut store: RegionWorkspace,
    ) -> Self {
        store.regions.clear();
        store.facets.clear();
        store.tables.clear();
        store.patterns.clear();
        store.index.clear();
        store.first = network.first_layer(&plane);
        let units = network.units();
        let table_len = 3 * (units - network.start(1));
        Self { network, window, units, words: units.div_ceil(64), table_len, store }
    }

    pub(crate) fn into_workspace(self) -> RegionWorkspace {
        self.store
    }

    #[inline(always)]
    pub(crate) fn len(&self) -> usize {
        self.store.regions.len()
    }

    #[inline(always)]
    pub(crate) fn region(&self, id: u32) -> &Region {
        &self.store.regions[id as usize]
    }

    #[inline(always)]
    pub(crate) fn facets(&self, range: FacetRange) -> &[FacetBlock] {
        &self.store.facets[range.first as usize..][..range.blocks as usize]
    }

    /// The pre-activations of a region.
    #[inline(always)]
    pub(crate) fn table(&self, id: u32) -> PreActivations<'_> {
        self.region(id).table.read(&self.store.first, &self.store.tables, self.table_len)
    }

    /// The activation pattern of a region.
    #[inline(always)]
    pub(crate) fn pattern(&self, id: u32) -> &[u64] {
        &self.store.patterns[id as usize * self.words..][..self.words]
    }

    /// The region of a point; a unit that is zero there counts as inactive.
    pub(crate) fn locate(&mut self, point: [f64; 2]) -> u32 {
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
                ComputeLayer { network, l, first: &store.first, slopes, deeper }.run();
            }
            let table = PreActivations { first: &store.first, deeper };
            let start = network.start(l);
            let [alpha, beta, gamma] = table.units_from(start, layer.outputs);
            for i in 0..layer.outputs {
                let z = alpha[i] + beta[i] * point[0] + gamma[i] * point[1];
                if z > 0.0 {
                    let unit = start + i;
                    let (word, mask) = word_and_mask(unit);
                    store.wanted[word] |= mask;
                    slopes[unit] = 1.0;
                    hash ^= unit_hash(unit);
                }
            }
        }
        if let Some(id) = self.find(hash) {
            self.store.tables.truncate(place);
            return id;
        }
        let table = TableIndex { index: self.last_table(), updates: 0 };
        self.insert(hash, table, Origin { parent: NONE, unit: NONE }, Some(point))
    }

    /// The table that was added last.
    fn last_table(&self) -> u32 {
        (self.store.tables.len().checked_div(self.table_len)).map_or(0, |count| count as u32 - 1)
    }

    /// The region with the wanted pattern.
    fn find(&self, hash: u64) -> Option<u32> {
        let mut id = *self.store.index.get(&hash)?;
        while id != NONE {
            if self.pattern(id) == &self.store.wanted[..] {
                return Some(id);
            }
            id = self.store.regions[id as usize].same_hash;
        }
        None
    }

    /// The region on the other side of a facet of `id`. For a new region, a point of the facet that lies in
    /// the new region too makes its facets cheap to find.
    #[inline(always)]
    pub(crate) fn neighbour(&mut self, id: u32, facet: FacetIndex, point: Option<[f64; 2]>) -> u32 {
        let first = self.store.regions[id as usize].facets.first as usize;
        let known = self.store.facets[first + facet.block].neighbour[facet.lane];
        if known != NONE { known } else { self.find_neighbour(id, facet, point) }
    }

    #[cold]
    #[inline(never)]
    fn find_neighbour(&mut self, id: u32, facet: FacetIndex, point: Option<[f64; 2]>) -> u32 {
        let old = self.store.regions[id as usize];
        let place = old.facets.first as usize + facet.block;
        let unit = self.store.facets[place].unit[facet.lane];
        let (word, mask) = word_and_mask(unit as usize);
        let store = &mut self.store;
        store.wanted.clear();
        store.wanted.extend_from_slice(&store.patterns[id as usize * self.words..][..self.words]);
        store.wanted[word] ^= mask;
        let hash = old.hash ^ unit_hash(unit as usize);
        let new = match self.find(hash) {
            Some(new) => new,
            None => {
                let table = self.updated_table(old.table, unit as usize);
                self.insert(hash, table, Origin { parent: id, unit }, point)
            }
        };
        self.store.facets[place].neighbour[facet.lane] = new;
        new
    }

    /// The table of the wanted pattern, which differs from that of `old` by the sign of one unit.
    fn updated_table(&mut self, old: TableIndex, unit: usize) -> TableIndex {
        if unit >= self.network.last_start() {
            return old;
        }
        let RegionWorkspace { tables, wanted, first, buffers, .. } = &mut self.store;
        let (network, len, place) = (self.network, self.table_len, tables.len());
        let updates = if old.updates >= MAX_UPDATES {
            tables.resize(place + len, 0.0);
            let (slopes, deeper) = (&mut buffers.slopes, &mut tables[place..]);
            slopes.resize(self.units, 0.0);
            slopes_into(wanted, network.slope, slopes);
            for l in 1..network.hidden.len() {
                ComputeLayer { network, l, first, slopes, deeper }.run();
            }
            0
        } else {
            let from = old.index as usize * len;
            tables.extend_from_within(from..from + len);
            let deeper = &mut tables[place..];
            RankOneUpdate { network, unit, pattern: wanted, first, buffers, deeper }.run();
            old.updates + 1
        };
        TableIndex { index: self.last_table(), updates }
    }

    /// Adds the region with the wanted pattern.
    fn insert(
        &mut self,
        hash: u64,
        table: TableIndex,
        origin: Origin,
        point: Option<[f64; 2]>,
    ) -> u32 {
        let store = &mut self.store;
        let id = store.regions.len() as u32;
        let read = table.read(&store.first, &store.tables, self.table_len);
        let force = read.force(self.network, &store.wanted);
        let entry = point.map(|point| Entry { point, unit: origin.unit });
        let first = store.facets.len() as u32;
        let borders = Borders { window: &self.window, table: read, pattern: &store.wanted };
        store.finder.find(borders, entry, &mut store.facets);
        let facets = FacetRange { first, blocks: store.facets.len() as u32 - first };
        store.patterns.extend_from_slice(&store.wanted);
        let same_hash = store.index.insert(hash, id).unwrap_or(NONE);
        store.regions.push(Region { force, facets, origin, hash, same_hash, table });
        id
    }

    /// The polygon of a region within the window, counter-clockwise; empty if no part of it lies there.
    pub(crate) fn polygon(&mut self, id: u32) -> Vec<[f64; 2]> {
        let FacetRange { first, blocks } = self.store.regions[id as usize].facets;
        let polygon = &mut self.store.polygon;
        polygon.restart(&self.window);
        for block in &self.store.facets[first as usize..][..blocks as usize] {
            for lane in block.lanes() {
                if polygon.clip(&block.half_plane(lane)) == Clip::Nothing {
                    return Vec::new();
                }
            }
        }
        polygon.vertices.clone()
    }
}
