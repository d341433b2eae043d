//! A patch cut into equal cells, each with a polynomial of its own.
//!
//! The network is interpolated at as few nodes as possible: by one polynomial of high degree for a whole patch. That
//! polynomial takes long to evaluate, so it is written out as polynomials of degree seven on cells so small that they agree
//! with it. This is a linear map of the values at the nodes, and its transpose takes cotangents of all coefficients back to
//! the nodes.

use crate::chebyshev;
use crate::polynomial::{self, NODES, TERMS, Terms};
use pam_core::simd::arch;
use pulp::{Simd, WithSimd};

/// Number of nodes on a probe line, and largest number of nodes of a patch along one direction.
pub(crate) const LINE: usize = 49;
/// Most cells along one direction.
const MOST_CELLS: usize = 96;
/// Gaps between the nodes of a cell in whose middles it is compared with the patch.
const GAPS: [usize; 3] = [0, 3, 5];
/// Every so many rows of nodes are compared.
const ROWS_APART: usize = 4;

/// Matrices that all patches share.
#[derive(Debug, Clone)]
pub(crate) struct CellScheme {
    /// Nodes of a cell.
    nodes: Vec<f64>,
    /// Coefficients of powers from values at the nodes.
    powers: [[f64; NODES]; NODES],
    /// Middles of gaps, and the weights of the nodes there.
    checks: Vec<(f64, [f64; NODES])>,
    /// Nodes of a probe line, and the transform of values there.
    pub(crate) line: Vec<f64>,
    pub(crate) transform: chebyshev::Transform,
}

impl CellScheme {
    pub(crate) fn new() -> Self {
        let nodes = chebyshev::nodes(NODES);
        let checks = GAPS.map(|k| {
            let at = 0.5 * (nodes[k] + nodes[k + 1]);
            let mut weights = [0.0; NODES];
            chebyshev::weights_into(&nodes, at, &mut weights);
            (at, weights)
        });
        Self {
            powers: polynomial::powers_from_values(),
            checks: checks.to_vec(),
            nodes,
            line: chebyshev::nodes(LINE),
            transform: chebyshev::Transform::new(LINE),
        }
    }
}

/// From values at the nodes of a patch along one direction to coefficients along it in each cell.
#[derive(Debug, Clone)]
struct Direction {
    cells: usize,
    nodes: usize,
    /// `[cell][power][node]`.
    coefficients: Vec<f64>,
}

/// Where a coordinate of a cell lies in [−1, 1] across `cells` of them.
fn across(cells: usize, cell: usize, at: f64) -> f64 {
    (2.0 * cell as f64 + 1.0 + at) / cells as f64 - 1.0
}

impl Direction {
    fn new(scheme: &CellScheme, nodes: &[f64], cells: usize) -> Self {
        let count = nodes.len();
        let mut coefficients = vec![0.0; cells * NODES * count];
        let mut weights = vec![0.0; count];
        for (cell, rows) in coefficients.chunks_exact_mut(NODES * count).enumerate() {
            for (k, &at) in scheme.nodes.iter().enumerate() {
                chebyshev::weights_into(nodes, across(cells, cell, at), &mut weights);
                for (row, powers) in rows.chunks_exact_mut(count).zip(&scheme.powers) {
                    for (out, weight) in row.iter_mut().zip(&weights) {
                        *out += powers[k] * weight;
                    }
                }
            }
        }
        Self { cells, nodes: count, coefficients }
    }

    /// The rows of one cell, `[power][node]`.
    fn of(&self, cell: usize) -> &[f64] {
        let len = NODES * self.nodes;
        &self.coefficients[cell * len..(cell + 1) * len]
    }
}

/// The smallest number of cells that follow the interpolants of `lines` of values at nodes within an error; `None` if it
/// would be too large.
fn cells_within(
    scheme: &CellScheme,
    nodes: &[f64],
    lines: &[Vec<f64>],
    error: f64,
) -> Option<usize> {
    // As many coefficients in all as the patch has.
    let mut cells = nodes.len().div_ceil(NODES);
    while cells <= MOST_CELLS {
        if follow(scheme, nodes, lines, error, cells) {
            return Some(cells);
        }
        cells += 1 + cells / 4;
    }
    None
}

/// Whether so many cells follow the interpolants of `lines` of values at nodes within an error.
fn follow(
    scheme: &CellScheme,
    nodes: &[f64],
    lines: &[Vec<f64>],
    error: f64,
    cells: usize,
) -> bool {
    let count = nodes.len();
    let mut own = vec![0.0; NODES * count];
    let mut miss = vec![0.0; count];
    (0..cells).all(|cell| {
        for (&node, weights) in scheme.nodes.iter().zip(own.chunks_exact_mut(count)) {
            chebyshev::weights_into(nodes, across(cells, cell, node), weights);
        }
        scheme.checks.iter().all(|(at, shares)| {
            chebyshev::weights_into(nodes, across(cells, cell, *at), &mut miss);
            for (share, weights) in shares.iter().zip(own.chunks_exact(count)) {
                miss.iter_mut().zip(weights).for_each(|(m, w)| *m -= share * w);
            }
            let off = |line: &Vec<f64>| line.iter().zip(&miss).map(|(v, m)| v * m).sum::<f64>();
            lines.iter().all(|line| off(line).abs() <= error)
        })
    })
}

/// The cells of a patch.
#[derive(Debug, Clone)]
pub(crate) struct Cells {
    along: [Direction; 2],
    /// Row by row of equal x.
    pub(crate) terms: Vec<Terms>,
    pub(crate) sums: Vec<Terms>,
}

impl Cells {
    /// Cells that follow the interpolant of values at the products of nodes, row by row of equal x, within an error. `None`
    /// if there would have to be too many.
    pub(crate) fn new(
        scheme: &CellScheme,
        nodes: [&[f64]; 2],
        values: &[f64],
        error: f64,
    ) -> Option<Self> {
        let [by_x, by_v] = nodes.map(<[f64]>::len);
        let along_x: Vec<Vec<f64>> = (0..by_v)
            .step_by(ROWS_APART)
            .map(|v| (0..by_x).map(|x| values[x * by_v + v]).collect())
            .collect();
        let along_v: Vec<Vec<f64>> =
            values.chunks_exact(by_v).step_by(ROWS_APART).map(<[f64]>::to_vec).collect();
        // Errors of both directions add up.
        let along = [
            Direction::new(
                scheme,
                nodes[0],
                cells_within(scheme, nodes[0], &along_x, 0.5 * error)?,
            ),
            Direction::new(
                scheme,
                nodes[1],
                cells_within(scheme, nodes[1], &along_v, 0.5 * error)?,
            ),
        ];
        let count = along[0].cells * along[1].cells;
        let mut cells =
            Self { along, terms: vec![Terms::ZERO; count], sums: vec![Terms::ZERO; count] };
        arch().dispatch(Write { cells: &mut cells, values });
        Some(cells)
    }

    /// Cells along each direction.
    pub(crate) fn counts(&self) -> [usize; 2] {
        [self.along[0].cells, self.along[1].cells]
    }

    /// Adds to cotangents of the values at the nodes those of the coefficients.
    pub(crate) fn pull_back(&self, values: &mut [f64]) {
        arch().dispatch(PullBack { cells: self, values });
    }
}

struct Write<'a> {
    cells: &'a mut Cells,
    values: &'a [f64],
}

impl WithSimd for Write<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Cells { along: [x, v], terms, .. } = self.cells;
        // Coefficients along v, turned so that powers lie side by side.
        let mut turned = vec![[0.0; NODES]; v.cells * v.nodes];
        for (cell, rows) in turned.chunks_exact_mut(v.nodes).enumerate() {
            for (power, row) in v.of(cell).chunks_exact(v.nodes).enumerate() {
                for (out, c) in rows.iter_mut().zip(row) {
                    out[power] = *c;
                }
            }
        }
        // Of one column of cells: powers of X, at the nodes along v.
        let mut along_x = vec![0.0; NODES * v.nodes];
        for (cell, terms) in terms.chunks_exact_mut(v.cells).enumerate() {
            along_x.fill(0.0);
            for (out, weights) in
                along_x.chunks_exact_mut(v.nodes).zip(x.of(cell).chunks_exact(x.nodes))
            {
                for (weight, row) in weights.iter().zip(self.values.chunks_exact(v.nodes)) {
                    for (out, value) in out.iter_mut().zip(row) {
                        *out += weight * value;
                    }
                }
            }
            for (terms, turned) in terms.iter_mut().zip(turned.chunks_exact(v.nodes)) {
                let mut sums = [[0.0; NODES]; NODES];
                for (node, weights) in turned.iter().enumerate() {
                    for (power, sums) in sums.iter_mut().enumerate() {
                        let value = along_x[power * v.nodes + node];
                        for (sum, weight) in sums.iter_mut().zip(weights) {
                            *sum += weight * value;
                        }
                    }
                }
                for (out, row) in terms.0.chunks_exact_mut(NODES).zip(&sums) {
                    out.copy_from_slice(row);
                }
            }
        }
    }
}

struct PullBack<'a> {
    cells: &'a Cells,
    values: &'a mut [f64],
}

impl WithSimd for PullBack<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) {
        let Cells { along: [x, v], sums, .. } = self.cells;
        let mut along_x = vec![0.0; NODES * v.nodes];
        for (cell, sums) in sums.chunks_exact(v.cells).enumerate() {
            let mut any = false;
            along_x.fill(0.0);
            for (at, sums) in sums.iter().enumerate() {
                if sums.0 == [0.0; TERMS] {
                    continue;
                }
                any = true;
                let rows = v.of(at);
                for (out, sums) in along_x.chunks_exact_mut(v.nodes).zip(sums.0.chunks_exact(NODES))
                {
                    for (weights, sum) in rows.chunks_exact(v.nodes).zip(sums) {
                        for (out, weight) in out.iter_mut().zip(weights) {
                            *out += weight * sum;
                        }
                    }
                }
            }
            if !any {
                continue;
            }
            for (row, weights) in
                along_x.chunks_exact(v.nodes).zip(x.of(cell).chunks_exact(x.nodes))
            {
                for (weight, out) in weights.iter().zip(self.values.chunks_exact_mut(v.nodes)) {
                    for (out, value) in out.iter_mut().zip(row) {
                        *out += weight * value;
                    }
                }
            }
        }
    }
}
