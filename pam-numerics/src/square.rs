//! Square matrices.

use std::ops::{AddAssign, Index, IndexMut};

/// A square matrix that is assembled entry by entry, such as a normal matrix.
#[derive(Debug, Clone, PartialEq)]
pub struct SquareMatrix {
    size: usize,
    rows: Vec<f64>,
}

impl SquareMatrix {
    /// The zero matrix with `size` rows.
    #[must_use]
    pub fn zeros(size: usize) -> Self {
        Self { size, rows: vec![0.0; size * size] }
    }

    /// Number of rows.
    #[must_use]
    pub fn size(&self) -> usize {
        self.size
    }
}

impl Index<(usize, usize)> for SquareMatrix {
    type Output = f64;
    fn index(&self, (row, column): (usize, usize)) -> &f64 {
        &self.rows[row * self.size + column]
    }
}

impl IndexMut<(usize, usize)> for SquareMatrix {
    fn index_mut(&mut self, (row, column): (usize, usize)) -> &mut f64 {
        &mut self.rows[row * self.size + column]
    }
}

impl AddAssign<&SquareMatrix> for SquareMatrix {
    fn add_assign(&mut self, other: &SquareMatrix) {
        assert_eq!(self.size, other.size, "matrix sizes differ");
        self.rows.iter_mut().zip(&other.rows).for_each(|(a, b)| *a += b);
    }
}
