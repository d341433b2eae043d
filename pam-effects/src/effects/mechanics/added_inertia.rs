//! Mass that the model lacks.

use crate::effects::{Absorbed, DataScales, Effect, EffectInfo, Hooks, entry};
use pam_core::{AnyForce, JointModel, PhysicalParameters, Scalar};

/// Inertia `m + mass_kg`.
#[derive(Debug, Clone, Copy)]
pub struct AddedInertia;

impl Effect for AddedInertia {
    fn info(&self) -> &'static EffectInfo {
        const { entry("added_inertia") }
    }

    fn hooks(&self) -> Hooks {
        Hooks { constants: true, ..Hooks::NONE }
    }

    fn starts(&self, _scales: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![0.0]]
    }

    fn inertia_kg<S: Scalar>(&self, p: &[S]) -> S {
        p[0]
    }

    fn absorb(&self, values: &[f64], joint: &mut JointModel<f64, AnyForce<f64>>) -> Absorbed {
        let physical = joint.physical();
        let mass_kg = physical.mass_kg + values[0];
        joint.raw = PhysicalParameters { mass_kg, ..physical }.to_raw();
        Absorbed::Exactly
    }
}
