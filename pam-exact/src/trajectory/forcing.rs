//! A sampled force as segments on which it is a straight line.

use pam_solvers::{ForceSignal, Interpolation};
use std::ops::Range;

/// From its start on, the force is `force_mn + rate_mn_s τ`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ForcingSegment {
    /// Start, s.
    pub(crate) start_s: f64,
    /// Length, s.
    pub(crate) length_s: f64,
    /// Force at the start, mN.
    pub(crate) force_mn: f64,
    /// Slope of the force, mN/s.
    pub(crate) rate_mn_s: f64,
    /// True if the trajectory is observed at the end.
    pub(crate) observed: bool,
}

/// The segments of a signal in order of time: first whole sample intervals, which are read from the signal
/// itself, then those that were cut.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ForcingSegments<'a> {
    /// Samples whose intervals are followed whole, and the one at which the last of them ends.
    times_s: &'a [f64],
    force_mn: &'a [f64],
    held: bool,
    cut: &'a [ForcingSegment],
}

impl<'a> ForcingSegments<'a> {
    /// Cut segments alone.
    pub(crate) fn of(cut: &'a [ForcingSegment]) -> Self {
        Self { times_s: &[], force_mn: &[], held: true, cut }
    }

    fn whole(&self) -> usize {
        self.times_s.len().saturating_sub(1)
    }

    pub(crate) fn len(&self) -> usize {
        self.whole() + self.cut.len()
    }

    #[inline(always)]
    pub(crate) fn get(&self, index: usize) -> Option<ForcingSegment> {
        if let (Some(&[start_s, end_s]), Some(&[force_mn, next_mn])) =
            (self.times_s.get(index..index + 2), self.force_mn.get(index..index + 2))
        {
            let length_s = end_s - start_s;
            let rate_mn_s = if self.held { 0.0 } else { (next_mn - force_mn) / length_s };
            return Some(ForcingSegment { start_s, length_s, force_mn, rate_mn_s, observed: true });
        }
        self.cut.get(index - self.whole()).copied()
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = ForcingSegment> {
        (0..self.len()).map_while(|k| self.get(k))
    }

    /// The length of all segments together, s.
    pub(crate) fn length_s(&self) -> f64 {
        let last = self.len().checked_sub(1).and_then(|last| self.get(last));
        match (self.get(0), last) {
            (Some(first), Some(last)) => last.start_s + last.length_s - first.start_s,
            _ => 0.0,
        }
    }

    /// The length of most segments, s: the median of a few, since lengths differ by rounding alone unless
    /// the recording is irregular.
    pub(crate) fn nominal_length_s(&self) -> f64 {
        let step = (self.len() / 63).max(1);
        let some = (0..self.len()).step_by(step).filter_map(|k| self.get(k));
        let mut lengths: Vec<f64> = some.map(|segment| segment.length_s).collect();
        lengths.sort_by(f64::total_cmp);
        lengths.get(lengths.len() / 2).copied().unwrap_or(1e-3)
    }
}

/// The segments of a signal.
pub(crate) trait Segmented<'a> {
    /// The segments between `t0` and `t1`, cut at the knots and at the observations. Those that are not whole
    /// sample intervals go to `cut`.
    fn segments<'b>(
        &self,
        t0: f64,
        t1: f64,
        observe_s: &[f64],
        cut: &'b mut Vec<ForcingSegment>,
    ) -> ForcingSegments<'b>
    where
        'a: 'b;
}

impl<'a> Segmented<'a> for ForceSignal<'a> {
    fn segments<'b>(
        &self,
        t0: f64,
        t1: f64,
        observe_s: &[f64],
        cut: &'b mut Vec<ForcingSegment>,
    ) -> ForcingSegments<'b>
    where
        'a: 'b,
    {
        cut.clear();
        let samples = whole_intervals(self, t0, t1, observe_s);
        let mut t = t0;
        let mut next_observed = observe_s.partition_point(|&s| s <= t0);
        let mut next_knot = 0;
        while next_knot < self.times_s.len() && self.knot(next_knot) <= t0 {
            next_knot += 1;
        }
        if let Some(last) = samples.clone().last() {
            t = self.times_s[last];
            next_knot += samples.len() - 1;
            next_observed += samples.len() - 1;
        }
        while t < t1 {
            let observed = observe_s.get(next_observed).copied().unwrap_or(f64::INFINITY);
            let knot =
                if next_knot < self.times_s.len() { self.knot(next_knot) } else { f64::INFINITY };
            let end = observed.min(knot).min(t1);
            let (force_mn, rate_mn_s) = line(self, t, next_knot.checked_sub(1));
            let (length_s, observed) = (end - t, end == observed);
            cut.push(ForcingSegment { start_s: t, length_s, force_mn, rate_mn_s, observed });
            next_observed += usize::from(observed);
            next_knot += usize::from(end == knot);
            t = end;
        }
        ForcingSegments {
            times_s: &self.times_s[samples.clone()],
            force_mn: &self.force_mn[samples],
            held: self.interpolation == Interpolation::Hold,
            cut,
        }
    }
}

/// Force and its slope from `t` on, where knot `k` is the last at or before `t` (if any is).
fn line(signal: &ForceSignal<'_>, t: f64, k: Option<usize>) -> (f64, f64) {
    let Some(k) = k else { return (signal.force_mn[0], 0.0) };
    if signal.interpolation == Interpolation::Hold || k + 1 == signal.times_s.len() {
        return (signal.force_mn[k], 0.0);
    }
    let (a, b) = (signal.knot(k), signal.knot(k + 1));
    let rate = (signal.force_mn[k + 1] - signal.force_mn[k]) / (b - a);
    (signal.force_mn[k] + rate * (t - a), rate)
}

/// The samples from `t0` on between which the intervals are segments as they are: each begins a straight
/// line, and the trajectory is observed at each sample, and nowhere in between.
fn whole_intervals(signal: &ForceSignal<'_>, t0: f64, t1: f64, observe_s: &[f64]) -> Range<usize> {
    let after = signal.times_s.partition_point(|&s| s <= t0);
    if signal.interpolation == Interpolation::Ramp || after == 0 || signal.times_s[after - 1] != t0
    {
        return 0..0;
    }
    let observed = &observe_s[observe_s.partition_point(|&s| s <= t0)..];
    let ends = &signal.times_s[after..];
    let count = if std::ptr::eq(ends, observed) {
        ends.partition_point(|&end| end <= t1)
    } else {
        let both = ends.iter().zip(observed);
        both.take_while(|(end, at)| end == at && **at <= t1).count()
    };
    if count > 0 { after - 1..after + count } else { 0..0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pam_solvers::{Input, SampledInput, Side};

    /// The force along every segment equals that of the general solvers' input.
    #[test]
    fn segments_are_the_input_of_the_general_solvers() {
        let times: Vec<f64> =
            (0..40).map(|k| 0.1 * f64::from(k) + 0.01 * f64::from(k % 3)).collect();
        let force: Vec<f64> = times.iter().map(|t| 1e3 * (3.0 * t).sin()).collect();
        let observe: Vec<f64> = (0..25).map(|k| -0.05 + 0.17 * f64::from(k)).collect();
        for interpolation in [Interpolation::Hold, Interpolation::Linear, Interpolation::Ramp] {
            let signal = ForceSignal { times_s: &times, force_mn: &force, interpolation };
            let input = SampledInput::new(&times, &force, interpolation).unwrap();
            let at = |t: f64, side: Side| {
                let mut u = [0.0];
                input.value_into(t, side, &mut u);
                u[0]
            };
            let (t0, t1, mut cut) = (-0.05, 4.03, Vec::new());
            let segments = signal.segments(t0, t1, &observe, &mut cut);
            let mut end = t0;
            for s in segments.iter() {
                assert!((s.start_s - end).abs() < 1e-14);
                end = s.start_s + s.length_s;
                for inside in [0.3 * s.length_s, 0.8 * s.length_s] {
                    let there = at(s.start_s + inside, Side::Right);
                    assert!((s.force_mn + inside * s.rate_mn_s - there).abs() < 1e-9);
                }
            }
            assert!((end - t1).abs() < 1e-14);
            let observed = segments.iter().filter(|s| s.observed).count();
            assert_eq!(observed, observe.iter().filter(|&&t| t > t0 && t <= t1).count());
        }
    }
}
