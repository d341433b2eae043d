//! Parallel maps over independent tasks, with results in index order.
//!
//! rayon's iterator adapters are instantiated for every closure, at about 3,000 lines of LLVM IR each. Here a single
//! parallel loop over indices is compiled once and calls the closure through a `dyn` reference. Every index is its own
//! task, so use this for tasks of a few microseconds or more. Loops that hand out mutable slices of the caller's memory
//! use rayon directly.
//!
//! ```
//! use pam_core::parallel;
//! assert_eq!(parallel::map(3, |i| i * i), [0, 1, 4]);
//! assert_eq!(parallel::map_each(vec!["a", "b"], |s| s.to_uppercase()), ["A", "B"]);
//! ```

use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};
use std::sync::{Mutex, PoisonError};

/// Two different tasks at the same time.
#[doc(inline)]
pub use rayon::join;

/// Calls `body(i)` for every `i < count`, in parallel.
pub fn for_each(count: usize, body: &(dyn Fn(usize) + Sync)) {
    (0..count).into_par_iter().with_max_len(1).for_each(body);
}

/// Computes `result(i)` for every `i < count` in parallel. Results are in index order at any number of threads.
pub fn map<R: Send>(count: usize, result: impl Fn(usize) -> R + Sync) -> Vec<R> {
    let slots: Vec<Mutex<Option<R>>> = (0..count).map(|_| Mutex::new(None)).collect();
    for_each(count, &|i| {
        let value = result(i);
        *slots[i].lock().unwrap_or_else(PoisonError::into_inner) = Some(value);
    });
    let value = |slot: Mutex<Option<R>>| slot.into_inner().unwrap_or_else(PoisonError::into_inner);
    slots.into_iter().map(|slot| value(slot).expect("each index was run")).collect()
}

/// Like [`map`], over items that are moved into the closure.
pub fn map_each<T: Send, R: Send>(items: Vec<T>, result: impl Fn(T) -> R + Sync) -> Vec<R> {
    let items: Vec<Mutex<Option<T>>> = items.into_iter().map(|t| Mutex::new(Some(t))).collect();
    map(items.len(), |i| {
        let item = items[i].lock().unwrap_or_else(PoisonError::into_inner).take();
        result(item.expect("each index is run once"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_keep_their_order_on_one_thread_and_on_many() {
        let expected: Vec<usize> = (0..1000).map(|i| i * 7 % 1000).collect();
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let items: Vec<String> = (0..1000).map(|i| i.to_string()).collect();
            let by_item = |s: String| s.parse::<usize>().unwrap() * 7 % 1000;
            let (by_index, by_item) =
                pool.install(|| (map(1000, |i| i * 7 % 1000), map_each(items, by_item)));
            assert_eq!(by_index, expected);
            assert_eq!(by_item, expected);
        }
    }

    #[test]
    fn nothing_and_nested_work() {
        assert!(map(0, |i| i).is_empty());
        let sums = map(20, |i| map(i, |k| k).iter().sum::<usize>());
        assert_eq!(sums[19], 19 * 18 / 2);
    }
}
