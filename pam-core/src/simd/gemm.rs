//! The matrix product of batched networks, `C = finish(start + A B)`.
//!
//! Network layers are small (some tens of rows) and batches are long, so `A` stays in cache and is
//! read as it lies; nothing is packed. A tile of `C`, several vectors of rows by a few columns,
//! is held in registers while the inner dimension runs. Each column of `C` is summed in the order of
//! the inner dimension, whatever its neighbours: results do not depend on how a batch is cut.
//!
//! On 96×96 layers this is faster than the general-purpose products of the crates `gemm` and
//! `matrixmultiply`, most of all for few columns (`cargo bench -p pam-bench --bench gemm`).

use super::Float;
use pulp::{Simd, WithSimd};

/// Inner dimension that is worked off at once when the second factor lies row by row.
const PIECE: usize = 64;

/// Where the second factor `B` lies in its slice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// Column by column: `B[k, j]` at `j · stride + k`.
    Columns,
    /// Row by row: `B[k, j]` at `k · stride + j`.
    Rows,
}

/// Start value of the sums of a product.
#[derive(Debug, Clone, Copy)]
pub enum Start<'a, T> {
    /// The present values of `C`.
    Held,
    /// Zero.
    Zero,
    /// A column for all columns of `C`, or one for each, `[columns][rows]`.
    Columns(&'a [T]),
}

/// Operation on the sums before they are stored.
#[derive(Debug, Clone, Copy)]
pub enum Finish<'a, T> {
    /// Nothing.
    Store,
    /// Each is multiplied by a number of the same place, `[columns][rows]`.
    Multiply(&'a [T]),
    /// Each is multiplied by the slope of a leaky ReLU whose values, `[columns][rows]`, are given: by
    /// `slope` where they are not positive.
    Gate {
        /// Values of the leaky ReLU.
        values: &'a [T],
        /// Its slope for negative arguments.
        slope: T,
    },
    /// `max(z, slope · z)`: a leaky ReLU for slopes from 0 to 1.
    LeakyRelu(T),
}

/// One product `C = finish(start + A B)` with `A` `[rows, inner]` and `C` `[rows, columns]` column by column.
#[derive(Debug)]
pub struct Product<'a, T> {
    /// Rows of `A` and `C`; a multiple of [`PAD`](super::PAD).
    pub rows: usize,
    /// Columns of `A`, rows of `B`.
    pub inner: usize,
    /// Columns of `B` and `C`.
    pub columns: usize,
    /// The first factor; its columns are `rows` apart.
    pub a: &'a [T],
    /// The second factor.
    pub b: &'a [T],
    /// How the second factor lies.
    pub layout: Layout,
    /// Distance between columns (or rows) of the second factor.
    pub b_stride: usize,
    /// Start value of the sums.
    pub start: Start<'a, T>,
    /// Last operation on the sums.
    pub finish: Finish<'a, T>,
    /// The result; its columns are `rows` apart.
    pub c: &'a mut [T],
}

impl<T: Float> Product<'_, T> {
    /// Computes the product.
    ///
    /// # Panics
    /// If a slice is too short or `rows` is not a whole number of vectors.
    pub fn run(self) {
        assert!(self.rows.is_multiple_of(super::PAD), "rows are padded to whole vectors");
        assert!(self.a.len() >= self.rows * self.inner && self.c.len() >= self.rows * self.columns);
        T::run_product(self);
    }

    /// A tile of `V` vectors of rows from row `i` by `N` columns from column `j`.
    ///
    /// Plain indices, and no closures but what is surely inlined: the compiler keeps the sums in
    /// registers only if it sees each of them by name.
    #[allow(clippy::needless_range_loop)]
    #[inline(always)]
    fn tile<S: Simd, const V: usize, const N: usize>(&mut self, simd: S, i: usize, j: usize) {
        let (a, b, rows, inner, b_stride) = (self.a, self.b, self.rows, self.inner, self.b_stride);
        let place = |n: usize| (j + n) * rows + i;
        let mut sums = [[T::splat(simd, T::default()); V]; N];
        match self.start {
            Start::Zero => {}
            Start::Held => {
                for n in 0..N {
                    sums[n] = *vectors::<S, T, V>(self.c, place(n));
                }
            }
            Start::Columns(c) => {
                let each = c.len() != rows;
                for n in 0..N {
                    sums[n] = *vectors::<S, T, V>(c, if each { place(n) } else { i });
                }
            }
        }
        match self.layout {
            Layout::Columns => {
                let mut columns = [b; N];
                for n in 0..N {
                    columns[n] = &b[(j + n) * b_stride..][..inner];
                }
                for k in 0..inner {
                    let a = vectors::<S, T, V>(a, k * rows + i);
                    for n in 0..N {
                        let b = T::splat(simd, columns[n][k]);
                        for v in 0..V {
                            sums[n][v] = T::fused(simd, a[v], b, sums[n][v]);
                        }
                    }
                }
            }
            Layout::Rows => {
                for k in 0..inner {
                    let a = vectors::<S, T, V>(a, k * rows + i);
                    let row = &b[k * b_stride + j..][..N];
                    for n in 0..N {
                        let b = T::splat(simd, row[n]);
                        for v in 0..V {
                            sums[n][v] = T::fused(simd, a[v], b, sums[n][v]);
                        }
                    }
                }
            }
        }
        match self.finish {
            Finish::Store => {}
            Finish::Multiply(factors) => {
                for n in 0..N {
                    let factors = vectors::<S, T, V>(factors, place(n));
                    for v in 0..V {
                        sums[n][v] = T::times(simd, sums[n][v], factors[v]);
                    }
                }
            }
            Finish::Gate { values, slope } => {
                let slope = T::splat(simd, slope);
                for n in 0..N {
                    let gates = vectors::<S, T, V>(values, place(n));
                    for v in 0..V {
                        sums[n][v] = T::gated(simd, gates[v], sums[n][v], slope);
                    }
                }
            }
            Finish::LeakyRelu(slope) => {
                let slope = T::splat(simd, slope);
                for n in 0..N {
                    for v in 0..V {
                        let z = sums[n][v];
                        sums[n][v] = T::larger(simd, z, T::times(simd, z, slope));
                    }
                }
            }
        }
        for n in 0..N {
            let start = place(n);
            let (c, _) = T::split_mut::<S>(&mut self.c[start..start + V * T::lanes::<S>()]);
            let c: &mut [T::Vector<S>; V] = c.try_into().expect("a tile is V vectors high");
            *c = sums[n];
        }
    }

    /// All rows of `N` columns from column `j`.
    #[inline(always)]
    fn stripe<S: Simd, const N: usize>(&mut self, simd: S, j: usize) {
        let lanes = T::lanes::<S>();
        let mut i = 0;
        // 24 sums, 6 vectors of A and one of B fill 32 registers; with 16 a tile is half as high.
        if S::REGISTER_COUNT >= 32 {
            while i + 6 * lanes <= self.rows {
                self.tile::<S, 6, N>(simd, i, j);
                i += 6 * lanes;
            }
            if i + 4 * lanes <= self.rows {
                self.tile::<S, 4, N>(simd, i, j);
                i += 4 * lanes;
            }
        }
        while i + 3 * lanes <= self.rows {
            self.tile::<S, 3, N>(simd, i, j);
            i += 3 * lanes;
        }
        while i + lanes <= self.rows {
            self.tile::<S, 1, N>(simd, i, j);
            i += lanes;
        }
    }
}

impl<T: Float> WithSimd for Product<'_, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        // A long inner dimension is a batch: it is cut, so that a piece of both factors stays in the
        // first cache while all tiles use it. The order of each sum stays the same.
        let whole = self.inner;
        let (a, b, finish) = (self.a, self.b, self.finish);
        let rows_of_b = self.layout == Layout::Rows;
        let piece = if rows_of_b { PIECE } else { whole.max(1) };
        let mut first = 0;
        loop {
            let last = first + piece >= whole;
            self.inner = if last { whole - first } else { piece };
            self.a = &a[first * self.rows..];
            self.b = if rows_of_b { &b[first * self.b_stride..] } else { b };
            self.finish = if last { finish } else { Finish::Store };
            self.all_columns(simd);
            if last {
                return;
            }
            self.start = Start::Held;
            first += piece;
        }
    }
}

impl<T: Float> Product<'_, T> {
    #[inline(always)]
    fn all_columns<S: Simd>(&mut self, simd: S) {
        let mut j = 0;
        while j + 4 <= self.columns {
            self.stripe::<S, 4>(simd, j);
            j += 4;
        }
        if j + 2 <= self.columns {
            self.stripe::<S, 2>(simd, j);
            j += 2;
        }
        if j < self.columns {
            self.stripe::<S, 1>(simd, j);
        }
    }
}

/// `V` vectors from place `start` on.
#[inline(always)]
fn vectors<S: Simd, T: Float, const V: usize>(slice: &[T], start: usize) -> &[T::Vector<S>; V] {
    let (vectors, _) = T::split::<S>(&slice[start..start + V * T::lanes::<S>()]);
    vectors.try_into().expect("a tile is V vectors high")
}
