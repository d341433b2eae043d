//! A force proportional to the velocity.

use crate::effects::{Absorbed, DataScales, Effect, EffectInfo, Hooks, Point, entry};
use pam_core::{AnyForce, JointModel, Scalar};

/// Force `−coefficient · ẋ`.
#[derive(Debug, Clone, Copy)]
pub struct ViscousDamping;

impl Effect for ViscousDamping {
    fn info(&self) -> &'static EffectInfo {
        const { entry("viscous_damping") }
    }

    fn hooks(&self) -> Hooks {
        Hooks { force: true, ..Hooks::NONE }
    }

    fn starts(&self, _scales: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }

    fn force_mn<S: Scalar>(&self, p: &[S], at: &Point<'_, S>, _memory: &[S]) -> S {
        // 1 N·s/m = 1 mN·s/mm.
        -(p[0] * at.velocity_mm_s)
    }

    fn absorb(&self, values: &[f64], joint: &mut JointModel<f64, AnyForce<f64>>) -> Absorbed {
        joint.auxiliary_damping_kg_s += values[0];
        Absorbed::Exactly
    }
}
