//! A sampled force cut into pieces on which it is a straight line.

use pam_solvers::Interpolation;

/// One piece: from its start on, the force is `force_mn + rate τ`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Piece {
    /// Start, s.
    pub(crate) start_s: f64,
    /// Length, s.
    pub(crate) length_s: f64,
    /// Force at the start, mN.
    pub(crate) force_mn: f64,
    /// Slope of the force, mN/s.
    pub(crate) rate_mn_s: f64,
    /// Whether the trajectory is observed at the end.
    pub(crate) observed: bool,
}

/// The pieces of a signal in the order of time: first those from sample to sample, which are read where
/// the signal lies, then those that were cut.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pieces<'a> {
    /// Samples that are followed whole, and the one at which the last of them ends.
    times_s: &'a [f64],
    force_mn: &'a [f64],
    held: bool,
    cut: &'a [Piece],
}

impl<'a> Pieces<'a> {
    /// Pieces that were cut, and no others.
    pub(crate) fn of(cut: &'a [Piece]) -> Self {
        Self { times_s: &[], force_mn: &[], held: true, cut }
    }

    fn whole(&self) -> usize {
        self.times_s.len().saturating_sub(1)
    }

    pub(crate) fn len(&self) -> usize {
        self.whole() + self.cut.len()
    }

    #[inline(always)]
    pub(crate) fn get(&self, index: usize) -> Option<Piece> {
        if let (Some(&[start_s, end_s]), Some(&[force_mn, next_mn])) =
            (self.times_s.get(index..index + 2), self.force_mn.get(index..index + 2))
        {
            let length_s = end_s - start_s;
            let rate_mn_s = if self.held { 0.0 } else { (next_mn - force_mn) / length_s };
            return Some(Piece { start_s, length_s, force_mn, rate_mn_s, observed: true });
        }
        self.cut.get(index - self.whole()).copied()
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = Piece> {
        (0..self.len()).map_while(|k| self.get(k))
    }
}

/// What drives a trajectory, and where it is looked at.
#[derive(Debug, Clone, Copy)]
pub struct ForceSignal<'a> {
    /// Sample times, s, increasing.
    pub times_s: &'a [f64],
    /// Force at the samples, mN.
    pub force_mn: &'a [f64],
    /// How it is read between samples. [`Interpolation::Cubic`] is no straight line and is refused.
    pub interpolation: Interpolation,
}

impl ForceSignal<'_> {
    /// The knots of the signal: times at which a new straight line begins, with the force there.
    fn knot(&self, k: usize) -> f64 {
        let t = self.times_s;
        if self.interpolation != Interpolation::Ramp || t.len() < 2 {
            return t[k];
        }
        // The middles of the hold intervals; the last sample is held as long as the one before it.
        let last = t.len() - 1;
        t[k] + 0.5 * if k < last { t[k + 1] - t[k] } else { t[k] - t[k - 1] }
    }

    /// Force and its slope from `t` on, where knot `k` is the last at or before `t` (if any is).
    fn line(&self, t: f64, k: Option<usize>) -> (f64, f64) {
        let Some(k) = k else { return (self.force_mn[0], 0.0) };
        if self.interpolation == Interpolation::Hold || k + 1 == self.times_s.len() {
            return (self.force_mn[k], 0.0);
        }
        let (a, b) = (self.knot(k), self.knot(k + 1));
        let rate = (self.force_mn[k + 1] - self.force_mn[k]) / (b - a);
        (self.force_mn[k] + rate * (t - a), rate)
    }

    /// How many samples from `t0` on are followed whole: each begins a straight line, and the trajectory
    /// is observed at each, and nowhere in between; with the place of the first.
    fn whole_samples(
        &self,
        (t0, t1): (f64, f64),
        observe_s: &[f64],
        longest_s: f64,
    ) -> (usize, usize) {
        let after = self.times_s.partition_point(|&s| s <= t0);
        if self.interpolation == Interpolation::Ramp || after == 0 || self.times_s[after - 1] != t0
        {
            return (0, 0);
        }
        let times = &self.times_s[after - 1..];
        let observed = &observe_s[observe_s.partition_point(|&s| s <= t0)..];
        let ends = &times[1..];
        let mut count = if std::ptr::eq(ends, observed) {
            ends.partition_point(|&end| end <= t1)
        } else {
            let both = ends.iter().zip(observed);
            both.take_while(|(end, at)| end == at && **at <= t1).count()
        };
        if longest_s.is_finite() {
            let short = times.windows(2).take(count).take_while(|t| t[1] - t[0] <= longest_s);
            count = short.count();
        }
        (after - 1, count)
    }

    /// Cuts `[t0, t1]` at the knots and at `observe_s`, and into equal parts no longer than
    /// `longest_s`. What is cut otherwise than at every sample goes to `cut`.
    pub(crate) fn pieces<'b>(
        &'b self,
        (t0, t1): (f64, f64),
        observe_s: &[f64],
        longest_s: f64,
        cut: &'b mut Vec<Piece>,
    ) -> Pieces<'b> {
        cut.clear();
        let (first, whole) = self.whole_samples((t0, t1), observe_s, longest_s);
        let mut t = t0;
        let mut next_observed = observe_s.partition_point(|&s| s <= t0);
        let mut next_knot = 0;
        while next_knot < self.times_s.len() && self.knot(next_knot) <= t0 {
            next_knot += 1;
        }
        if whole > 0 {
            t = self.times_s[first + whole];
            next_knot += whole;
            next_observed += whole;
        }
        while t < t1 {
            let observed = observe_s.get(next_observed).copied().unwrap_or(f64::INFINITY);
            let knot =
                if next_knot < self.times_s.len() { self.knot(next_knot) } else { f64::INFINITY };
            let end = observed.min(knot).min(t1);
            let (force_mn, rate_mn_s) = self.line(t, next_knot.checked_sub(1));
            let whole = end - t;
            if whole <= longest_s {
                let observed = end == observed;
                cut.push(Piece { start_s: t, length_s: whole, force_mn, rate_mn_s, observed });
                next_observed += usize::from(observed);
                next_knot += usize::from(end == knot);
                t = end;
                continue;
            }
            let parts = (whole / longest_s).ceil();
            let length_s = whole / parts;
            for part in 0..parts as usize {
                let into = part as f64 * length_s;
                cut.push(Piece {
                    start_s: t + into,
                    length_s,
                    force_mn: force_mn + rate_mn_s * into,
                    rate_mn_s,
                    observed: end == observed && part + 1 == parts as usize,
                });
            }
            next_observed += usize::from(end == observed);
            next_knot += usize::from(end == knot);
            t = end;
        }
        let samples = if whole > 0 { first..first + whole + 1 } else { 0..0 };
        Pieces {
            times_s: &self.times_s[samples.clone()],
            force_mn: &self.force_mn[samples],
            held: self.interpolation == Interpolation::Hold,
            cut,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pam_solvers::{Input, SampledInput, Side};

    /// Force at both ends of every piece equals that of the general solvers' input.
    #[test]
    fn pieces_are_the_input_of_the_general_solvers() {
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
            for longest in [f64::INFINITY, 0.02] {
                let mut cut = Vec::new();
                let pieces = signal.pieces((-0.05, 4.03), &observe, longest, &mut cut);
                let mut end = -0.05;
                for p in pieces.iter() {
                    assert!((p.start_s - end).abs() < 1e-14 && p.length_s <= longest);
                    end = p.start_s + p.length_s;
                    let inside = 0.3 * p.length_s;
                    let there = at(p.start_s + inside, Side::Right);
                    assert!((p.force_mn + inside * p.rate_mn_s - there).abs() < 1e-9);
                }
                assert!((end - 4.03).abs() < 1e-14);
                let observed = pieces.iter().filter(|p| p.observed).count();
                assert_eq!(observed, observe.iter().filter(|&&t| t > -0.05 && t <= 4.03).count());
            }
        }
    }
}
