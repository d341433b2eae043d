//! Losses, gradients and counts.

use crate::run::Solved;
use pam_solvers::TrajectoryFailure;

/// Work that was done.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SurrogateStatistics {
    /// Accepted steps.
    pub steps: usize,
    /// Rejected steps.
    pub rejected: usize,
    /// Patches of the surrogates.
    pub patches: usize,
    /// Evaluations of the network.
    pub evaluations: usize,
}

/// Losses of trajectories, with the gradient of their sum if it was asked for (zeros otherwise).
///
/// Trajectories that stopped early add nothing to the sum and its gradient. Derivatives are per unit of the quantity: kg,
/// kg/s, g, mm and mm/s.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SurrogateGradient {
    /// The loss of each trajectory; NaN where it stopped early.
    pub values: Vec<f64>,
    /// With respect to the network's parameters, in the order of [`ParametricForce`](pam_core::ParametricForce).
    pub network: Vec<f64>,
    /// With respect to m.
    pub mass: f64,
    /// With respect to B.
    pub damping: f64,
    /// With respect to `[m_f, m_e]` of each trajectory.
    pub masses: Vec<[f64; 2]>,
    /// With respect to `[x, ẋ]` at the start of each trajectory.
    pub initial_states: Vec<[f64; 2]>,
    /// Trajectories that stopped early.
    pub failures: Vec<TrajectoryFailure>,
    /// Trajectories whose force is too rough for a surrogate of the asked accuracy; they are among the failures.
    pub rough: Vec<usize>,
    /// Sums over the trajectories.
    pub statistics: SurrogateStatistics,
    /// Bytes of the stored steps.
    pub stored_bytes: usize,
}

impl SurrogateGradient {
    /// Adds the next trajectory.
    pub(crate) fn add(&mut self, one: &Solved, per_mass: f64) {
        let stopped = one.stop.is_some() || one.refused.is_some();
        self.values.push(if stopped { f64::NAN } else { one.value });
        self.masses.push(one.masses);
        self.initial_states.push(one.sums.start);
        self.network.iter_mut().zip(&one.network).for_each(|(s, g)| *s += g);
        // m = 1/β.
        self.mass -= per_mass * per_mass * one.sums.per_mass;
        self.damping += one.sums.damping;
        let total = &mut self.statistics;
        total.steps += one.statistics.steps;
        total.rejected += one.statistics.rejected;
        total.patches += one.statistics.patches;
        total.evaluations += one.statistics.evaluations;
        self.stored_bytes += one.stored_bytes;
    }
}
