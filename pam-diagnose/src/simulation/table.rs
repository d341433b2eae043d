//! The base model's force of one recording, as a table.

use crate::effects::Restoring;
use pam_core::{ForceInput, ForceModel, JointModel, Scalar, SealedMasses};
use rayon::prelude::*;

/// Distance of two nodes in x, mm.
const SPACING_MM: f64 = 0.1;
/// Distance of two nodes in ẋ, mm/s.
///
/// Networks bend more often along ẋ than along x: with the published weights 1 mm/s leaves errors of
/// 0.027 mm in a 70 s run, 0.25 mm/s of 0.002 mm.
const SPACING_MM_S: f64 = 0.25;
/// The slopes along the masses vary slowly; they are worked out in every so many columns.
const SLOPE_COLUMNS: usize = 4;
/// Relative change of a mass for its derivatives.
const MASS_STEP: f64 = 0.04;
/// Most nodes in one direction; beyond, the spacing grows.
const MOST_NODES: usize = 1000;

/// The restoring force over (x, ẋ) at the sealed masses of one recording, bilinear between nodes, with
/// slopes and curvatures along both masses; beyond the table the last cell goes on straight.
///
/// For `f'' = 2 N/mm²` the interpolation errs by 2.5 mN at a spacing of 0.1 mm, some 20 nm of displacement.
#[derive(Debug, Clone)]
pub struct ForceTable {
    x_start: f64,
    v_start: f64,
    x_spacing: f64,
    v_spacing: f64,
    columns: usize,
    rows: usize,
    masses: SealedMasses,
    /// Force, slopes and curvatures along m_f and m_e; row by row of equal x.
    nodes: Vec<[f64; 5]>,
}

impl ForceTable {
    /// Tabulates a model's force where `|x − middle|` and `|ẋ|` stay in the given ranges.
    #[must_use]
    pub fn new<F: ForceModel<f64> + Sync>(
        model: &JointModel<f64, F>,
        masses: SealedMasses,
        x_range: [f64; 2],
        v_range: [f64; 2],
    ) -> Self {
        let axis = |range: [f64; 2], spacing: f64| {
            let cells = ((range[1] - range[0]) / spacing).ceil().max(1.0);
            let cells = cells.min((MOST_NODES - 1) as f64);
            ((range[1] - range[0]) / cells, cells as usize + 1)
        };
        let (x_spacing, rows) = axis(x_range, SPACING_MM);
        let (v_spacing, columns) = axis(v_range, SPACING_MM_S);
        let force = &model.force;
        let mut nodes = vec![[0.0; 5]; rows * columns];
        nodes.par_chunks_mut(columns).enumerate().for_each(|(i, row)| {
            let mut work = vec![0.0; force.work_len()];
            let mut at = |j: usize, flexor: f64, extensor: f64| {
                let input = ForceInput {
                    displacement_mm: x_range[0] + x_spacing * i as f64,
                    velocity_mm_s: v_range[0] + v_spacing * j as f64,
                    mass_flexor_g: masses.flexor_g * flexor,
                    mass_extensor_g: masses.extensor_g * extensor,
                };
                force.restoring_force_mn(&input, &mut work)
            };
            for (j, node) in row.iter_mut().enumerate() {
                node[0] = at(j, 1.0, 1.0);
            }
            let mut known = 0;
            for j in (0..columns).filter(|j| j % SLOPE_COLUMNS == 0 || j + 1 == columns) {
                let centre = row[j][0];
                let mut along = |change: [f64; 2], mass: f64| {
                    let up = at(j, 1.0 + change[0], 1.0 + change[1]);
                    let down = at(j, 1.0 - change[0], 1.0 - change[1]);
                    let step = MASS_STEP * mass;
                    [(up - down) / (2.0 * step), (up - 2.0 * centre + down) / (step * step)]
                };
                let flexor = along([MASS_STEP, 0.0], masses.flexor_g);
                let extensor = along([0.0, MASS_STEP], masses.extensor_g);
                row[j] = [centre, flexor[0], extensor[0], flexor[1], extensor[1]];
                for between in known + 1..j {
                    let share = (between - known) as f64 / (j - known) as f64;
                    for q in 1..5 {
                        row[between][q] = row[known][q] + share * (row[j][q] - row[known][q]);
                    }
                }
                known = j;
            }
        });
        Self {
            x_start: x_range[0],
            v_start: v_range[0],
            x_spacing,
            v_spacing,
            columns,
            rows,
            masses,
            nodes,
        }
    }

    /// The masses at which the table stands.
    #[must_use]
    pub fn masses(&self) -> SealedMasses {
        self.masses
    }

    /// The restoring force, mN, with `change_g` more air than the table's masses.
    #[inline]
    pub fn force_mn<S: Scalar>(&self, x: S, v: S, change_g: [S; 2]) -> S {
        let cell = |value: f64, start: f64, spacing: f64, nodes: usize| {
            let position = (value - start) / spacing;
            let whole = position.floor().clamp(0.0, (nodes - 2) as f64);
            (whole as usize, position - whole)
        };
        let (i, a) = cell(x.real(), self.x_start, self.x_spacing, self.rows);
        let (j, b) = cell(v.real(), self.v_start, self.v_spacing, self.columns);
        let low = &self.nodes[i * self.columns + j..];
        let high = &self.nodes[(i + 1) * self.columns + j..];
        let (n00, n01, n10, n11) = (&low[0], &low[1], &high[0], &high[1]);
        let blend = |k: usize| {
            let left = n00[k] + b * (n01[k] - n00[k]);
            let right = n10[k] + b * (n11[k] - n10[k]);
            left + a * (right - left)
        };
        let (d0, d1) = (change_g[0].real(), change_g[1].real());
        let (mut slope_0, mut slope_1) = (blend(1), blend(2));
        let mut value = blend(0);
        if d0 != 0.0 || d1 != 0.0 {
            let (c0, c1) = (blend(3), blend(4));
            value += d0 * (slope_0 + 0.5 * c0 * d0) + d1 * (slope_1 + 0.5 * c1 * d1);
            slope_0 += c0 * d0;
            slope_1 += c1 * d1;
        }
        if S::NDERIV == 0 {
            return S::constant(value);
        }
        let per_x = {
            let (bottom, top) = (n10[0] - n00[0], n11[0] - n01[0]);
            (bottom + b * (top - bottom)) / self.x_spacing
        };
        let per_v = {
            let (left, right) = (n01[0] - n00[0], n11[0] - n10[0]);
            (left + a * (right - left)) / self.v_spacing
        };
        // What has no real part carries the derivatives alone.
        let tail = |s: S| s - S::constant(s.real());
        S::constant(value)
            + tail(x).scaled(per_x)
            + tail(v).scaled(per_v)
            + tail(change_g[0]).scaled(slope_0)
            + tail(change_g[1]).scaled(slope_1)
    }
}

/// The table with a given change of the air.
#[derive(Debug, Clone, Copy)]
pub struct Air<'a, S> {
    /// The table.
    pub table: &'a ForceTable,
    /// Air beyond the table's masses, g.
    pub change_g: [S; 2],
}

impl<S: Scalar> Restoring<S> for Air<'_, S> {
    #[inline]
    fn restoring_mn(&self, x: S, v: S) -> S {
        self.table.force_mn(x, v, self.change_g)
    }
}
