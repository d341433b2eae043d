//! The largest number of steps of a solve, by the length of its trajectory.

/// How many steps a trajectory may take until a time.
///
/// A problem that is too stiff, or a model that is no model of the system, asks for ever smaller steps. A solve with a
/// budget stops with [`TooManySteps`](crate::FailureKind::TooManySteps) soon after the steps have become too small to
/// reach the end, instead of running for ever.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepBudget {
    /// Steps per second of trajectory.
    pub per_s: f64,
    /// Steps besides, for stretches that need more.
    pub burst: usize,
    /// Steps between two samples of the input that a long trajectory with few samples may take on the average, besides
    /// `least`.
    pub per_sample: usize,
    /// Steps that every whole trajectory may take, however short it is.
    pub least: usize,
}

impl StepBudget {
    /// For Runge–Kutta methods under error control: five steps a millisecond. The published excitation at tolerances of
    /// 1e-6 takes one half, and one more at each sample of a force that is held.
    pub const RUNGE_KUTTA: Self =
        Self { per_s: 5e3, burst: 50_000, per_sample: 20, least: 100_000 };
    /// For Runge–Kutta methods at a tolerance: [`RUNGE_KUTTA`](Self::RUNGE_KUTTA) down to 1e-6, and more below as the steps of a
    /// method of second order get shorter, which is what kinks of force and input leave of any order.
    #[must_use]
    pub fn at_tolerance(tolerance: f64) -> Self {
        let factor = (1e-6 / tolerance).cbrt().max(1.0);
        let more = |count: usize| (count as f64 * factor) as usize;
        let usual = Self::RUNGE_KUTTA;
        Self {
            per_s: usual.per_s * factor,
            burst: more(usual.burst),
            per_sample: more(usual.per_sample),
            least: more(usual.least),
        }
    }

    /// For constant steps, whose size is asked for: 33 µs on the average. The network of the default model takes 3 µs a
    /// step.
    pub const CONSTANT: Self = Self { per_s: 3e4, burst: 500_000, per_sample: 100, least: 500_000 };

    /// For closed-form steps, which are fifty times cheaper.
    pub const CLOSED_FORM: Self =
        Self { per_s: 1e5, burst: 500_000, per_sample: 200, least: 2_000_000 };

    /// The largest number of steps of a trajectory of this length (s) with so many samples of its input.
    #[must_use]
    pub fn steps(&self, length_s: f64, samples: usize) -> usize {
        let by_samples = samples.saturating_mul(self.per_sample).saturating_add(self.least);
        self.until(length_s).min(by_samples).max(self.least)
    }

    /// The largest number of steps until a time since the start, s.
    #[inline]
    #[must_use]
    pub fn until(&self, elapsed_s: f64) -> usize {
        // The cast saturates; NaN becomes zero.
        ((self.per_s * elapsed_s) as usize).saturating_add(self.burst)
    }
}

/// The limits of a solve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StepLimit {
    pub(crate) max_steps: usize,
    pub(crate) budget: Option<StepBudget>,
}

impl Default for StepLimit {
    /// At most 10 million steps.
    fn default() -> Self {
        Self { max_steps: 10_000_000, budget: None }
    }
}

impl StepLimit {
    /// The largest number of steps until a time since the start, s.
    #[inline]
    pub(crate) fn until(&self, elapsed_s: f64) -> usize {
        self.budget.map_or(self.max_steps, |budget| budget.until(elapsed_s).min(self.max_steps))
    }
}
