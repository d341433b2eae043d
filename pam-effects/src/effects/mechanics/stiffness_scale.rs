//! The restoring force is off by a factor.

use crate::effects::{Absorbed, DataScales, Effect, EffectInfo, Hooks, Point, entry};
use pam_core::{AnyForce, JointModel, Scalar};

/// Restoring force `f · (1 + relative)`.
#[derive(Debug, Clone, Copy)]
pub struct StiffnessScale;

impl Effect for StiffnessScale {
    fn info(&self) -> &'static EffectInfo {
        const { entry("stiffness_scale") }
    }

    fn hooks(&self) -> Hooks {
        Hooks { force: true, ..Hooks::NONE }
    }

    fn starts(&self, _scales: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }

    fn force_mn<S: Scalar>(&self, p: &[S], at: &Point<'_, S>, _memory: &[S]) -> S {
        -(p[0] * at.restoring_mn())
    }

    fn absorb(&self, values: &[f64], joint: &mut JointModel<f64, AnyForce<f64>>) -> Absorbed {
        match joint.force.scaled(1.0 + values[0]) {
            Some(force) => {
                joint.force = force;
                Absorbed::Exactly
            }
            None => Absorbed::LeftOut,
        }
    }
}
