//! The largest number of steps of a solve, by the length of its trajectory.

/// How many steps a trajectory may take.
///
/// A problem that is too stiff, or a model that is no model of the system, asks for ever smaller steps. A solve with a
/// budget stops with [`TooManySteps`](crate::FailureKind::TooManySteps) instead of running for ever.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepBudget {
    /// Steps per second of trajectory.
    pub per_s: f64,
    /// Steps that every trajectory may take, however short it is.
    pub least: usize,
    /// Steps between two samples of the input that a long trajectory with few samples may take on the average,
    /// besides `least`.
    pub per_sample: usize,
}

impl StepBudget {
    /// For Runge–Kutta methods under error control: ten steps a millisecond. The published excitation at tolerances of
    /// 1e-6 takes one half.
    pub const RUNGE_KUTTA: Self = Self { per_s: 1e4, least: 200_000, per_sample: 20 };
    /// For closed-form steps, which are fifty times cheaper.
    pub const CLOSED_FORM: Self = Self { per_s: 1e5, least: 2_000_000, per_sample: 200 };

    /// The largest number of steps of a trajectory of this length (s) with so many samples of its input.
    #[must_use]
    pub fn steps(&self, length_s: f64, samples: usize) -> usize {
        let by_samples = samples.saturating_mul(self.per_sample).saturating_add(self.least);
        // The cast saturates; NaN becomes zero.
        let by_time = (self.per_s * length_s) as usize;
        by_time.min(by_samples).max(self.least)
    }
}
