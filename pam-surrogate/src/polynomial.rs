//! Polynomials of a patch: interpolation at Chebyshev nodes, and evaluation by whole vectors.
//!
//! In the coordinates `X, V ∈ [−1, 1]` of a patch the force is `Σ c_ij Xⁱ Vʲ`. A row of coefficients (equal i) is one or a
//! few vectors, so Horner's scheme along X runs on all powers of V at once.

use pulp::Simd;

/// Nodes, and coefficients, along each direction of a patch.
pub(crate) const NODES: usize = 16;
/// Nodes of a patch.
pub(crate) const PATCH_NODES: usize = NODES * NODES;

/// Numbers of the terms `Xⁱ Vʲ` of a patch, row by row of equal i.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Terms(pub(crate) [f64; PATCH_NODES]);

impl Terms {
    pub(crate) const ZERO: Self = Self([0.0; PATCH_NODES]);
}

#[derive(Clone, Copy)]
#[repr(align(64))]
struct Row([f64; NODES]);

/// The Chebyshev–Lobatto nodes `cos(π k/7)` in increasing order. They include the ends, so that neighbours agree on their
/// common border.
pub(crate) fn nodes() -> [f64; NODES] {
    std::array::from_fn(|k| {
        let k = (NODES - 1 - k) as f64;
        (std::f64::consts::PI * k / (NODES - 1) as f64).cos()
    })
}

/// From values at [`nodes`] to coefficients of powers: column k holds those of the k-th Lagrange polynomial.
#[derive(Debug, Clone)]
pub(crate) struct Interpolation {
    /// `[power][node]`.
    matrix: [[f64; NODES]; NODES],
}

impl Interpolation {
    pub(crate) fn new() -> Self {
        let t = nodes();
        let mut matrix = [[0.0; NODES]; NODES];
        for k in 0..NODES {
            // Π_{j≠k} (X − t_j)/(t_k − t_j), multiplied out factor by factor.
            let mut product = [0.0; NODES];
            product[0] = 1.0;
            for (degree, j) in (0..NODES).filter(|&j| j != k).enumerate() {
                let scale = 1.0 / (t[k] - t[j]);
                for power in (0..=degree + 1).rev() {
                    let below = if power > 0 { product[power - 1] } else { 0.0 };
                    product[power] = (below - t[j] * product[power]) * scale;
                }
            }
            for (row, value) in matrix.iter_mut().zip(product) {
                row[k] = value;
            }
        }
        Self { matrix }
    }

    /// Coefficients from values at the nodes, row by row of equal X.
    pub(crate) fn terms(&self, values: &[f64]) -> Terms {
        let m = &self.matrix;
        let mut along_v = [[0.0; NODES]; NODES];
        for (row, values) in along_v.iter_mut().zip(values.chunks_exact(NODES)) {
            for (j, out) in row.iter_mut().enumerate() {
                *out = m[j].iter().zip(values).map(|(m, v)| m * v).sum();
            }
        }
        let mut terms = Terms::ZERO;
        for (out, m) in terms.0.chunks_exact_mut(NODES).zip(m) {
            for (weight, row) in m.iter().zip(&along_v) {
                for (out, value) in out.iter_mut().zip(row) {
                    *out += weight * value;
                }
            }
        }
        terms
    }

    /// The transpose of [`terms`](Self::terms): adds to cotangents of the values those of the coefficients.
    pub(crate) fn pull_back(&self, terms: &Terms, values: &mut [f64]) {
        let m = &self.matrix;
        let mut along_x = [[0.0; NODES]; NODES];
        for (i, row) in terms.0.chunks_exact(NODES).enumerate() {
            for (out, weight) in along_x.iter_mut().zip(&m[i]) {
                for (out, value) in out.iter_mut().zip(row) {
                    *out += weight * value;
                }
            }
        }
        for (row, values) in along_x.iter().zip(values.chunks_exact_mut(NODES)) {
            for (j, value) in row.iter().enumerate() {
                for (out, weight) in values.iter_mut().zip(&m[j]) {
                    *out += weight * value;
                }
            }
        }
    }
}

/// Sizes of the highest Chebyshev coefficients along X and along V: the one along which it is larger is worth a split.
pub(crate) fn highest(terms: &Terms) -> [f64; 2] {
    let last = NODES - 1;
    let along_x = terms.0[last * NODES..].iter().map(|c| c.abs()).sum();
    let along_v = terms.0.iter().skip(last).step_by(NODES).map(|c| c.abs()).sum();
    [along_x, along_v]
}

#[inline(always)]
fn powers(v: f64) -> Row {
    // Short chains of products.
    let v2 = v * v;
    let v4 = v2 * v2;
    let low = [1.0, v, v2, v * v2, v4, v * v4, v2 * v4, v * v2 * v4];
    let v8 = v4 * v4;
    let mut row = [0.0; NODES];
    for (j, low) in low.into_iter().enumerate() {
        row[j] = low;
        row[j + 8] = v8 * low;
    }
    Row(row)
}

/// The polynomial at (x, v).
#[inline(always)]
pub(crate) fn value<S: Simd>(simd: S, terms: &Terms, x: f64, v: f64) -> f64 {
    let rows = S::as_simd_f64s(&terms.0).0;
    let powers = powers(v);
    let powers = S::as_simd_f64s(&powers.0).0;
    let count = powers.len();
    // Even and odd powers of x apart: two chains of half the length.
    let (at, square) = (simd.splat_f64s(x), simd.splat_f64s(x * x));
    let mut sum = simd.splat_f64s(0.0);
    for (k, &power) in powers.iter().enumerate() {
        let mut odd = rows[(NODES - 1) * count + k];
        let mut even = rows[(NODES - 2) * count + k];
        for i in (0..NODES - 2).rev().step_by(2) {
            odd = simd.mul_add_f64s(odd, square, rows[i * count + k]);
            even = simd.mul_add_f64s(even, square, rows[(i - 1) * count + k]);
        }
        let row = simd.mul_add_f64s(odd, at, even);
        sum = simd.mul_add_f64s(row, power, sum);
    }
    simd.reduce_sum_f64s(sum)
}

/// The polynomial at (x, v) with its derivatives along x and v.
#[inline(always)]
pub(crate) fn value_and_slopes<S: Simd>(simd: S, terms: &Terms, x: f64, v: f64) -> [f64; 3] {
    let rows = S::as_simd_f64s(&terms.0).0;
    let powers = powers(v);
    let mut slopes = Row([0.0; NODES]);
    for j in 1..NODES {
        slopes.0[j] = j as f64 * powers.0[j - 1];
    }
    let powers = S::as_simd_f64s(&powers.0).0;
    let slopes = S::as_simd_f64s(&slopes.0).0;
    let count = powers.len();
    // With P(x) = E(x²) + x O(x²): P' = O + 2x (E' + x O').
    let (at, square) = (simd.splat_f64s(x), simd.splat_f64s(x * x));
    let twice = simd.splat_f64s(2.0 * x);
    let zero = simd.splat_f64s(0.0);
    let (mut sum, mut along_x, mut along_v) = (zero, zero, zero);
    for (k, (&power, &slope)) in powers.iter().zip(slopes).enumerate() {
        let mut odd = rows[(NODES - 1) * count + k];
        let mut even = rows[(NODES - 2) * count + k];
        let (mut odd_slope, mut even_slope) = (zero, zero);
        for i in (0..NODES - 2).rev().step_by(2) {
            odd_slope = simd.mul_add_f64s(odd_slope, square, odd);
            even_slope = simd.mul_add_f64s(even_slope, square, even);
            odd = simd.mul_add_f64s(odd, square, rows[i * count + k]);
            even = simd.mul_add_f64s(even, square, rows[(i - 1) * count + k]);
        }
        let row = simd.mul_add_f64s(odd, at, even);
        let inner = simd.mul_add_f64s(odd_slope, at, even_slope);
        let derivative = simd.mul_add_f64s(inner, twice, odd);
        sum = simd.mul_add_f64s(row, power, sum);
        along_x = simd.mul_add_f64s(derivative, power, along_x);
        along_v = simd.mul_add_f64s(row, slope, along_v);
    }
    // Not by a closure: those are compiled without the instruction set.
    [simd.reduce_sum_f64s(sum), simd.reduce_sum_f64s(along_x), simd.reduce_sum_f64s(along_v)]
}

/// Adds `weight · Xⁱ Vʲ` to the cotangent of each coefficient.
#[inline(always)]
pub(crate) fn accumulate<S: Simd>(simd: S, sums: &mut Terms, weight: f64, x: f64, v: f64) {
    let rows = S::as_mut_simd_f64s(&mut sums.0).0;
    let powers = powers(v);
    let powers = S::as_simd_f64s(&powers.0).0;
    let mut scale = weight;
    for row in rows.chunks_exact_mut(powers.len()) {
        let scaled = simd.splat_f64s(scale);
        for (sum, &power) in row.iter_mut().zip(powers) {
            *sum = simd.mul_add_f64s(scaled, power, *sum);
        }
        scale *= x;
    }
}
