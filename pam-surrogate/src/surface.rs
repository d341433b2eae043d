//! The force of one trajectory as a surface of patches over (x, ẋ), made where the motion goes.
//!
//! The plane is divided into equal root cells. A cell whose polynomial misses the force between its nodes by more than the
//! tolerance is halved, along the direction in which its highest coefficients are larger. Cells that the measured motion
//! passes are made beforehand, level by level, in large batches of the network; others when the motion enters them.

use crate::nodes::NodeForce;
use crate::polynomial::{self, Interpolation, NODES, PATCH_NODES, Terms};
use pulp::Simd;

/// Check points along each direction, between the nodes.
const CHECKS: usize = 4;
const PATCH_POINTS: usize = PATCH_NODES + CHECKS * CHECKS;
/// Most halvings of a root cell.
const DEEPEST: usize = 24;

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
struct Cell {
    low: [f64; 2],
    high: [f64; 2],
    depth: usize,
}

impl Cell {
    fn middle(&self) -> [f64; 2] {
        [0, 1].map(|d| 0.5 * (self.low[d] + self.high[d]))
    }

    fn half_width(&self) -> [f64; 2] {
        [0, 1].map(|d| 0.5 * (self.high[d] - self.low[d]))
    }

    fn contains(&self, [x, v]: [f64; 2]) -> bool {
        self.low[0] <= x && x < self.high[0] && self.low[1] <= v && v < self.high[1]
    }

    /// The lower and the upper half along a direction.
    fn halves(&self, along: usize) -> [Self; 2] {
        let (mut lower, mut upper) = (*self, *self);
        lower.high[along] = self.middle()[along];
        upper.low[along] = self.middle()[along];
        [lower, upper].map(|c| Self { depth: self.depth + 1, ..c })
    }
}

#[derive(Debug, Clone, Copy)]
enum Node {
    Unmade(Cell),
    Halved { along: usize, at: f64, children: usize },
    Patch(usize),
}

/// A cell with its polynomial.
#[derive(Debug, Clone)]
pub(crate) struct Patch {
    terms: Terms,
    sums: Terms,
    cell: Cell,
    middle: [f64; 2],
    per_unit: [f64; 2],
    visited: bool,
}

impl Patch {
    #[inline(always)]
    pub(crate) fn contains(&self, at: [f64; 2]) -> bool {
        self.cell.contains(at)
    }

    #[inline(always)]
    fn local(&self, [x, v]: [f64; 2]) -> [f64; 2] {
        [(x - self.middle[0]) * self.per_unit[0], (v - self.middle[1]) * self.per_unit[1]]
    }

    /// The force, mN.
    #[inline(always)]
    pub(crate) fn force_mn<S: Simd>(&self, simd: S, at: [f64; 2]) -> f64 {
        let [x, v] = self.local(at);
        polynomial::value(simd, &self.terms, x, v)
    }

    /// The force (mN) and its derivatives by x (mN/mm) and ẋ (kg/s).
    #[inline(always)]
    pub(crate) fn force_and_slopes<S: Simd>(&self, simd: S, at: [f64; 2]) -> [f64; 3] {
        let [x, v] = self.local(at);
        let [force, by_x, by_v] = polynomial::value_and_slopes(simd, &self.terms, x, v);
        [force, by_x * self.per_unit[0], by_v * self.per_unit[1]]
    }

    /// Adds the cotangent of the force at a point.
    #[inline(always)]
    pub(crate) fn accumulate<S: Simd>(&mut self, simd: S, at: [f64; 2], cotangent: f64) {
        let [x, v] = self.local(at);
        polynomial::accumulate(simd, &mut self.sums, cotangent, x, v);
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
    interpolation: &'a Interpolation,
    fidelity: Fidelity,
    /// Middle and width of the first root cell.
    origin: [f64; 2],
    width: [f64; 2],
    roots: Vec<([i32; 2], usize)>,
    nodes: Vec<Node>,
    pub(crate) patches: Vec<Patch>,
    /// Forces at nodes that were computed.
    pub(crate) evaluations: usize,
}

impl<'a> Surface<'a> {
    /// An empty surface whose root cells have a width; one of them is centred at the origin.
    pub(crate) fn new(
        interpolation: &'a Interpolation,
        fidelity: Fidelity,
        origin: [f64; 2],
        width: [f64; 2],
    ) -> Self {
        Self {
            interpolation,
            fidelity,
            origin,
            width,
            roots: Vec::new(),
            nodes: Vec::new(),
            patches: Vec::new(),
            evaluations: 0,
        }
    }

    /// The root cell at a point; made known if it is new. `None` if the point is nowhere.
    fn root(&mut self, at: [f64; 2]) -> Option<usize> {
        let place = [0, 1].map(|d| ((at[d] - self.origin[d]) / self.width[d] + 0.5).floor());
        if !place.iter().all(|p| p.abs() < 1e6) {
            return None;
        }
        let place = place.map(|p| p as i32);
        if let Some(&(_, node)) = self.roots.iter().find(|(p, _)| *p == place) {
            return Some(node);
        }
        let edge = |d: usize, k: i32| self.origin[d] + self.width[d] * (f64::from(k) - 0.5);
        let cell = Cell {
            low: [edge(0, place[0]), edge(1, place[1])],
            high: [edge(0, place[0] + 1), edge(1, place[1] + 1)],
            depth: 0,
        };
        self.nodes.push(Node::Unmade(cell));
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
                _ => self.make(&[node], memory, force)?,
            }
        }
    }

    /// Makes the patches that a path passes.
    pub(crate) fn make_along(
        &mut self,
        path: impl Iterator<Item = [f64; 2]> + Clone,
        memory: &mut SurfaceWorkspace,
        force: &mut dyn NodeForce,
    ) -> Result<(), TooRough> {
        loop {
            let mut unmade = Vec::new();
            let mut last: Option<Cell> = None;
            for at in path.clone() {
                if last.is_some_and(|cell| cell.contains(at)) {
                    continue;
                }
                let root = self.root(at).ok_or(TooRough)?;
                let node = self.descend(root, at);
                last = Some(match self.nodes[node] {
                    Node::Unmade(cell) => {
                        if !unmade.contains(&node) {
                            unmade.push(node);
                        }
                        cell
                    }
                    Node::Patch(index) => self.patches[index].cell,
                    Node::Halved { .. } => unreachable!("a node without children"),
                });
            }
            if unmade.is_empty() {
                return Ok(());
            }
            self.make(&unmade, memory, force)?;
        }
    }

    /// Turns unmade nodes into patches, or halves them.
    fn make(
        &mut self,
        unmade: &[usize],
        memory: &mut SurfaceWorkspace,
        force: &mut dyn NodeForce,
    ) -> Result<(), TooRough> {
        let SurfaceWorkspace { points, values } = memory;
        points.clear();
        let cells: Vec<(usize, Cell)> = unmade
            .iter()
            .filter_map(|&node| match self.nodes[node] {
                Node::Unmade(cell) => Some((node, cell)),
                _ => None,
            })
            .collect();
        let grid = polynomial::nodes();
        let checks: [f64; CHECKS] = std::array::from_fn(|k| {
            // Every other gap between nodes, the outermost included.
            let k = (k * (NODES - 2)) / (CHECKS - 1);
            0.5 * (grid[k] + grid[k + 1])
        });
        for (_, cell) in &cells {
            lattice(cell, &grid, points);
            lattice(cell, &checks, points);
        }
        values.resize(points.len(), 0.0);
        force.values_into(points, values);
        self.evaluations += points.len();
        for ((node, cell), values) in cells.iter().zip(values.chunks_exact(PATCH_POINTS)) {
            let (at_nodes, at_checks) = values.split_at(PATCH_NODES);
            let terms = self.interpolation.terms(at_nodes);
            let expected = |k: usize| value(&terms, checks[k / CHECKS], checks[k % CHECKS]);
            let error = at_checks.iter().enumerate().map(|(k, v)| (v - expected(k)).abs());
            let error =
                error.fold(0.0, |worst: f64, e| if e > worst || e.is_nan() { e } else { worst });
            if error <= self.fidelity.error_mn {
                self.nodes[*node] = Node::Patch(self.patches.len());
                let half = cell.half_width();
                self.patches.push(Patch {
                    terms,
                    sums: Terms::ZERO,
                    cell: *cell,
                    middle: cell.middle(),
                    per_unit: half.map(f64::recip),
                    visited: false,
                });
                continue;
            }
            let small = cell.depth >= DEEPEST || !error.is_finite();
            if small || self.patches.len() + self.nodes.len() / 2 > self.fidelity.most_patches {
                return Err(TooRough);
            }
            let [by_x, by_v] = polynomial::highest(&terms);
            let along = usize::from(by_v > by_x);
            let children = self.nodes.len();
            self.nodes.extend(cell.halves(along).map(Node::Unmade));
            self.nodes[*node] = Node::Halved { along, at: cell.middle()[along], children };
        }
        Ok(())
    }

    /// Leaves in the memory the nodes of the patches that cotangents have come to, and the cotangents of the force there.
    pub(crate) fn cotangents_into(&self, memory: &mut SurfaceWorkspace) {
        let SurfaceWorkspace { points, values } = memory;
        points.clear();
        values.clear();
        let grid = polynomial::nodes();
        for patch in self.patches.iter().filter(|p| p.visited) {
            lattice(&patch.cell, &grid, points);
            let from = values.len();
            values.resize(from + PATCH_NODES, 0.0);
            self.interpolation.pull_back(&patch.sums, &mut values[from..]);
        }
    }
}

/// Points of a cell on the product of a grid of [−1, 1] with itself, row by row of equal x.
fn lattice(cell: &Cell, grid: &[f64], points: &mut Vec<[f64; 2]>) {
    let (middle, half) = (cell.middle(), cell.half_width());
    for x in grid {
        for v in grid {
            points.push([middle[0] + half[0] * x, middle[1] + half[1] * v]);
        }
    }
}

fn value(terms: &Terms, x: f64, v: f64) -> f64 {
    let row = |row: &[f64]| row.iter().rev().fold(0.0, |sum, c| sum * v + c);
    terms.0.chunks_exact(NODES).rev().fold(0.0, |sum, r| sum * x + row(r))
}
