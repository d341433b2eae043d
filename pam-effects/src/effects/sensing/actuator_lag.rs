//! A low-pass between command and force.

use super::low_pass_step;
use crate::effects::{Command, DataScales, Effect, EffectInfo, Hooks, entry};
use pam_core::Scalar;
use std::f64::consts::TAU;

/// `dF/dt = 2π cutoff (F_commanded − F)`, from the first command on. The memory is command and force of the last
/// instant.
#[derive(Debug, Clone, Copy)]
pub struct ActuatorLag;

impl Effect for ActuatorLag {
    fn info(&self) -> &'static EffectInfo {
        const { entry("actuator_lag") }
    }

    fn hooks(&self) -> Hooks {
        Hooks { drive: true, ..Hooks::NONE }
    }

    fn starts(&self, _scales: &DataScales) -> Vec<Vec<f64>> {
        [2.0, 8.0, 30.0].map(|f| vec![f]).to_vec()
    }

    fn memory_len(&self) -> usize {
        2
    }

    fn drive<S: Scalar>(&self, p: &[S], command: &Command<S>, memory: &mut [S]) -> S {
        let Command { since_s, force_mn, .. } = *command;
        let real = if since_s > 0.0 {
            low_pass_step(p[0].scaled(TAU * since_s), memory[0], force_mn, memory[1])
        } else {
            force_mn
        };
        memory.copy_from_slice(&[force_mn, real]);
        real
    }
}
