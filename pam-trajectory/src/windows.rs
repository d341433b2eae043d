//! What a stage trains on: whole recordings, or windows of them.

use crate::metrics::variance;
use pam_data::Channel;
use pam_data::Subject;

/// Windows of recordings, each overlapping the next one in one sample.
#[derive(Debug, Clone)]
pub struct Windows {
    /// The windows in the order of recordings and time.
    pub subjects: Vec<Subject>,
    /// Of each window the one that follows it in the same recording.
    pub next: Vec<Option<usize>>,
    /// Of each window the time since its recording began, s.
    pub since_s: Vec<f64>,
    /// Of each window the variances of the channels over its recording.
    pub variance: Vec<[f64; 4]>,
}

impl Windows {
    /// Cuts recordings into windows of `horizon_s`, or keeps them whole. A rest of fewer than two
    /// samples is left out.
    #[must_use]
    pub fn of(subjects: &[Subject], horizon_s: Option<f64>) -> Self {
        let mut windows = Self {
            subjects: Vec::new(),
            next: Vec::new(),
            since_s: Vec::new(),
            variance: Vec::new(),
        };
        for s in subjects {
            // A channel that does not vary has no gap that could be weighed.
            let variance =
                Channel::ALL.map(|c| variance(s.recording.channel(c)).max(f64::MIN_POSITIVE));
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
