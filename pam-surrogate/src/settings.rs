//! Accuracy and bounds.

use pam_solvers::StepBudget;

/// Accuracy of surrogates and steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SurrogateSettings {
    /// Largest error of the force between the nodes of a patch, mN. What its cells and left-out terms add stays well below.
    pub force_error_mn: f64,
    /// Largest error of a step by the embedded method, mm; of a velocity at the rate of the joint.
    pub step_error_mm: f64,
    /// Longest step, s.
    pub longest_step_s: f64,
    /// Most patches of one trajectory; a force that needs more is too rough for a surrogate.
    pub most_patches: usize,
    /// Most steps of one trajectory.
    pub budget: StepBudget,
}

impl Default for SurrogateSettings {
    fn default() -> Self {
        Self {
            force_error_mn: 0.05,
            step_error_mm: 5e-9,
            longest_step_s: 0.02,
            most_patches: 4000,
            budget: StepBudget::RUNGE_KUTTA,
        }
    }
}
