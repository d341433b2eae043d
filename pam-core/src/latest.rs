//! A bounded memory of results: the least recently used ones are dropped.

use std::collections::VecDeque;
use std::convert::Infallible;
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The most recently used results of a function, with their keys. Several threads may use it: as a result follows from its key
/// alone, it does not matter which thread computes it.
///
/// ```
/// use pam_core::Latest;
///
/// let roots = Latest::new(2);
/// assert_eq!(*roots.get(9, || 3), 3);
/// // It is kept, and not computed again.
/// assert_eq!(*roots.get(9, || unreachable!()), 3);
/// roots.get(16, || 4);
/// roots.get(25, || 5);
/// assert!(roots.find(|key| (*key == 9).then_some(())).is_none());
/// ```
pub struct Latest<K, V> {
    kept: Mutex<Kept<K, V>>,
    most: usize,
}

/// Results with their sizes, the most recently used one at the end.
struct Kept<K, V> {
    entries: VecDeque<(K, Arc<V>, usize)>,
    size: usize,
}

impl<K, V> Latest<K, V> {
    /// Memory for results whose sizes sum to at most `most`.
    #[must_use]
    pub fn new(most: usize) -> Self {
        Self { kept: Mutex::new(Kept { entries: VecDeque::new(), size: 0 }), most }
    }

    fn kept(&self) -> MutexGuard<'_, Kept<K, V>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The most recently used result with a key for which `serves` returns something, and what it returns.
    pub fn find<T>(&self, serves: impl Fn(&K) -> Option<T>) -> Option<(T, Arc<V>)> {
        let entries = &mut self.kept().entries;
        let (at, found) =
            entries.iter().enumerate().rev().find_map(|(at, (k, ..))| Some((at, serves(k)?)))?;
        let entry = entries.remove(at)?;
        let value = Arc::clone(&entry.1);
        entries.push_back(entry);
        Some((found, value))
    }

    /// Keeps a result of a size, and drops the least recently used ones beyond the most.
    pub fn keep(&self, key: K, value: Arc<V>, size: usize) {
        let mut kept = self.kept();
        kept.size += size;
        kept.entries.push_back((key, value, size));
        while kept.size > self.most {
            let Some((.., oldest)) = kept.entries.pop_front() else { break };
            kept.size -= oldest;
        }
    }
}

impl<K: PartialEq, V> Latest<K, V> {
    /// The result of a key, kept or computed, where each result has the size 1.
    pub fn get(&self, key: K, compute: impl FnOnce() -> V) -> Arc<V> {
        let computed: Result<_, Infallible> = self.try_get(key, || Ok(compute()));
        match computed {
            Ok(value) => value,
        }
    }

    /// As [`get`](Self::get), for a computation that may fail; failures are not kept.
    ///
    /// # Errors
    /// That of `compute`.
    pub fn try_get<E>(&self, key: K, compute: impl FnOnce() -> Result<V, E>) -> Result<Arc<V>, E> {
        if let Some((_, value)) = self.find(|k| (*k == key).then_some(())) {
            return Ok(value);
        }
        // Other threads go on meanwhile.
        let value = Arc::new(compute()?);
        self.keep(key, Arc::clone(&value), 1);
        Ok(value)
    }
}

/// The clone is empty.
impl<K, V> Clone for Latest<K, V> {
    fn clone(&self) -> Self {
        Self::new(self.most)
    }
}

impl<K, V> fmt::Debug for Latest<K, V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Latest").field("most", &self.most).finish_non_exhaustive()
    }
}
