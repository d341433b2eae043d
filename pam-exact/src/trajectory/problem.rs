use super::forcing::{ForceSignal, ForcingSegment, ForcingSegments};
use pam_core::SealedMasses;
use pam_solvers::Interpolation;

/// One trajectory to be solved and observed.
#[derive(Debug, Clone, Copy)]
pub struct ExactProblem<'a> {
    /// The air sealed in the muscles.
    pub masses: SealedMasses,
    /// The force on the joint.
    pub signal: ForceSignal<'a>,
    /// Start, s.
    pub t0: f64,
    /// End, s.
    pub t1: f64,
    /// Displacement (mm) and velocity (mm/s) at the start.
    pub y0: [f64; 2],
    /// Observation times (s, increasing, within start and end).
    pub observe_s: &'a [f64],
}

impl<'a> ExactProblem<'a> {
    /// `[m_f, m_e]`, g.
    pub(crate) fn masses_g(&self) -> [f64; 2] {
        [self.masses.flexor_g, self.masses.extensor_g]
    }

    /// Number of observations at the start, which need no solve.
    pub(crate) fn observed_at_start(&self) -> usize {
        self.observe_s.partition_point(|&t| t <= self.t0)
    }

    /// The forcing segments; those that are not whole sample intervals go to `cut`.
    pub(crate) fn forcing_segments<'b>(
        &self,
        cut: &'b mut Vec<ForcingSegment>,
    ) -> ForcingSegments<'b>
    where
        'a: 'b,
    {
        self.signal.segments(self.t0, self.t1, self.observe_s, cut)
    }

    /// Checks the request; the error is the reason why it is inconsistent.
    pub(crate) fn check(&self) -> Result<(), String> {
        let ForceSignal { times_s, force_mn, interpolation } = self.signal;
        if times_s.is_empty() || times_s.len() != force_mn.len() {
            return Err(format!(
                "{} sample times and {} forces do not make a signal",
                times_s.len(),
                force_mn.len()
            ));
        }
        if interpolation == Interpolation::Cubic {
            return Err("a cubic reading of the force is no straight line between samples; \
                        the exact method reads it held, linear or as a ramp"
                .into());
        }
        if !(self.t0 <= self.t1 && self.t1.is_finite()) {
            return Err(format!(
                "the interval from {} to {} s does not run forward",
                self.t0, self.t1
            ));
        }
        // Sums in place of early exits: these loops are vectorised.
        let finite = |values: &[f64]| values.iter().fold(true, |all, v| all & v.is_finite());
        if !finite(&self.y0) || !finite(force_mn) {
            return Err("the initial state or the force is infinite or NaN".into());
        }
        let increasing = |times: &[f64]| {
            let next = times.get(1..).unwrap_or_default();
            times.iter().zip(next).fold(true, |all, (t, next)| all & (t < next))
        };
        let same = std::ptr::eq(times_s, self.observe_s);
        if !increasing(times_s) || (!same && !increasing(self.observe_s)) {
            return Err("sample and observation times must increase".into());
        }
        let within = |t: Option<&f64>| t.is_none_or(|&t| t >= self.t0 && t <= self.t1);
        if !within(self.observe_s.first()) || !within(self.observe_s.last()) {
            return Err("an observation lies outside of start and end".into());
        }
        Ok(())
    }
}
