//! Interpolation of any degree at Chebyshev–Lobatto nodes of [−1, 1].
//!
//! The nodes include the ends, so that neighbours agree on their common border. Values between nodes follow from the
//! barycentric formula (Berrut and Trefethen 2004), which is stable at any degree.

use std::f64::consts::PI;

/// The nodes `−cos(π k/(count − 1))`, increasing.
pub(crate) fn nodes(count: usize) -> Vec<f64> {
    let last = (count - 1) as f64;
    // Through the sine the nodes are exactly symmetric.
    (0..count).map(|k| (PI * (2.0 * k as f64 - last) / (2.0 * last)).sin()).collect()
}

/// Writes the weights with which values at `nodes` make up the interpolant at `at`.
pub(crate) fn weights_into(nodes: &[f64], at: f64, weights: &mut [f64]) {
    if let Some(same) = nodes.iter().position(|&t| t == at) {
        weights.fill(0.0);
        weights[same] = 1.0;
        return;
    }
    let last = nodes.len() - 1;
    let mut sum = 0.0;
    for (k, (weight, t)) in weights.iter_mut().zip(nodes).enumerate() {
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        let end = if k == 0 || k == last { 0.5 } else { 1.0 };
        *weight = sign * end / (at - t);
        sum += *weight;
    }
    weights.iter_mut().for_each(|w| *w /= sum);
}

/// From values at the nodes to Chebyshev coefficients of their interpolant.
#[derive(Debug, Clone)]
pub(crate) struct Transform {
    count: usize,
    /// `[degree][node]`.
    matrix: Vec<f64>,
}

impl Transform {
    pub(crate) fn new(count: usize) -> Self {
        let last = count - 1;
        let share = |k: usize| if k == 0 || k == last { 0.5 } else { 1.0 };
        let entry = |degree: usize, k: usize| {
            let turns = (degree * k) % (2 * last);
            2.0 * share(degree) * share(k) / last as f64 * (PI * turns as f64 / last as f64).cos()
        };
        let matrix = (0..count * count).map(|i| entry(i / count, i % count)).collect();
        Self { count, matrix }
    }

    /// Sizes of the coefficients.
    pub(crate) fn sizes(&self, values: &[f64]) -> Vec<f64> {
        let size = |row: &[f64]| row.iter().zip(values).map(|(m, v)| m * v).sum::<f64>().abs();
        self.matrix.chunks_exact(self.count).map(size).collect()
    }
}

/// The smallest number of nodes whose interpolant misses at most `error` of the one with these coefficients; `None` if the
/// coefficients have not become small at their end.
pub(crate) fn nodes_within(sizes: &[f64], error: f64) -> Option<usize> {
    let last = sizes.len() - 1;
    // What comes after the last coefficient is about as large as the last few.
    let mut beyond = sizes[last - 3..].iter().sum::<f64>();
    if beyond.is_nan() || beyond > error {
        return None;
    }
    let mut count = sizes.len();
    // Left-out terms also reappear at the nodes, as terms of lower degree: twice their size.
    while count > 2 && 2.0 * (beyond + sizes[count - 1]) <= error {
        beyond += sizes[count - 1];
        count -= 1;
    }
    Some(count)
}
