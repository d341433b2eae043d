//! The force is off by a factor.

use crate::effects::{Command, DataScales, Effect, EffectInfo, Hooks, entry};
use pam_core::Scalar;

/// Real force `(1 + relative)` times the commanded one.
#[derive(Debug, Clone, Copy)]
pub struct ForceGain;

impl Effect for ForceGain {
    fn info(&self) -> &'static EffectInfo {
        const { entry("force_gain") }
    }

    fn hooks(&self) -> Hooks {
        Hooks { drive: true, ..Hooks::NONE }
    }

    fn starts(&self, _scales: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }

    fn drive<S: Scalar>(&self, p: &[S], command: &Command<S>, _memory: &mut [S]) -> S {
        command.force_mn + p[0] * command.force_mn
    }
}
