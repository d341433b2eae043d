//! Memory that a piece of work really takes.
//!
//! A program that wants to know installs the allocator:
//!
//! ```
//! use pam_bench::memory::{CountingAllocator, peak_bytes};
//!
//! #[global_allocator]
//! static MEMORY: CountingAllocator = CountingAllocator;
//!
//! let (sum, peak) = peak_bytes(|| vec![1_u8; 1 << 20].iter().map(|&b| u64::from(b)).sum::<u64>());
//! assert_eq!(sum, 1 << 20);
//! assert!(peak.is_some_and(|bytes| bytes >= 1 << 20));
//! ```

use std::alloc::{GlobalAlloc, Layout, System};
use std::hint::black_box;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicIsize, Ordering::Relaxed};

/// Whether allocations are counted at the moment.
static COUNTING: AtomicBool = AtomicBool::new(false);
/// Bytes allocated since counting began, less those freed.
static LIVE: AtomicIsize = AtomicIsize::new(0);
/// The largest [`LIVE`] so far.
static PEAK: AtomicIsize = AtomicIsize::new(0);
/// One measurement at a time.
static MEASURING: Mutex<()> = Mutex::new(());

/// Size of the allocation that shows whether the allocator is installed.
const PROBE_BYTES: usize = 64;

/// The system's allocator, counting while [`peak_bytes`] runs and costing one flag otherwise.
#[derive(Debug, Clone, Copy, Default)]
pub struct CountingAllocator;

fn count(bytes: isize) {
    if COUNTING.load(Relaxed) {
        let live = LIVE.fetch_add(bytes, Relaxed) + bytes;
        PEAK.fetch_max(live, Relaxed);
    }
}

// SAFETY: every request goes unchanged to the system's allocator, whose contract is the same; counting
// touches atomics only and never allocates.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for CountingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as isize);
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as isize);
        // SAFETY: the caller keeps the contract of `alloc_zeroed`.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count(-(layout.size() as isize));
        // SAFETY: the caller keeps the contract of `dealloc`; the memory is the system's.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, new_size: usize) -> *mut u8 {
        count(new_size as isize - layout.size() as isize);
        // SAFETY: the caller keeps the contract of `realloc`; the memory is the system's.
        unsafe { System.realloc(pointer, layout, new_size) }
    }
}

/// Runs `work` and returns, with its result, the largest number of bytes that were allocated at a time
/// besides those allocated before; `None` where [`CountingAllocator`] is not installed.
///
/// Everything that the process allocates meanwhile is counted, so nothing else should run.
pub fn peak_bytes<T>(work: impl FnOnce() -> T) -> (T, Option<usize>) {
    let _one = MEASURING.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    LIVE.store(0, Relaxed);
    PEAK.store(0, Relaxed);
    COUNTING.store(true, Relaxed);
    drop(black_box(Vec::<u8>::with_capacity(PROBE_BYTES)));
    let installed = PEAK.load(Relaxed) >= PROBE_BYTES as isize;
    LIVE.store(0, Relaxed);
    PEAK.store(0, Relaxed);
    let result = work();
    COUNTING.store(false, Relaxed);
    let peak = usize::try_from(PEAK.load(Relaxed)).unwrap_or(0);
    (result, installed.then_some(peak))
}
