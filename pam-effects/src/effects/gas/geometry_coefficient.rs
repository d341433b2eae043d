//! The deformation coefficient is off.

use crate::effects::{Absorbed, ChamberLaw, DataScales, Effect, EffectInfo, Hooks, entry};
use pam_core::{AnyForce, JointModel, PhysicalParameters, Scalar};

/// `ν (1 + relative)` in the volumes, with or without the force of the changed pressure on the joint.
#[derive(Debug, Clone, Copy)]
pub struct GeometryCoefficient;

impl Effect for GeometryCoefficient {
    fn info(&self) -> &'static EffectInfo {
        const { entry("geometry_coefficient") }
    }

    fn changes_gas(&self) -> bool {
        true
    }

    fn hooks(&self) -> Hooks {
        Hooks { constants: true, ..Hooks::NONE }
    }

    fn starts(&self, _scales: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![0.0, 0.0], vec![0.0, 1.0]]
    }

    fn chamber<S: Scalar>(&self, p: &[S], law: &mut ChamberLaw<S>) {
        law.deformation_factor *= p[0] + S::constant(1.0);
        law.feeds_back |= p[1].real() > 0.5;
    }

    fn absorb(&self, values: &[f64], joint: &mut JointModel<f64, AnyForce<f64>>) -> Absorbed {
        // The force of the changed pressures on the joint is none of the network's.
        if values[1] > 0.5 {
            return Absorbed::LeftOut;
        }
        let physical = joint.physical();
        let deformation = physical.deformation * (1.0 + values[0]);
        joint.raw = PhysicalParameters { deformation, ..physical }.to_raw();
        Absorbed::Exactly
    }
}
