//! The result of a simulation.

use thiserror::Error;

/// The channels at the grid points, as the sensors would show them: mm, mm/s, kPa, kPa.
#[derive(Debug, Clone)]
pub struct Trajectory<S> {
    /// In the order of the state.
    pub channels: [Vec<S>; 4],
}

impl<S> Default for Trajectory<S> {
    fn default() -> Self {
        Self { channels: [const { Vec::new() }; 4] }
    }
}

/// A simulation that left the range of the joint.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("the simulation diverges at t = {time_s:.3} s")]
pub struct Diverged {
    /// The time, s.
    pub time_s: f64,
}
