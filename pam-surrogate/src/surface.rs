//! The force of one trajectory as a surface of patches over (x, ẋ), made where the motion goes.
//!
//! The plane is divided into rectangles: a large one over the expected motion, smaller ones around it. On each the force is
//! interpolated at Chebyshev nodes, whose numbers along x and ẋ are estimated from probe lines across the rectangle; the
//! error is checked between the nodes. A rectangle that would need too many nodes is halved along the direction that needs more.
//! Rectangles that the measured motion passes are made beforehand, others when the motion enters them.

use crate::cells::{CellScheme, Cells, LINE};
use crate::chebyshev;
use crate::nodes::NodeForce;
use crate::polynomial;
use pulp::Simd;

/// Positions in [−1, 1] of the probe lines across a rectangle, from which the number of nodes is estimated.
const LINES: [f64; 2] = [-0.6, 0.45];
/// Check points along each direction, between the nodes.
const CHECKS: usize = 5;
/// Fractions of the tolerance for truncating the Chebyshev series and for the cells of a patch.
const SHARE_OF_LINES: f64 = 0.2;
const SHARE_OF_CELLS: f64 = 0.2;
/// Most halvings of a root rectangle.
const DEEPEST: usize = 24;
/// Rectangles around the one over the expected motion are this much smaller.
const OUTER: f64 = 0.25;

/// How closely a surface follows the force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Fidelity {
    /// Largest error at the check points, mN.
    pub(crate) error_mn: f64,
    /// Most patches of one trajectory.
    pub(crate) most_patches: usize,
}

/// The surface cannot follow the force.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct TooRough;

/// A rectangle of the plane.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Area {
    low: [f64; 2],
    high: [f64; 2],
    depth: usize,
    /// Nodes along each direction that are enough for a rectangle of which this is a part, if its width was the same.
    known: [Option<usize>; 2],
}

impl Area {
    fn middle(&self) -> [f64; 2] {
        [0, 1].map(|d| 0.5 * (self.low[d] + self.high[d]))
    }

    /// The point at places in [−1, 1].
    fn at(&self, place: [f64; 2]) -> [f64; 2] {
        let middle = self.middle();
        [0, 1].map(|d| middle[d] + 0.5 * (self.high[d] - self.low[d]) * place[d])
    }

    fn contains(&self, [x, v]: [f64; 2]) -> bool {
        self.low[0] <= x && x < self.high[0] && self.low[1] <= v && v < self.high[1]
    }

    /// The lower and the upper half along a direction.
    fn halves(&self, along: usize) -> [Self; 2] {
        let (mut lower, mut upper) = (*self, *self);
        lower.high[along] = self.middle()[along];
        upper.low[along] = self.middle()[along];
        let mut known = self.known;
        known[along] = None;
        [lower, upper].map(|c| Self { depth: self.depth + 1, known, ..c })
    }
}

#[derive(Debug, Clone, Copy)]
enum Node {
    Unmade(Area),
    Halved { along: usize, at: f64, children: usize },
    Patch(usize),
}

/// A rectangle with its nodes and its cells.
#[derive(Debug, Clone)]
pub(crate) struct Patch {
    area: Area,
    /// Cells per mm and per mm/s.
    per_unit: [f64; 2],
    cells: Cells,
    /// Nodes in [−1, 1] along each direction.
    nodes: [Vec<f64>; 2],
    visited: bool,
}

/// A place in a cell.
#[derive(Debug, Clone, Copy)]
struct Place {
    cell: usize,
    x: f64,
    v: f64,
}

/// The last place of a patch is no more than this share of its cells away from its start: the upper border must not be rounded
/// into a cell past the end.
const INSIDE: f64 = 1.0 - 8.0 * f64::EPSILON;
/// Adding this rounds a small number to an integer, which then sits in the low bits.
const ROUND: f64 = 1.5 * (1u64 << 52) as f64;

impl Patch {
    #[inline(always)]
    pub(crate) fn contains(&self, at: [f64; 2]) -> bool {
        self.area.contains(at)
    }

    /// The cell at a point of the patch, and the place there.
    #[inline(always)]
    fn place(&self, [x, v]: [f64; 2]) -> Place {
        let x = (x - self.area.low[0]) * self.per_unit[0] - 0.5;
        let v = (v - self.area.low[1]) * self.per_unit[1] - 0.5;
        let (x_bits, v_bits) = (x + ROUND, v + ROUND);
        let [_, columns] = self.cells.counts();
        let whole = |bits: f64| bits.to_bits() as u32 as usize;
        Place {
            cell: whole(x_bits) * columns + whole(v_bits),
            x: 2.0 * (x - (x_bits - ROUND)),
            v: 2.0 * (v - (v_bits - ROUND)),
        }
    }

    /// The force (mN) and its derivatives by x (mN/mm) and ẋ (kg/s).
    #[inline(always)]
    pub(crate) fn force_and_slopes<S: Simd>(&self, simd: S, at: [f64; 2]) -> [f64; 3] {
        let Place { cell, x, v } = self.place(at);
        let [force, by_x, by_v] = polynomial::value_and_slopes(simd, &self.cells.terms[cell], x, v);
        [force, 2.0 * by_x * self.per_unit[0], 2.0 * by_v * self.per_unit[1]]
    }

    /// Adds the cotangent of the force at a point.
    #[inline(always)]
    pub(crate) fn accumulate<S: Simd>(&mut self, simd: S, at: [f64; 2], cotangent: f64) {
        let Place { cell, x, v } = self.place(at);
        polynomial::accumulate(simd, &mut self.cells.sums[cell], cotangent, x, v);
        self.visited = true;
    }
}

/// Memory that outlives a surface.
#[derive(Debug, Default)]
pub(crate) struct SurfaceWorkspace {
    /// Nodes (mm, mm/s), and forces or their cotangents there.
    pub(crate) points: Vec<[f64; 2]>,
    pub(crate) values: Vec<f64>,
}

/// The surface of one trajectory.
#[derive(Debug)]
pub(crate) struct Surface<'a> {
    scheme: &'a CellScheme,
    fidelity: Fidelity,
    /// Middle and width of the root over the expected motion.
    origin: [f64; 2],
    width: [f64; 2],
    roots: Vec<([i32; 2], usize)>,
    nodes: Vec<Node>,
    pub(crate) patches: Vec<Patch>,
    /// Forces that were computed.
    pub(crate) evaluations: usize,
}

/// Node counts that a rectangle needs, or the direction along which it is to be halved.
enum Need {
    Nodes([usize; 2]),
    Halving(usize),
}

impl<'a> Surface<'a> {
    /// An empty surface with a root of this middle and width.
    pub(crate) fn new(
        scheme: &'a CellScheme,
        fidelity: Fidelity,
        origin: [f64; 2],
        width: [f64; 2],
    ) -> Self {
        Self {
            scheme,
            fidelity,
            origin,
            width,
            roots: Vec::new(),
            nodes: Vec::new(),
            patches: Vec::new(),
            evaluations: 0,
        }
    }

    /// The root at a point; made known if it is new. `None` if the point is nowhere.
    fn root(&mut self, at: [f64; 2]) -> Option<usize> {
        // From the middle in widths; beyond a half in steps of the outer ones.
        let place = [0, 1].map(|d| {
            let from = (at[d] - self.origin[d]) / self.width[d];
            let inside = (-0.5..0.5).contains(&from);
            let beyond = (from.abs() - 0.5) / OUTER;
            if inside {
                0.0
            } else if from < 0.0 {
                -beyond.ceil().max(1.0)
            } else {
                beyond.floor() + 1.0
            }
        });
        if !place.iter().all(|p| p.abs() < 1e6) {
            return None;
        }
        let place = place.map(|p| p as i32);
        if let Some(&(_, node)) = self.roots.iter().find(|(p, _)| *p == place) {
            return Some(node);
        }
        // The lower edge of the k-th root.
        let edge = |d: usize, k: i32| {
            let from =
                if k > 0 { 0.5 + OUTER * f64::from(k - 1) } else { -0.5 + OUTER * f64::from(k) };
            self.origin[d] + self.width[d] * from
        };
        let area = Area {
            low: [edge(0, place[0]), edge(1, place[1])],
            high: [edge(0, place[0] + 1), edge(1, place[1] + 1)],
            depth: 0,
            known: [None; 2],
        };
        self.nodes.push(Node::Unmade(area));
        self.roots.push((place, self.nodes.len() - 1));
        Some(self.nodes.len() - 1)
    }

    /// The node without children at a point.
    fn descend(&self, mut node: usize, at: [f64; 2]) -> usize {
        while let Node::Halved { along, at: border, children } = self.nodes[node] {
            node = children + usize::from(at[along] >= border);
        }
        node
    }

    /// The patch at a point, made if there is none.
    #[inline(never)]
    pub(crate) fn patch_at(
        &mut self,
        at: [f64; 2],
        memory: &mut SurfaceWorkspace,
        force: &mut dyn NodeForce,
    ) -> Result<usize, TooRough> {
        let root = self.root(at).ok_or(TooRough)?;
        loop {
            let node = self.descend(root, at);
            match self.nodes[node] {
                Node::Patch(index) => return Ok(index),
                Node::Unmade(area) => self.make(node, area, memory, force)?,
                Node::Halved { .. } => unreachable!("a node without children"),
            }
        }
    }

    /// Makes the patches that a path passes.
    pub(crate) fn make_along(
        &mut self,
        path: impl Iterator<Item = [f64; 2]>,
        memory: &mut SurfaceWorkspace,
        force: &mut dyn NodeForce,
    ) -> Result<(), TooRough> {
        let mut last = None;
        for at in path {
            if !last.is_some_and(|p: usize| self.patches[p].contains(at)) {
                last = Some(self.patch_at(at, memory, force)?);
            }
        }
        Ok(())
    }

    /// Turns an unmade node into a patch, or halves it.
    fn make(
        &mut self,
        node: usize,
        mut area: Area,
        memory: &mut SurfaceWorkspace,
        force: &mut dyn NodeForce,
    ) -> Result<(), TooRough> {
        let along = match self.need(&mut area, memory, force)? {
            Need::Halving(along) => along,
            Need::Nodes(mut counts) => loop {
                let tried = self.patch(&area, counts, memory, force)?;
                if let Some(patch) = tried {
                    self.nodes[node] = Node::Patch(self.patches.len());
                    self.patches.push(patch);
                    return Ok(());
                }
                // The probe lines underestimated: more nodes, while they are few.
                let more = counts.map(|n| n + n.div_ceil(4));
                if more.iter().any(|&n| n > LINE) {
                    break usize::from(counts[1] > counts[0]);
                }
                counts = more;
            },
        };
        let used = self.patches.len() + self.nodes.len() / 2;
        if area.depth >= DEEPEST || used > self.fidelity.most_patches {
            return Err(TooRough);
        }
        let children = self.nodes.len();
        self.nodes.extend(area.halves(along).map(Node::Unmade));
        self.nodes[node] = Node::Halved { along, at: area.middle()[along], children };
        Ok(())
    }

    /// The force at points that are in the memory.
    fn evaluate(&mut self, memory: &mut SurfaceWorkspace, force: &mut dyn NodeForce) {
        let SurfaceWorkspace { points, values } = memory;
        values.resize(points.len(), 0.0);
        force.values_into(points, values);
        self.evaluations += points.len();
    }

    /// Estimates the number of nodes of a rectangle from probe lines across it.
    fn need(
        &mut self,
        area: &mut Area,
        memory: &mut SurfaceWorkspace,
        force: &mut dyn NodeForce,
    ) -> Result<Need, TooRough> {
        let scheme = self.scheme;
        memory.points.clear();
        let asked: Vec<usize> = (0..2).filter(|&d| area.known[d].is_none()).collect();
        for &along in &asked {
            for across in LINES {
                let place = |at: f64| if along == 0 { [at, across] } else { [across, at] };
                memory.points.extend(scheme.line.iter().map(|&at| area.at(place(at))));
            }
        }
        self.evaluate(memory, force);
        if !memory.values.iter().all(|v| v.is_finite()) {
            return Err(TooRough);
        }
        let error = SHARE_OF_LINES * self.fidelity.error_mn;
        let mut lines = memory.values.chunks_exact(LINE);
        let mut last = [0.0; 2];
        for along in asked {
            let mut largest = vec![0.0f64; LINE];
            for values in lines.by_ref().take(LINES.len()) {
                let sizes = scheme.transform.sizes(values);
                largest.iter_mut().zip(&sizes).for_each(|(l, c)| *l = l.max(*c));
                last[along] += sizes[LINE - 8..].iter().sum::<f64>();
            }
            area.known[along] = chebyshev::nodes_within(&largest, error);
        }
        Ok(match area.known {
            [Some(x), Some(v)] => Need::Nodes([x, v]),
            _ => Need::Halving(usize::from(last[1] > last[0])),
        })
    }

    /// A patch with these numbers of nodes, if it is close enough to the force.
    fn patch(
        &mut self,
        area: &Area,
        counts: [usize; 2],
        memory: &mut SurfaceWorkspace,
        force: &mut dyn NodeForce,
    ) -> Result<Option<Patch>, TooRough> {
        let nodes = counts.map(chebyshev::nodes);
        let checks = [0, 1].map(|d| middles(&nodes[d]));
        memory.points.clear();
        lattice(area, [&nodes[0], &nodes[1]], &mut memory.points);
        lattice(area, [&checks[0], &checks[1]], &mut memory.points);
        self.evaluate(memory, force);
        if !memory.values.iter().all(|v| v.is_finite()) {
            return Err(TooRough);
        }
        let (values, at_checks) = memory.values.split_at(counts[0] * counts[1]);
        let error = SHARE_OF_CELLS * self.fidelity.error_mn;
        let Some(cells) = Cells::new(self.scheme, [&nodes[0], &nodes[1]], values, error) else {
            return Ok(None);
        };
        let per_unit =
            [0, 1].map(|d| cells.counts()[d] as f64 * INSIDE / (area.high[d] - area.low[d]));
        let patch = Patch { area: *area, per_unit, cells, nodes, visited: false };
        let mut expected = checks[0].iter().flat_map(|&x| checks[1].iter().map(move |&v| [x, v]));
        let within = at_checks.iter().all(|value| {
            let place = expected.next().unwrap_or_default();
            (patch.force(area.at(place)) - value).abs() <= self.fidelity.error_mn
        });
        Ok(within.then_some(patch))
    }

    /// Leaves in the memory the nodes of the patches that cotangents have come to, and the cotangents of the force there.
    pub(crate) fn cotangents_into(&self, memory: &mut SurfaceWorkspace) {
        let SurfaceWorkspace { points, values } = memory;
        points.clear();
        values.clear();
        for patch in self.patches.iter().filter(|p| p.visited) {
            let from = values.len();
            lattice(&patch.area, [&patch.nodes[0], &patch.nodes[1]], points);
            values.resize(points.len(), 0.0);
            patch.cells.pull_back(&mut values[from..]);
        }
    }
}

impl Patch {
    /// The force at a point, mN, without vector instructions.
    fn force(&self, at: [f64; 2]) -> f64 {
        let Place { cell, x, v } = self.place(at);
        let row = |row: &[f64]| row.iter().rev().fold(0.0, |sum, c| sum * v + c);
        let rows = self.cells.terms[cell].0.chunks_exact(polynomial::NODES);
        rows.rev().fold(0.0, |sum, r| sum * x + row(r))
    }
}

/// Middles of some gaps between nodes, the outermost included.
fn middles(nodes: &[f64]) -> Vec<f64> {
    let gaps = nodes.len() - 1;
    (0..CHECKS)
        .map(|k| {
            let gap = k * (gaps - 1) / (CHECKS - 1);
            0.5 * (nodes[gap] + nodes[gap + 1])
        })
        .collect()
}

/// Points of a rectangle on the product of two grids of [−1, 1], row by row of equal x.
fn lattice(area: &Area, [along_x, along_v]: [&[f64]; 2], points: &mut Vec<[f64; 2]>) {
    for &x in along_x {
        points.extend(along_v.iter().map(|&v| area.at([x, v])));
    }
}
