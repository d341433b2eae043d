use crate::trajectory::ExactStatistics;
use pam_solvers::TrajectoryFailure;

/// Losses of trajectories, with the gradient of their sum if it was asked for (zeros otherwise).
///
/// Trajectories that stopped early add nothing to the sum and its gradient. Derivatives are per unit of the
/// quantity: kg, kg/s, g, mm and mm/s.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ExactGradient {
    /// The sum of the losses.
    pub value: f64,
    /// The loss of each trajectory; NaN where it stopped early.
    pub values: Vec<f64>,
    /// With respect to the network's parameters, in the order of
    /// [`ParametricForce`](pam_core::ParametricForce).
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
    /// Segments, crossings and regions, summed over the trajectories.
    pub statistics: ExactStatistics,
    /// Bytes of the stored segments.
    pub stored_bytes: usize,
}
