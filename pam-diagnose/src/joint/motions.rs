//! Motions of the joint that are simulated once and observed through several sensor effects.

use super::divergence::diverges;
use super::system::{JointSystem, is_absent};
use crate::error::DiagnoseError;
use crate::fit::Hypothesis;
use pam_core::Latest;
use pam_effects::simulation::{Trajectory, motion_until};
use std::sync::Arc;

/// The most recently used motions of a trial.
pub(super) type Motions = Latest<MotionKey, Trajectory<f64>>;

pub(super) fn latest() -> Motions {
    Latest::new(MOST)
}

/// Motions of a trial that are kept: sets of causes with different motions are fitted in turn.
const MOST: usize = 4;

/// The inputs of the simulation of a motion.
#[derive(PartialEq)]
pub(super) struct MotionKey {
    /// Addresses of the effects, which live as long as the system, and their ids: effects without a size share addresses.
    effects: Vec<usize>,
    ids: Vec<&'static str>,
    /// Bits of their values and of the nuisances.
    numbers: [Vec<u64>; 3],
    points: usize,
}

impl JointSystem<'_> {
    /// The motion of a trial under a hypothesis up to a number of grid points. Effects that act on sensors only do not enter.
    pub(super) fn motion(
        &self,
        hypothesis: &Hypothesis,
        local: &[f64],
        (experiment, points): (usize, usize),
    ) -> Result<Arc<Trajectory<f64>>, DiagnoseError> {
        let parts = self.parts(hypothesis, experiment);
        let (mut effects, mut values, mut first) = (Vec::new(), Vec::new(), 0);
        for effect in &parts.effects {
            let own = &parts.values[first..first + effect.info().value_len()];
            first += own.len();
            if !effect.hooks().leave_the_motion() && !is_absent(*effect, own) {
                effects.push(*effect);
                values.extend_from_slice(own);
            }
        }
        let bits = |all: &[f64]| all.iter().map(|v| v.to_bits()).collect::<Vec<u64>>();
        let key = MotionKey {
            effects: effects.iter().map(|e| std::ptr::from_ref(*e).cast::<()>() as usize).collect(),
            ids: effects.iter().map(|e| e.info().id).collect(),
            numbers: [&values, &hypothesis.shared, local].map(bits),
            points,
        };
        let (trial, nuisances) = (self.trials[experiment], Self::nuisances(hypothesis, local));
        self.motions[experiment].try_get(key, || {
            motion_until(trial, &self.base, &effects, &values, &nuisances, points)
                .map_err(|diverged| diverges(trial, diverged))
        })
    }
}
