//! Smooth networks on surrogates of their force.

use super::sealed_states::SealedStates;
use super::{
    EngineError, EngineForce, GradientStatistics, GradientSums, IndexedLoss, TrajectoryEngine,
    TrajectoryGradient, TrajectoryRequest,
};
use crate::predict::surrogate_problem;
use pam_solvers::Interpolation;
use pam_surrogate::{SurrogateMotion, SurrogateSettings, SurrogateSolver};

/// Trajectories and gradients on piecewise polynomials of the force, for smooth networks with sealed chambers (see
/// [`pam_surrogate`]). Of the [statistics](GradientStatistics), evaluations of the network count as evaluations and patches
/// as linearised points. Everything runs in doubles; the force may not be read as cubic.
#[derive(Debug)]
pub struct SurrogateEngine {
    interpolation: Interpolation,
    solver: SurrogateSolver,
    states: SealedStates,
}

impl SurrogateEngine {
    /// An engine that reads the force between samples in this way.
    #[must_use]
    pub fn new(interpolation: Interpolation, settings: SurrogateSettings) -> Self {
        let solver = SurrogateSolver::new(settings);
        Self { interpolation, solver, states: SealedStates::default() }
    }
}

impl<F: EngineForce> TrajectoryEngine<F> for SurrogateEngine {
    fn evaluate(
        &mut self,
        request: &TrajectoryRequest<'_, F>,
        loss: &IndexedLoss<'_>,
        backward: bool,
    ) -> Result<TrajectoryGradient, EngineError> {
        request.check()?;
        let network = request.model.force.network().ok_or_else(|| {
            EngineError::Request("surrogates are for networks; take the general engine".into())
        })?;
        let motion = SurrogateMotion::new(request.model, network);
        let problems: Vec<_> = (0..request.len())
            .map(|k| {
                let s = request.subject(k);
                surrogate_problem(&s.recording, s.masses, self.interpolation, request.start(k))
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
                accepted: motion.statistics.steps,
                rejected: motion.statistics.rejected,
                evaluations: motion.statistics.evaluations,
                pullbacks: motion.statistics.patches,
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
