//! Polynomials of a cell: interpolation at Chebyshev nodes, and evaluation by whole vectors.
//!
//! In the coordinates `X, V ∈ [−1, 1]` of a cell the force is `Σ c_ij Xⁱ Vʲ`. A row of coefficients (equal i) is one or a
//! few vectors, so Horner's scheme along X runs on all powers of V at once.

use crate::chebyshev;
use pulp::Simd;

/// Nodes, and coefficients, along each direction of a cell.
pub(crate) const NODES: usize = 8;
/// Coefficients of a cell.
pub(crate) const TERMS: usize = NODES * NODES;

/// Numbers of the terms `Xⁱ Vʲ` of a cell, row by row of equal i.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Terms(pub(crate) [f64; TERMS]);

impl Terms {
    pub(crate) const ZERO: Self = Self([0.0; TERMS]);
}

#[derive(Clone, Copy)]
#[repr(align(64))]
struct Row([f64; NODES]);

/// Places of the powers of V that have the factor V, V² or V⁴; and those that do not.
const WITH: [Row; 3] = [
    Row([0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0]),
    Row([0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0]),
    Row([0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]),
];
const WITHOUT: [Row; 3] = [
    Row([1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0, 0.0]),
    Row([1.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0]),
    Row([1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0]),
];

/// From values at the nodes to coefficients of powers, `[power][node]`: column k holds those of the k-th Lagrange
/// polynomial.
pub(crate) fn powers_from_values() -> [[f64; NODES]; NODES] {
    let t = chebyshev::nodes(NODES);
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
    matrix
}

/// The polynomial at (x, v) with its derivatives along x and v.
#[inline(always)]
pub(crate) fn value_and_slopes<S: Simd>(simd: S, terms: &Terms, x: f64, v: f64) -> [f64; 3] {
    let rows = S::as_simd_f64s(&terms.0).0;
    // Vʲ as a product of [1 or V] [1 or V²] [1 or V⁴]: no numbers move between lanes.
    let v2 = v * v;
    let v4 = v2 * v2;
    let factors = [simd.splat_f64s(v), simd.splat_f64s(v2), simd.splat_f64s(v4)];
    let rates = [simd.splat_f64s(2.0 * v), simd.splat_f64s(4.0 * v * v2)];
    // With P(x) = E(x²) + x O(x²): P' = O + 2x (E' + x O').
    let (at, square) = (simd.splat_f64s(x), simd.splat_f64s(x * x));
    let twice = simd.splat_f64s(2.0 * x);
    let zero = simd.splat_f64s(0.0);
    let (mut sum, mut along_x, mut along_v) = (zero, zero, zero);
    let [with0, with1, with2] = [0, 1, 2].map(|k| S::as_simd_f64s(&WITH[k].0).0);
    let [without0, without1, without2] = [0, 1, 2].map(|k| S::as_simd_f64s(&WITHOUT[k].0).0);
    let count = with0.len();
    for k in 0..count {
        let first = simd.mul_add_f64s(factors[0], with0[k], without0[k]);
        let second = simd.mul_add_f64s(factors[1], with1[k], without1[k]);
        let third = simd.mul_add_f64s(factors[2], with2[k], without2[k]);
        let low = simd.mul_f64s(first, second);
        let power = simd.mul_f64s(low, third);
        let of_low = simd.mul_add_f64s(
            with0[k],
            second,
            simd.mul_f64s(first, simd.mul_f64s(rates[0], with1[k])),
        );
        let slope =
            simd.mul_add_f64s(of_low, third, simd.mul_f64s(low, simd.mul_f64s(rates[1], with2[k])));
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
    let v2 = v * v;
    let factors = [simd.splat_f64s(v), simd.splat_f64s(v2), simd.splat_f64s(v2 * v2)];
    let count = rows.len() / NODES;
    for k in 0..count {
        let mut power = simd.splat_f64s(weight);
        for (f, factor) in factors.into_iter().enumerate() {
            let with = S::as_simd_f64s(&WITH[f].0).0[k];
            let without = S::as_simd_f64s(&WITHOUT[f].0).0[k];
            power = simd.mul_f64s(power, simd.mul_add_f64s(factor, with, without));
        }
        let at = simd.splat_f64s(x);
        for i in 0..NODES {
            let sum = &mut rows[i * count + k];
            *sum = simd.add_f64s(*sum, power);
            power = simd.mul_f64s(power, at);
        }
    }
}
