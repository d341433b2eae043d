//! A sampled force that is straight between its knots, as solvers with steps of their own take it.

use super::Interpolation;

/// A sampled force.
#[derive(Debug, Clone, Copy)]
pub struct ForceSignal<'a> {
    /// Sample times, s, increasing.
    pub times_s: &'a [f64],
    /// Force at the samples, mN.
    pub force_mn: &'a [f64],
    /// Interpolation between samples. [`Interpolation::Cubic`] is not piecewise linear and is refused.
    pub interpolation: Interpolation,
}

impl ForceSignal<'_> {
    /// The time at which the `k`-th straight line begins, with the force of the `k`-th sample, s.
    ///
    /// # Panics
    /// If there is no such sample.
    #[must_use]
    pub fn knot(&self, k: usize) -> f64 {
        let t = self.times_s;
        if self.interpolation != Interpolation::Ramp || t.len() < 2 {
            return t[k];
        }
        // The middles of the hold intervals; the last sample is held as long as the one before it.
        let last = t.len() - 1;
        t[k] + 0.5 * if k < last { t[k + 1] - t[k] } else { t[k] - t[k - 1] }
    }

    /// Checks a trajectory from `t0` to `t1` (s) that starts at `y0`, is driven by this force and observed at `observe_s` (s).
    /// `reader` begins the sentence that says how the force can be read, as in "the exact method reads it".
    ///
    /// # Errors
    /// The reason why the request is inconsistent.
    pub fn check(
        &self,
        [t0, t1]: [f64; 2],
        y0: &[f64],
        observe_s: &[f64],
        reader: &str,
    ) -> Result<(), String> {
        let Self { times_s, force_mn, interpolation } = *self;
        if times_s.is_empty() || times_s.len() != force_mn.len() {
            return Err(format!(
                "{} sample times and {} forces do not make a signal",
                times_s.len(),
                force_mn.len()
            ));
        }
        if interpolation == Interpolation::Cubic {
            return Err(format!(
                "a cubic reading of the force is no straight line between samples; {reader} held, linear or as a ramp"
            ));
        }
        if !(t0 <= t1 && t1.is_finite()) {
            return Err(format!("the interval from {t0} to {t1} s does not run forward"));
        }
        // Sums in place of early exits: these loops are vectorised.
        let finite = |values: &[f64]| values.iter().fold(true, |all, v| all & v.is_finite());
        if !finite(y0) || !finite(force_mn) {
            return Err("the initial state or the force is infinite or NaN".into());
        }
        let increasing = |times: &[f64]| {
            let next = times.get(1..).unwrap_or_default();
            times.iter().zip(next).fold(true, |all, (t, next)| all & (t < next))
        };
        let same = std::ptr::eq(times_s, observe_s);
        if !increasing(times_s) || (!same && !increasing(observe_s)) {
            return Err("sample and observation times must increase".into());
        }
        let within = |t: Option<&f64>| t.is_none_or(|&t| t >= t0 && t <= t1);
        if !within(observe_s.first()) || !within(observe_s.last()) {
            return Err("an observation lies outside of start and end".into());
        }
        Ok(())
    }
}
