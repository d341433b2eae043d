//! Sampling steps, and gaps between samples.

use super::Recording;
use crate::error::DataError;

/// Ranges of samples without a gap: a new one begins where the time step exceeds 1.5 times the
/// median step.
#[must_use]
pub fn contiguous_ranges(time_s: &[f64]) -> Vec<std::ops::Range<usize>> {
    let step = median_step_s(time_s);
    let mut starts = vec![0];
    starts.extend(
        time_s.windows(2).enumerate().filter(|(_, w)| w[1] - w[0] > 1.5 * step).map(|(i, _)| i + 1),
    );
    let ends = starts.iter().skip(1).copied().chain([time_s.len()]);
    starts.iter().zip(ends).map(|(&a, b)| a..b).collect()
}

/// The median of the time steps, s; infinite if there are fewer than two samples.
#[must_use]
pub fn median_step_s(time_s: &[f64]) -> f64 {
    let mut steps: Vec<f64> = time_s.windows(2).map(|w| w[1] - w[0]).collect();
    if steps.is_empty() {
        return f64::INFINITY;
    }
    let middle = steps.len() / 2;
    *steps.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Splits a recording at its gaps. Parts of fewer than `shortest` samples are dropped, and both are
/// recorded in the notes. All parts keep the sealed reading of the run (the first sample's, if the file
/// has none), because the valves stay closed across a gap.
///
/// # Errors
/// [`DataError::File`] if no part is long enough.
pub fn split_at_gaps(recording: Recording, shortest: usize) -> Result<Vec<Recording>, DataError> {
    let ranges = contiguous_ranges(&recording.time_s);
    if ranges.len() < 2 {
        return Ok(vec![recording]);
    }
    let mut whole = recording;
    whole.sealed = Some(whole.reading_at_rest());
    let gaps: Vec<String> = ranges
        .windows(2)
        .map(|w| {
            let (before, after) = (whole.time_s[w[0].end - 1], whole.time_s[w[1].start]);
            format!("{:.3} s at t = {before:.3} s", after - before)
        })
        .collect();
    whole.notes.push(format!(
        "{} gap(s) in time ({}{}); the run is split there",
        gaps.len(),
        gaps.iter().take(4).cloned().collect::<Vec<_>>().join(", "),
        if gaps.len() > 4 { ", …" } else { "" }
    ));
    let kept: Vec<_> = ranges.iter().filter(|r| r.len() >= shortest).collect();
    if kept.is_empty() {
        return Err(DataError::file(
            &whole.source,
            format!(
                "gaps in time cut the recording into {} parts, none of at least {shortest} samples",
                ranges.len()
            ),
        ));
    }
    let dropped = ranges.len() - kept.len();
    if dropped > 0 {
        whole.notes.push(format!(
            "{dropped} part(s) of fewer than {shortest} samples between gaps are left out"
        ));
    }
    let parts = kept.iter().enumerate().map(|(i, range)| {
        let mut part = whole.slice((*range).clone());
        part.name = format!("{}#{}", whole.name, i + 1);
        part
    });
    Ok(parts.collect())
}
