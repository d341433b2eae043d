//! A steady force.

use crate::effects::{Absorbed, DataScales, Effect, EffectInfo, Hooks, Point, entry};
use pam_core::units::MN_PER_N;
use pam_core::{AnyForce, JointModel, Scalar};

/// Force `force_n` in the direction of +x.
#[derive(Debug, Clone, Copy)]
pub struct ConstantLoad;

impl Effect for ConstantLoad {
    fn info(&self) -> &'static EffectInfo {
        const { entry("constant_load") }
    }

    fn hooks(&self) -> Hooks {
        Hooks { force: true, ..Hooks::NONE }
    }

    fn starts(&self, _scales: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }

    fn force_mn<S: Scalar>(&self, p: &[S], _at: &Point<'_, S>, _memory: &[S]) -> S {
        p[0].scaled(MN_PER_N)
    }

    fn absorb(&self, values: &[f64], joint: &mut JointModel<f64, AnyForce<f64>>) -> Absorbed {
        // The restoring force is on the other side of the equation of motion.
        match joint.force.shifted(-values[0] * MN_PER_N) {
            Some(force) => {
                joint.force = force;
                Absorbed::Exactly
            }
            None => Absorbed::LeftOut,
        }
    }
}
