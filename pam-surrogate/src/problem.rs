//! A trajectory to be solved.

use crate::settings::SurrogateSettings;
use pam_core::SealedMasses;
use pam_solvers::ForceSignal;

/// The surface reaches beyond the expected motion by this share of its range.
const MARGIN: f64 = 0.04;
/// It is at least this large, mm and mm/s.
const SMALLEST: [f64; 2] = [0.05, 0.5];
/// Most points of the expected motion that are looked at.
const EXPECTED_POINTS: usize = 20_000;

/// One trajectory to be solved and observed.
#[derive(Debug, Clone, Copy)]
pub struct SurrogateProblem<'a> {
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
    /// Displacements (mm) and velocities (mm/s) near which the motion is expected: the measured ones. The surrogate is made
    /// there beforehand, and elsewhere on the way; both may be empty.
    pub expected: [&'a [f64]; 2],
}

impl SurrogateProblem<'_> {
    pub(crate) fn observed_at_start(&self) -> usize {
        self.observe_s.partition_point(|&t| t <= self.t0)
    }

    /// Most steps that the settings allow.
    pub(crate) fn most_steps(&self, settings: &SurrogateSettings) -> usize {
        settings.budget.steps(self.t1 - self.t0, self.signal.times_s.len())
    }

    /// Middle and size of the rectangle over the expected motion.
    pub(crate) fn expected_area(&self) -> ([f64; 2], [f64; 2]) {
        let mut origin = self.y0;
        let mut width = SMALLEST;
        for d in 0..2 {
            let range = self.expected[d].iter().fold([self.y0[d]; 2], |[low, high], &v| {
                if v.is_finite() { [low.min(v), high.max(v)] } else { [low, high] }
            });
            origin[d] = 0.5 * (range[0] + range[1]);
            width[d] = ((1.0 + MARGIN) * (range[1] - range[0])).max(SMALLEST[d]);
        }
        (origin, width)
    }

    pub(crate) fn expected_points(&self) -> impl Iterator<Item = [f64; 2]> + Clone {
        let [x, v] = self.expected;
        let every = (x.len() / EXPECTED_POINTS).max(1);
        let pairs = x.iter().zip(v).step_by(every).map(|(&x, &v)| [x, v]);
        pairs.filter(|p| p.iter().all(|c| c.is_finite()))
    }

    /// Checks the request; the error is the reason why it is inconsistent.
    pub(crate) fn check(&self) -> Result<(), String> {
        let span = [self.t0, self.t1];
        self.signal.check(span, &self.y0, self.observe_s, "surrogates take it")
    }
}
