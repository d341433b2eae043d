//! The base model's force of one recording, as a table.

use super::base::{BaseForce, SealedForce};
use crate::effects::Restoring;
use pam_core::{ForceModel, JointModel, Scalar, SealedMasses};
use pam_surrogate::PointForces;
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
/// slopes and curvatures along both masses.
///
/// Beyond the table the force is extrapolated linearly with the table's mean stiffness and mean damping, neither of them negative. A network is
/// not trained there, and a simulation would diverge where its force decreases.
///
/// For `f'' = 2 N/mm²` and nodes 0.1 mm apart the interpolation errs by 1.7 mN at most, some 15 nm of displacement, and by nothing on
/// the average.
#[derive(Debug, Clone)]
pub struct ForceTable {
    /// First and last node along x (mm) and ẋ (mm/s).
    ranges: [[f64; 2]; 2],
    /// Nodes per mm.
    per_x: f64,
    /// Nodes per mm/s.
    per_v: f64,
    columns: usize,
    rows: usize,
    masses: SealedMasses,
    /// Force, row by row of equal x.
    values: Vec<f64>,
    /// Slopes along m_f and m_e, curvatures along both, in every [`SLOPE_COLUMNS`]-th column.
    slopes: Vec<[f64; 4]>,
    slope_columns: usize,
    /// Mean slopes along x (mN/mm) and ẋ (mN s/mm), for extrapolation beyond the table.
    beyond: [f64; 2],
}

impl ForceTable {
    /// Tabulates a model's force where x and ẋ stay in the given ranges.
    #[must_use]
    pub fn new<F: ForceModel<f64> + Sync>(
        model: &JointModel<f64, F>,
        masses: SealedMasses,
        x_range: [f64; 2],
        v_range: [f64; 2],
    ) -> Self {
        let axis = |range: [f64; 2], spacing: f64, multiple: usize| {
            let cells = ((range[1] - range[0]) / spacing).ceil().max(1.0);
            let cells = (cells.min((MOST_NODES - 1) as f64) as usize).next_multiple_of(multiple);
            ((range[1] - range[0]) / cells as f64, cells + 1)
        };
        let (x_spacing, rows) = axis(x_range, SPACING_MM, 1);
        let (v_spacing, columns) = axis(v_range, SPACING_MM_S, SLOPE_COLUMNS);
        let slope_columns = (columns - 1) / SLOPE_COLUMNS + 1;
        let forces = PointForces::new(&model.force);
        let mut values = vec![0.0; rows * columns];
        let mut slopes = vec![[0.0; 4]; rows * slope_columns];
        let value_rows = values.par_chunks_mut(columns);
        let both = value_rows.zip(slopes.par_chunks_mut(slope_columns)).enumerate();
        let changed = [0, 1].map(|muscle| {
            [1.0 + MASS_STEP, 1.0 - MASS_STEP].map(|factor| {
                let SealedMasses { mut flexor_g, mut extensor_g } = masses;
                *if muscle == 0 { &mut flexor_g } else { &mut extensor_g } *= factor;
                SealedMasses { flexor_g, extensor_g }
            })
        });
        let steps_g = [masses.flexor_g, masses.extensor_g].map(|mass| MASS_STEP * mass);
        both.for_each_init(
            || (forces.memory(), [0, 1].map(|_| vec![0.0; slope_columns])),
            |(memory, [up, down]), (i, (row, slope_row))| {
                let x = x_range[0] + x_spacing * i as f64;
                let points: Vec<[f64; 2]> =
                    (0..columns).map(|j| [x, v_range[0] + v_spacing * j as f64]).collect();
                forces.values_into(masses, &points, row, memory);
                let points: Vec<[f64; 2]> = points.into_iter().step_by(SLOPE_COLUMNS).collect();
                for (muscle, ([more, less], step)) in changed.into_iter().zip(steps_g).enumerate() {
                    forces.values_into(more, &points, up, memory);
                    forces.values_into(less, &points, down, memory);
                    for (k, slope) in slope_row.iter_mut().enumerate() {
                        let centre = row[k * SLOPE_COLUMNS];
                        slope[muscle] = (up[k] - down[k]) / (2.0 * step);
                        slope[2 + muscle] = (up[k] - 2.0 * centre + down[k]) / (step * step);
                    }
                }
            },
        );
        without_bias(&mut values, columns);
        let (per_x, per_v) = (1.0 / x_spacing, 1.0 / v_spacing);
        let beyond = mean_slopes(&values, columns, [per_x, per_v]);
        Self {
            ranges: [x_range, v_range],
            per_x,
            per_v,
            columns,
            rows,
            masses,
            values,
            slopes,
            slope_columns,
            beyond,
        }
    }

    /// The same table at other masses, by its slopes and curvatures.
    #[must_use]
    pub(crate) fn with_masses(&self, masses: SealedMasses) -> Self {
        let d =
            [masses.flexor_g - self.masses.flexor_g, masses.extensor_g - self.masses.extensor_g];
        let mut other = Self { masses, ..self.clone() };
        let added = |node: &[f64; 4]| {
            d[0] * (node[0] + 0.5 * node[2] * d[0]) + d[1] * (node[1] + 0.5 * node[3] * d[1])
        };
        let rows = other.values.chunks_exact_mut(self.columns);
        for (row, nodes) in rows.zip(self.slopes.chunks_exact(self.slope_columns)) {
            let at_nodes: Vec<f64> = nodes.iter().map(added).collect();
            for (j, value) in row.iter_mut().enumerate() {
                let k = (j / SLOPE_COLUMNS).min(self.slope_columns - 2);
                let share = j as f64 / SLOPE_COLUMNS as f64 - k as f64;
                *value += at_nodes[k] + share * (at_nodes[k + 1] - at_nodes[k]);
            }
        }
        for node in &mut other.slopes {
            node[0] += d[0] * node[2];
            node[1] += d[1] * node[3];
        }
        other.beyond = mean_slopes(&other.values, self.columns, [self.per_x, self.per_v]);
        other
    }

    /// The masses at which the table stands.
    #[must_use]
    pub fn masses(&self) -> SealedMasses {
        self.masses
    }

    /// The restoring force, mN, with `change_g` more air than the table's masses.
    #[inline(always)]
    pub fn force_mn<S: Scalar>(&self, x: S, v: S, change_g: [S; 2]) -> S {
        let [flexor, extensor] = &change_g;
        let air = [flexor.real(), extensor.real()];
        let (value, slopes) = self.with_slopes([x.real(), v.real()], air, S::NDERIV > 0);
        S::with_slopes(value, [&x, &v, flexor, extensor], slopes)
    }

    /// The force inside the table and, if `asked`, its slopes along displacement, velocity and both masses.
    #[inline(always)]
    fn inside(&self, [x, v]: [f64; 2], [d0, d1]: [f64; 2], asked: bool) -> (f64, [f64; 4]) {
        let cell = |value: f64, start: f64, per: f64, nodes: usize| {
            let position = (value - start) * per;
            // Truncation is the floor of what is not negative.
            let whole = position.clamp(0.0, (nodes - 2) as f64) as usize;
            (whole, position - whole as f64)
        };
        let (i, a) = cell(x, self.ranges[0][0], self.per_x, self.rows);
        let (j, b) = cell(v, self.ranges[1][0], self.per_v, self.columns);
        let (low, high) = two_rows(&self.values, self.columns, i, j);
        let (n00, n01, n10, n11) = (low[0], low[1], high[0], high[1]);
        let left = n00 + b * (n01 - n00);
        let right = n10 + b * (n11 - n10);
        let mut value = left + a * (right - left);
        let same_air = d0 == 0.0 && d1 == 0.0;
        if !asked && same_air {
            return (value, [0.0; 4]);
        }
        let mut per_x = {
            let (bottom, top) = (n10 - n00, n11 - n01);
            bottom + b * (top - bottom)
        };
        let mut per_v = {
            let (left, right) = (n01 - n00, n11 - n10);
            left + a * (right - left)
        };
        // The force of additional air, node by node: a parabola along each mass.
        let k = (j / SLOPE_COLUMNS).min(self.slope_columns - 2);
        let c = (j as f64 + b) / SLOPE_COLUMNS as f64 - k as f64;
        let (low, high) = two_rows(&self.slopes, self.slope_columns, i, k);
        let blend = |q: usize| {
            let left = low[0][q] + c * (low[1][q] - low[0][q]);
            let right = high[0][q] + c * (high[1][q] - high[0][q]);
            left + a * (right - left)
        };
        let mut slopes = [blend(0), blend(1)];
        if !same_air {
            let added = |node: &[f64; 4]| {
                d0 * (node[0] + 0.5 * node[2] * d0) + d1 * (node[1] + 0.5 * node[3] * d1)
            };
            let (a00, a01, a10, a11) =
                (added(&low[0]), added(&low[1]), added(&high[0]), added(&high[1]));
            let (below, above) = (a00 + c * (a01 - a00), a10 + c * (a11 - a10));
            value += below + a * (above - below);
            per_x += above - below;
            let (left, right) = (a01 - a00, a11 - a10);
            per_v += (left + a * (right - left)) / SLOPE_COLUMNS as f64;
            slopes[0] += blend(2) * d0;
            slopes[1] += blend(3) * d1;
        }
        (value, [per_x * self.per_x, per_v * self.per_v, slopes[0], slopes[1]])
    }

    /// As [`inside`](Self::inside), extrapolated beyond the table.
    #[inline(always)]
    fn with_slopes(&self, at: [f64; 2], air: [f64; 2], asked: bool) -> (f64, [f64; 4]) {
        let [x, v] = [0, 1].map(|k| at[k].clamp(self.ranges[k][0], self.ranges[k][1]));
        let (mut value, mut slopes) = self.inside([x, v], air, asked);
        for (k, outside) in [at[0] - x, at[1] - v].into_iter().enumerate() {
            if outside != 0.0 {
                value += self.beyond[k] * outside;
                slopes[k] = self.beyond[k];
            }
        }
        (value, slopes)
    }
}

/// Mean slopes of a table along x and ẋ, at least zero.
fn mean_slopes(values: &[f64], columns: usize, [per_x, per_v]: [f64; 2]) -> [f64; 2] {
    let rows = values.len() / columns;
    let (first, last) = (&values[..columns], &values[values.len() - columns..]);
    let along_x: f64 = last.iter().zip(first).map(|(last, first)| last - first).sum();
    let along_v: f64 = values.chunks_exact(columns).map(|row| row[columns - 1] - row[0]).sum();
    [
        (per_x * along_x / ((rows - 1) * columns) as f64).max(0.0),
        (per_v * along_v / ((columns - 1) * rows) as f64).max(0.0),
    ]
}

/// Takes from the values at the nodes what bilinear interpolation adds on the average: between nodes at a distance of h a second
/// derivative f'' adds h² f''/12, a twelfth of the second difference. Left in, it would look like a change of the stiffness that
/// goes with the curvature of the force.
fn without_bias(values: &mut [f64], columns: usize) {
    let exact = values.to_vec();
    let rows = values.len() / columns;
    let second = |k: usize, step: usize| exact[k - step] - 2.0 * exact[k] + exact[k + step];
    for i in 0..rows {
        for j in 0..columns {
            let k = i * columns + j;
            let along_x = if i > 0 && i + 1 < rows { second(k, columns) } else { 0.0 };
            let along_v = if j > 0 && j + 1 < columns { second(k, 1) } else { 0.0 };
            values[k] -= (along_x + along_v) / 12.0;
        }
    }
}

/// Two neighbours in each of two rows of a table.
#[inline]
fn two_rows<T>(table: &[T], columns: usize, row: usize, column: usize) -> (&[T; 2], &[T; 2]) {
    let first = row * columns + column;
    let pair = |at: usize| table[at..].first_chunk().expect("a cell inside the table");
    (pair(first), pair(first + columns))
}

/// The table with a given change of the air.
#[derive(Debug, Clone, Copy)]
pub struct Air<'a, S> {
    /// The table.
    pub table: &'a ForceTable,
    /// Air beyond the table's masses, g.
    pub change_g: [S; 2],
}

impl<S: Scalar> BaseForce<S> for ForceTable {
    type Sealed<'a> = Air<'a, S>;

    #[inline]
    fn sealed(&self, air_g: [S; 2]) -> Air<'_, S> {
        let own = [self.masses.flexor_g, self.masses.extensor_g];
        Air { table: self, change_g: [0, 1].map(|i| air_g[i] - S::constant(own[i])) }
    }
}

impl<S: Scalar> Restoring<S> for Air<'_, S> {
    #[inline(always)]
    fn restoring_mn(&self, x: S, v: S) -> S {
        self.table.force_mn(x, v, self.change_g)
    }
}

impl<S: Scalar> SealedForce<S> for Air<'_, S> {
    /// All derivatives in one pass.
    #[inline(always)]
    fn acceleration(&self, [x, v]: [&S; 2], push_mn: &S, damping_kg_s: &S, per_kg: &S) -> S {
        let [flexor, extensor] = &self.change_g;
        let air = [flexor.real(), extensor.real()];
        let (velocity, damping, inverse) = (v.real(), damping_kg_s.real(), per_kg.real());
        let (restoring, [by_x, by_v, by_flexor, by_extensor]) =
            self.table.with_slopes([x.real(), velocity], air, S::NDERIV > 0);
        let force = push_mn.real() - restoring - velocity * damping;
        S::with_slopes(
            force * inverse,
            [x, v, flexor, extensor, push_mn, damping_kg_s, per_kg],
            [
                -by_x * inverse,
                -(by_v + damping) * inverse,
                -by_flexor * inverse,
                -by_extensor * inverse,
                inverse,
                -velocity * inverse,
                force,
            ],
        )
    }
}
