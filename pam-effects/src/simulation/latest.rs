//! What was worked out lately.

use std::collections::VecDeque;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

/// Values that follow from their keys, the latest of which are kept. A value is the same whether it was kept or not.
pub struct Latest<K, V> {
    entries: Mutex<VecDeque<(K, Arc<V>)>>,
    most: usize,
}

impl<K: PartialEq, V> Latest<K, V> {
    /// Memory for `most` values.
    #[must_use]
    pub fn new(most: usize) -> Self {
        Self { entries: Mutex::new(VecDeque::with_capacity(most)), most }
    }

    /// The value of a key, kept or worked out.
    ///
    /// # Errors
    /// That of `work_out`.
    pub fn get<E>(&self, key: K, work_out: impl FnOnce() -> Result<V, E>) -> Result<Arc<V>, E> {
        let known = |entries: &mut VecDeque<(K, Arc<V>)>| {
            let at = entries.iter().rposition(|(k, _)| *k == key)?;
            let found = entries.remove(at)?;
            let value = Arc::clone(&found.1);
            entries.push_back(found);
            Some(value)
        };
        if let Some(value) = known(&mut self.entries.lock().unwrap_or_else(PoisonError::into_inner))
        {
            return Ok(value);
        }
        // Other threads go on meanwhile.
        let value = Arc::new(work_out()?);
        let mut entries = self.entries.lock().unwrap_or_else(PoisonError::into_inner);
        while entries.len() >= self.most {
            entries.pop_front();
        }
        entries.push_back((key, Arc::clone(&value)));
        Ok(value)
    }
}

/// Without what was kept.
impl<K: PartialEq, V> Clone for Latest<K, V> {
    fn clone(&self) -> Self {
        Self::new(self.most)
    }
}

impl<K, V> fmt::Debug for Latest<K, V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Latest").field("most", &self.most).finish_non_exhaustive()
    }
}
