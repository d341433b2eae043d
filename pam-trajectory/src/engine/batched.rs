//! Networks with sealed chambers, trajectories in batches.

use super::sealed_states::SealedStates;
use super::{
    EngineError, EngineForce, GradientStatistics, GradientSums, IndexedLoss, Precision,
    TrajectoryEngine, TrajectoryGradient, TrajectoryRequest,
};
use crate::predict::SolverSettings;
use pam_autodiff::batch::SealedMotion;
use pam_autodiff::batch::sealed_motion::{DAMPING, MASS};
use pam_core::Activation;
use pam_core::simd::Float;
use pam_solvers::input::InputError;
use pam_solvers::{
    BatchGradient, BatchWorkspace, BatchedIntegrator, SampledInput, TrajectoryProblem,
};

/// Trajectories in batches and their discrete adjoint, for networks with sealed chambers. The network runs in
/// `T`, everything else in doubles.
///
/// The motion `[x, ẋ]` is integrated, and tolerances hold for it; the pressures follow from the gas law
/// ([`SealedGas`](super::pressures::SealedGas)).
#[derive(Debug)]
pub struct BatchedEngine<T: Float> {
    settings: SolverSettings,
    memory: BatchWorkspace<SealedMotion<T>>,
    states: SealedStates,
}

impl<T: Float> BatchedEngine<T> {
    /// An engine with this method, step control and reading of the force.
    #[must_use]
    pub fn new(settings: SolverSettings) -> Self {
        Self { settings, memory: BatchWorkspace::default(), states: SealedStates::default() }
    }

    fn integrate<F: EngineForce>(
        &mut self,
        request: &TrajectoryRequest<'_, F>,
        loss: &IndexedLoss<'_>,
        backward: bool,
    ) -> Result<BatchGradient, EngineError> {
        let network = request.model.force.network().ok_or_else(|| {
            EngineError::Request("the batched engine is for networks; take the general one".into())
        })?;
        let controller = self.settings.step.controller().ok_or_else(|| {
            EngineError::Request("the closed form has an engine of its own".into())
        })?;
        let mut integrator = BatchedIntegrator::new(self.settings.tableau.clone(), controller);
        if let Some(budget) = self.settings.step_budget() {
            let of_window = |k: usize| {
                let r = &request.subject(k).recording;
                let (t0, t1) = r.span_s();
                budget.steps(t1 - t0, r.len())
            };
            let most = (0..request.len()).map(of_window).max().unwrap_or(0);
            integrator = integrator.with_max_steps(most).with_step_budget(budget);
        }
        let motion = SealedMotion::<T, Activation>::new(request.model, network);
        let problems = (0..request.len())
            .map(|k| {
                let (s, y0) = (request.subject(k), request.start(k));
                let r = &s.recording;
                let (t0, t1) = r.span_s();
                Ok(TrajectoryProblem {
                    condition: motion.condition(s.masses),
                    input: SampledInput::new(&r.time_s, &r.force_mn, self.settings.interpolation)?,
                    t0,
                    t1,
                    y0: vec![y0[0], y0[1]],
                    observe_s: &r.time_s,
                })
            })
            .collect::<Result<Vec<_>, InputError>>()?;
        self.states.reserve(problems.len());
        let loss = self.states.loss_of_motion(request, loss, backward);
        Ok(integrator.evaluate(&motion, &problems, &loss, &mut self.memory, backward))
    }
}

impl<T: Float, F: EngineForce> TrajectoryEngine<F> for BatchedEngine<T> {
    fn evaluate(
        &mut self,
        request: &TrajectoryRequest<'_, F>,
        loss: &IndexedLoss<'_>,
        backward: bool,
    ) -> Result<TrajectoryGradient, EngineError> {
        request.check()?;
        let motion = self.integrate(request, loss, backward)?;
        let mut force = motion.shared;
        let physical = force.split_off(force.len() - 2);
        let sums = GradientSums {
            force,
            joint: [physical[MASS], 0.0, 0.0],
            auxiliary_damping: physical[DAMPING],
            masses: motion.own.iter().map(|g| [g[0], g[1]]).collect(),
            initial_states: motion.initial_state.iter().map(|y| [y[0], y[1], 0.0, 0.0]).collect(),
            values: motion.values,
            failures: motion.failures,
            statistics: GradientStatistics {
                accepted: motion.accepted,
                rejected: motion.rejected,
                evaluations: motion.evaluations,
                pullbacks: motion.linearised,
                stored_bytes: motion.stored_bytes,
            },
            ..GradientSums::default()
        };
        Ok(self.states.mean_with_pressures(request.model, sums))
    }

    fn predicted(&mut self, index: usize) -> &[[f64; 4]] {
        self.states.of(index)
    }

    fn precision(&self) -> Precision {
        if size_of::<T>() == size_of::<f32>() { Precision::F32 } else { Precision::F64 }
    }
}
