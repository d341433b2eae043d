//! Whole recordings, or windows of them, on which a model is trained.

use crate::metrics::variance;
use pam_data::{Channel, Subject};
use std::sync::atomic::{AtomicU64, Ordering};

/// Windows of recordings, each overlapping the next one in one sample.
#[derive(Debug, Clone)]
pub struct Windows {
    subjects: Vec<Subject>,
    /// The window that follows each one in the same recording.
    pub next: Vec<Option<usize>>,
    /// Time between the start of the recording and that of each window, s.
    pub since_s: Vec<f64>,
    /// Variances of the channels over the recording of each window.
    pub variance: Vec<[f64; 4]>,
    id: u64,
}

/// An id that no other windows have.
fn new_id() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(0);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

impl Windows {
    /// Cuts recordings into windows of `horizon_s`, or keeps them whole. A rest of fewer than two
    /// samples is left out.
    #[must_use]
    pub fn of(subjects: impl Into<Vec<Subject>>, horizon_s: Option<f64>) -> Self {
        let subjects = subjects.into();
        // A channel that does not vary has no gap that could be weighed.
        let variance = |s: &Subject| {
            Channel::ALL.map(|c| variance(s.recording.channel(c)).max(f64::MIN_POSITIVE))
        };
        if horizon_s.is_none() {
            let n = subjects.len();
            let variance = subjects.iter().map(variance).collect();
            let (next, since_s) = (vec![None; n], vec![0.0; n]);
            return Self { subjects, next, since_s, variance, id: new_id() };
        }
        let mut windows = Self {
            subjects: Vec::new(),
            next: Vec::new(),
            since_s: Vec::new(),
            variance: Vec::new(),
            id: new_id(),
        };
        for s in &subjects {
            let variance = variance(s);
            let cuts = cuts(&s.recording.time_s, horizon_s);
            for (k, pair) in cuts.windows(2).enumerate() {
                let recording = if cuts.len() == 2 {
                    s.recording.clone()
                } else {
                    // The valves stay closed: what was sealed in is that of the recording.
                    let mut window = s.recording.slice(pair[0]..pair[1] + 1);
                    window.sealed = Some(s.recording.reading_at_rest());
                    window
                };
                let index = windows.subjects.len();
                windows.subjects.push(Subject { recording, ..s.clone_without_samples() });
                windows.next.push((k + 2 < cuts.len()).then_some(index + 1));
                let time_s = &s.recording.time_s;
                windows.since_s.push(time_s[pair[0]] - time_s[0]);
                windows.variance.push(variance);
            }
        }
        windows
    }

    /// Recordings and masses of the windows, in the order of recordings and time.
    #[must_use]
    pub fn subjects(&self) -> &[Subject] {
        &self.subjects
    }

    /// Recordings and masses to change. The windows get a new [`id`](Self::id).
    pub fn subjects_mut(&mut self) -> &mut [Subject] {
        self.id = new_id();
        &mut self.subjects
    }

    /// Identifies the windows: clones share the id, changed windows get a new one. Engines keep what they
    /// prepare for windows as long as the id is the same.
    #[must_use]
    pub fn id(&self) -> u64 {
        self.id
    }

    /// Measured states at the starts.
    #[must_use]
    pub fn measured_starts(&self) -> Vec<[f64; 4]> {
        self.subjects.iter().map(|s| s.recording.initial_state()).collect()
    }
}

/// Indices of the samples at which windows begin and end.
fn cuts(time_s: &[f64], horizon_s: Option<f64>) -> Vec<usize> {
    let last = time_s.len() - 1;
    let Some(horizon) = horizon_s else { return vec![0, last] };
    let mut cuts = vec![0];
    let mut at = 0;
    while at < last {
        // Half a microsecond of tolerance against rounding of times.
        let end = time_s[at] + horizon - 5e-7;
        let next = at + time_s[at..].partition_point(|&t| t < end);
        at = next.clamp(at + 1, last);
        cuts.push(at);
    }
    cuts
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_cover_the_recording_and_share_their_ends() {
        let time: Vec<f64> = (0..=1000).map(|k| f64::from(k) * 1e-3).collect();
        assert_eq!(cuts(&time, None), [0, 1000]);
        assert_eq!(cuts(&time, Some(0.25)), [0, 250, 500, 750, 1000]);
        assert_eq!(cuts(&time, Some(0.4)), [0, 400, 800, 1000]);
        assert_eq!(cuts(&time, Some(9.0)), [0, 1000]);
        assert_eq!(cuts(&time[..3], Some(1e-9)), [0, 1, 2]);
    }
}
