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
            let range = range_of(self.y0[d], self.expected[d]);
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

/// The smallest and the largest of a number and finite ones among others.
fn range_of(first: f64, others: &[f64]) -> [f64; 2] {
    // Several at a time, so that none waits for the one before it.
    let (chunks, rest) = others.as_chunks::<8>();
    let (mut low, mut high) = ([first; 8], [first; 8]);
    for chunk in chunks {
        for (l, &v) in chunk.iter().enumerate() {
            // Comparisons with NaN are false.
            low[l] = if v < low[l] && v > f64::NEG_INFINITY { v } else { low[l] };
            high[l] = if v > high[l] && v < f64::INFINITY { v } else { high[l] };
        }
    }
    let ends = low.iter().chain(&high).chain(rest).filter(|v| v.is_finite());
    ends.fold([first; 2], |[low, high], &v| [low.min(v), high.max(v)])
}
