//! The facets of a region as the vertices of the convex hull of its dual points (see
//! [`dual`](super::dual)).
//!
//! The hull starts with the extreme points along the axes. The supporting point beyond each edge becomes a
//! vertex, until no edge has one. One sweep over the units serves several edges.

use super::dual::{DIRECTIONS, DualPoint, DualPoints, INDEX_BITS};
use super::facets::{Borders, Entry, FACET_TOLERANCE};
use crate::simd::LANES;
use pam_core::simd::arch;
use pulp::{Simd, WithSimd};
use std::cmp::Ordering;

/// Buffers of the search for hulls.
#[derive(Debug, Default)]
pub(crate) struct HullFinder {
    dual: DualPoints,
    /// Vertices of the hull: units.
    vertices: Vec<u32>,
    /// Edges beyond which no point was looked for yet.
    edges: Vec<Edge>,
}

impl HullFinder {
    /// The units that bound a region; those past the last unit are sides of the window. `None` where several
    /// borders meet at the entry, and for more units than the [`INDEX_BITS`] can number.
    pub(crate) fn find(&mut self, borders: Borders<'_>, entry: Entry) -> Option<&[u32]> {
        if borders.table.units() + LANES > INDEX_BITS as usize {
            return None;
        }
        let found = arch().dispatch(Search { finder: self, borders, entry });
        found.then_some(&self.vertices[..])
    }
}

/// An edge of a growing hull, counter-clockwise.
#[derive(Debug, Clone, Copy)]
struct Edge {
    from: DualPoint,
    to: DualPoint,
}

/// The line through an edge.
#[derive(Debug, Clone, Copy, Default)]
struct EdgeLine {
    /// Outward normal.
    normal: [f64; 2],
    /// Points whose coordinate along the normal exceeds this lie outside. Points within
    /// [`FACET_TOLERANCE`] of the edge count: their borders come that near a vertex of the region.
    outside: f64,
}

impl Edge {
    #[inline(always)]
    fn line(&self) -> EdgeLine {
        let (a, b) = (self.from, self.to);
        let normal = [b.r - a.r, a.p - b.p];
        let at = a.p * normal[0] + a.r * normal[1];
        EdgeLine { normal, outside: at - FACET_TOLERANCE * at.abs() }
    }
}

/// Directions whose supporting points make the first hull.
const AXES: [[f64; 2]; DIRECTIONS] = [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
/// Points at the origin have no larger coordinate than this.
const INSIDE: f64 = f64::MIN_POSITIVE;

/// Finds the hull, whose vertices are then in the finder's buffers. The output says whether it was found.
struct Search<'a> {
    finder: &'a mut HullFinder,
    borders: Borders<'a>,
    entry: Entry,
}

impl WithSimd for Search<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> bool {
        let Self { finder, borders, entry } = self;
        let dual = &mut finder.dual;
        dual.set_signs(borders);
        let Some(inner) = dual.inner_point(simd, borders, entry) else { return false };
        if !dual.place(simd, borders, inner) || !finder.first_edges(simd) {
            return false;
        }
        finder.grow(simd);
        true
    }
}

impl HullFinder {
    /// Starts with the extreme points along the axes; false if these are fewer than two.
    #[inline(always)]
    fn first_edges<S: Simd>(&mut self, simd: S) -> bool {
        self.vertices.clear();
        self.edges.clear();
        let extremes = self.dual.supports(simd, AXES);
        for (k, from) in extremes.iter().enumerate() {
            // One point may be the extreme of several directions next to each other.
            let to = extremes[(k + 1) % AXES.len()].point;
            if from.point.unit != to.unit {
                self.edges.push(Edge { from: from.point, to });
            }
        }
        for edge in &self.edges {
            self.vertices.push(edge.to.unit);
            self.dual.remove(edge.to.unit);
        }
        self.edges.len() >= 2
    }

    /// Adds supporting points until no point lies beyond an edge.
    #[inline(always)]
    fn grow<S: Simd>(&mut self, simd: S) {
        let Self { dual, vertices, edges } = self;
        while !edges.is_empty() {
            let some = edges.len().saturating_sub(DIRECTIONS);
            let mut tried = [edges[some]; DIRECTIONS];
            let count = edges.len() - some;
            tried[..count].copy_from_slice(&edges[some..]);
            edges.truncate(some);
            let mut lines = [EdgeLine::default(); DIRECTIONS];
            let mut normals = [[0.0; 2]; DIRECTIONS];
            for k in 0..DIRECTIONS {
                lines[k] = tried[k].line();
                normals[k] = lines[k].normal;
            }
            let supports = dual.supports(simd, normals);
            for (k, edge) in tried[..count].iter().enumerate() {
                let support = supports[k];
                let outside = lines[k].outside.max(INSIDE);
                if support.along.partial_cmp(&outside) != Some(Ordering::Greater) {
                    continue;
                }
                let vertex = support.point;
                if vertices.contains(&vertex.unit) {
                    edges.push(*edge); // Another edge took it just now; there may be more.
                    continue;
                }
                vertices.push(vertex.unit);
                dual.remove(vertex.unit);
                edges.push(Edge { from: edge.from, to: vertex });
                edges.push(Edge { from: vertex, to: edge.to });
            }
        }
    }
}
