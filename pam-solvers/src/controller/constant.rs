use super::{Decision, StepController, Tolerances};

/// Steps of one size; a step is shortened only to end at a stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConstantStep {
    step_s: f64,
}

impl ConstantStep {
    /// Steps of `step_s` seconds.
    #[must_use]
    pub fn new(step_s: f64) -> Self {
        Self { step_s }
    }
}

impl StepController for ConstantStep {
    fn initial_step_s(&self) -> Option<f64> {
        Some(self.step_s)
    }
    fn largest_step_s(&self) -> f64 {
        self.step_s
    }
    fn tolerances(&self) -> Option<&Tolerances> {
        None
    }
    fn decide(&self, _error: f64, _history: [f64; 2], _order: usize) -> Decision {
        Decision { accept: true, factor: 1.0 }
    }
}
