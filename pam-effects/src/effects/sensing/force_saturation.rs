//! The force is clipped.

use crate::effects::{Command, DataScales, Effect, EffectInfo, Hooks, entry};
use pam_core::Scalar;
use pam_core::units::MN_PER_N;
use pam_numerics::statistics::root_mean_square;

/// Largest limit, relative to the largest force.
const HIGHEST: f64 = 0.95;
/// Smallest RMS excess of the clipped samples over the limit, relative to the limit. A sine clipped at nine tenths of its amplitude has 0.08. For a
/// limit at the amplitude, it is at most the relative noise of the force sensor.
const LEAST_CUT: f64 = 0.05;

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
        let limit = values[0];
        let beyond = scales.force_quantiles_n.iter().map(|f| f - limit).filter(|cut| *cut > 0.0);
        let beyond: Vec<f64> = beyond.collect();
        // A limit that only the last few percent of the peaks reach does what any small error does where the joint turns. One at the
        // amplitude of the force cuts off the noise of its sensor, which improves every prediction.
        limit < HIGHEST * scales.peak_force_n && root_mean_square(&beyond) > LEAST_CUT * limit
    }

    fn drive<S: Scalar>(&self, p: &[S], command: &Command<S>, _memory: &mut [S]) -> S {
        let limit = p[0].scaled(MN_PER_N);
        command.force_mn.clamped(-limit, limit)
    }
}
