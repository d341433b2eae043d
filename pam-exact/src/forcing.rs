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

    /// Pieces from sample to sample, as long as each sample is observed; returns where they end.
    fn whole_samples_into(
        &self,
        t0: f64,
        t1: f64,
        observe_s: &[f64],
        longest_s: f64,
        pieces: &mut Vec<Piece>,
    ) -> f64 {
        let first = self.times_s.partition_point(|&s| s <= t0);
        if first == 0 || self.times_s[first - 1] != t0 {
            return t0;
        }
        let observed = &observe_s[observe_s.partition_point(|&s| s <= t0)..];
        let held = self.interpolation == Interpolation::Hold;
        let starts =
            self.times_s[first - 1..].windows(2).zip(self.force_mn[first - 1..].windows(2));
        let mut t = t0;
        for ((times, force), &at) in starts.zip(observed) {
            let length_s = times[1] - times[0];
            if times[1] != at || at > t1 || length_s > longest_s {
                break;
            }
            let rate_mn_s = if held { 0.0 } else { (force[1] - force[0]) / length_s };
            let [start_s, force_mn] = [times[0], force[0]];
            pieces.push(Piece { start_s, length_s, force_mn, rate_mn_s, observed: true });
            t = at;
        }
        t
    }

    /// Cuts `[t0, t1]` at the knots and at `observe_s`, and into equal parts no longer than
    /// `longest_s`.
    pub(crate) fn pieces_into(
        &self,
        (t0, t1): (f64, f64),
        observe_s: &[f64],
        longest_s: f64,
        pieces: &mut Vec<Piece>,
    ) {
        pieces.clear();
        let mut t = t0;
        let mut next_observed = observe_s.partition_point(|&s| s <= t0);
        let mut next_knot = 0;
        while next_knot < self.times_s.len() && self.knot(next_knot) <= t0 {
            next_knot += 1;
        }
        if self.interpolation != Interpolation::Ramp {
            t = self.whole_samples_into(t, t1, observe_s, longest_s, pieces);
            next_knot += pieces.len();
            next_observed += pieces.len();
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
                pieces.push(Piece { start_s: t, length_s: whole, force_mn, rate_mn_s, observed });
                next_observed += usize::from(observed);
                next_knot += usize::from(end == knot);
                t = end;
                continue;
            }
            let parts = (whole / longest_s).ceil();
            let length_s = whole / parts;
            for part in 0..parts as usize {
                let into = part as f64 * length_s;
                pieces.push(Piece {
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
                let mut pieces = Vec::new();
                signal.pieces_into((-0.05, 4.03), &observe, longest, &mut pieces);
                let mut end = -0.05;
                for p in &pieces {
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
