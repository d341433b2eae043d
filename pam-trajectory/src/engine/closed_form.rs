//! The closed form of (leaky) ReLU networks.

use super::sealed_states::SealedStates;
use super::{
    EngineError, GradientStatistics, GradientSums, IndexedLoss, TrajectoryEngine,
    TrajectoryGradient, TrajectoryRequest,
};
use crate::predict::exact_problem;
use pam_core::ForceModel;
use pam_exact::{ExactMotion, ExactSolver};
use pam_solvers::Interpolation;

/// Trajectories and gradients in closed form, for (leaky) ReLU networks with sealed chambers (see
/// [`pam_exact`]). There are no steps: of the [statistics](GradientStatistics), segments count as steps, region
/// crossings as evaluations and regions as linearised points. Everything runs in doubles; the force may not be
/// read as cubic.
#[derive(Debug)]
pub struct ClosedFormEngine {
    interpolation: Interpolation,
    solver: ExactSolver,
    states: SealedStates,
}

impl ClosedFormEngine {
    /// An engine that reads the force between samples in this way.
    #[must_use]
    pub fn new(interpolation: Interpolation) -> Self {
        Self { interpolation, solver: ExactSolver::new(), states: SealedStates::default() }
    }
}

impl<F: ForceModel<f64> + Sync> TrajectoryEngine<F> for ClosedFormEngine {
    fn evaluate(
        &mut self,
        request: &TrajectoryRequest<'_, F>,
        loss: &IndexedLoss<'_>,
        backward: bool,
    ) -> Result<TrajectoryGradient, EngineError> {
        request.check()?;
        let motion = ExactMotion::new(request.model)?;
        let problems: Vec<_> = (0..request.len())
            .map(|k| {
                let s = request.subject(k);
                exact_problem(&s.recording, s.masses, self.interpolation, request.start(k))
            })
            .collect();
        self.states.reserve(problems.len());
        let motion = {
            let loss = self.states.loss_of_motion(request, loss, backward);
            self.solver.evaluate(&motion, &problems, &loss, backward)
        };
        let sums = GradientSums {
            force: motion.network,
            joint: [motion.mass, 0.0, 0.0],
            auxiliary_damping: motion.damping,
            masses: motion.masses,
            initial_states: motion.initial_states.iter().map(|y| [y[0], y[1], 0.0, 0.0]).collect(),
            values: motion.values,
            failures: motion.failures,
            statistics: GradientStatistics {
                accepted: motion.statistics.segments,
                rejected: 0,
                evaluations: motion.statistics.crossings,
                pullbacks: motion.statistics.regions,
                stored_bytes: motion.stored_bytes,
            },
            ..GradientSums::default()
        };
        Ok(self.states.mean_with_pressures(request.model, sums))
    }

    fn predicted(&mut self, index: usize) -> &[[f64; 4]] {
        self.states.of(index)
    }
}
