//! Ridge regression on many rows, from their moments.
//!
//! ```text
//! min_K Σ_k |y_k − K φ_k|² + λ |K|²      K = (Σ y φᵀ) (Σ φ φᵀ + λ I)⁻¹
//! ```
//!
//! The moments are matrix products over blocks of rows; blocks are summed in their order, so the result
//! does not depend on the number of threads.

use pam_core::simd::gemm::{Finish, Layout, Product, Start};
use pam_core::simd::padded;
use pam_numerics::ScaledCholesky;

/// Rows that are worked off at once.
pub const BLOCK: usize = 512;

/// Second moments of features and targets.
#[derive(Debug, Clone)]
pub struct Moments {
    features: usize,
    targets: usize,
    /// Distance of rows in a block.
    stride: usize,
    /// `[features][stride]`: features by all, column by column.
    sums: Vec<f64>,
    block: Vec<f64>,
    filled: usize,
    rows: usize,
}

impl Moments {
    /// Moments of rows of `features` and `targets` numbers.
    #[must_use]
    pub fn new(features: usize, targets: usize) -> Self {
        let stride = padded(features + targets);
        Self {
            features,
            targets,
            stride,
            sums: vec![0.0; stride * features],
            block: vec![0.0; stride * BLOCK],
            filled: 0,
            rows: 0,
        }
    }

    /// Adds a row that `fill` writes: features, then targets.
    pub fn add(&mut self, fill: impl FnOnce(&mut [f64], &mut [f64])) {
        let row = &mut self.block[self.filled * self.stride..][..self.stride];
        let (features, rest) = row.split_at_mut(self.features);
        fill(features, &mut rest[..self.targets]);
        self.filled += 1;
        self.rows += 1;
        if self.filled == BLOCK {
            self.flush();
        }
    }

    /// Takes up rows that are not summed yet.
    fn flush(&mut self) {
        if self.filled == 0 {
            return;
        }
        Product {
            rows: self.stride,
            inner: self.filled,
            columns: self.features,
            a: &self.block,
            b: &self.block,
            layout: Layout::Rows,
            b_stride: self.stride,
            start: Start::Held,
            finish: Finish::Store,
            c: &mut self.sums,
        }
        .run();
        self.filled = 0;
    }

    /// Adds the moments of other rows.
    pub fn merge(&mut self, mut other: Self) {
        self.flush();
        other.flush();
        for (a, b) in self.sums.iter_mut().zip(&other.sums) {
            *a += b;
        }
        self.rows += other.rows;
    }

    /// Number of rows.
    #[must_use]
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// The map from features to targets, row by row `[targets][features]`; `None` if the moments are
    /// singular.
    #[must_use]
    pub fn solve(&mut self, ridge: f64) -> Option<Vec<f64>> {
        self.flush();
        let n = self.features;
        let at = |i: usize, j: usize| self.sums[j * self.stride + i];
        let gram = |i, j| 0.5 * (at(i, j) + at(j, i)) + if i == j { ridge } else { 0.0 };
        let factor = ScaledCholesky::new(n, gram, 0.0)?;
        let mut map = Vec::with_capacity(self.targets * n);
        for t in 0..self.targets {
            let right: Vec<f64> = (0..n).map(|j| at(n + t, j)).collect();
            map.extend(factor.solve(&right)?);
        }
        Some(map)
    }
}
