//! Time and memory of a piece of work.

use crate::memory::peak_bytes;
use std::time::Instant;

/// Time and memory.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Median time, s.
    pub seconds: f64,
    /// Largest number of bytes allocated at a time, if they are counted.
    pub peak_bytes: Option<usize>,
}

/// Work that takes longer than this (s) is not repeated.
const REPEAT_BELOW_S: f64 = 0.5;

/// Runs `work` once for its memory, then up to `repeat` times for its time while that stays short. The
/// result is that of the last run.
pub fn measure<T>(repeat: usize, mut work: impl FnMut() -> T) -> (T, Measured) {
    let clock = Instant::now();
    let (mut result, peak_bytes) = peak_bytes(&mut work);
    let first = clock.elapsed().as_secs_f64();
    let mut times = Vec::new();
    let mut spent = first;
    while times.len() < repeat && spent < REPEAT_BELOW_S {
        let clock = Instant::now();
        result = work();
        times.push(clock.elapsed().as_secs_f64());
        spent += times[times.len() - 1];
    }
    if times.is_empty() {
        times.push(first);
    }
    times.sort_by(f64::total_cmp);
    let middle = times.len() / 2;
    let seconds = if times.len() % 2 == 1 {
        times[middle]
    } else {
        0.5 * (times[middle - 1] + times[middle])
    };
    (result, Measured { seconds, peak_bytes })
}

/// The processor's name, where the system tells it.
#[must_use]
pub fn processor() -> Option<String> {
    let text = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("model name"))?;
    Some(line.split_once(':')?.1.trim().to_owned())
}
