use super::forcing::{ForcingSegment, ForcingSegments, Segmented};
use pam_core::SealedMasses;
use pam_solvers::ForceSignal;

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
        let span = [self.t0, self.t1];
        self.signal.check(span, &self.y0, self.observe_s, "the exact method reads it")
    }
}
