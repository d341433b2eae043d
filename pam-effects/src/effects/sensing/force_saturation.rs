//! The force is clipped.

use crate::effects::{Command, DataScales, Effect, EffectInfo, Hooks, entry};
use pam_core::Scalar;
use pam_core::units::MN_PER_N;

/// Real force clipped at ± `force_n`.
#[derive(Debug, Clone, Copy)]
pub struct ForceSaturation;

impl Effect for ForceSaturation {
    fn info(&self) -> &'static EffectInfo {
        const { entry("force_saturation") }
    }

    fn hooks(&self) -> Hooks {
        Hooks { drive: true, ..Hooks::NONE }
    }

    fn starts(&self, scales: &DataScales) -> Vec<Vec<f64>> {
        [0.5, 0.75, 0.92].map(|share| vec![share * scales.peak_force_n]).to_vec()
    }

    fn stands(&self, values: &[f64], scales: &DataScales) -> bool {
        // A limit that only the last few percent of the peaks reach does what any small error does where the joint turns.
        values[0] < 0.95 * scales.peak_force_n
    }

    fn drive<S: Scalar>(&self, p: &[S], command: &Command<S>, _memory: &mut [S]) -> S {
        let limit = p[0].scaled(MN_PER_N);
        command.force_mn.clamped(-limit, limit)
    }
}
