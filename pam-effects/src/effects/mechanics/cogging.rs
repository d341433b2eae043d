//! A force periodic in position.

use crate::effects::{DataScales, Effect, EffectInfo, Hooks, Point, entry};
use pam_core::Scalar;
use pam_core::units::MN_PER_N;

/// Force `−force_n sin(2π x / pitch_mm)`.
#[derive(Debug, Clone, Copy)]
pub struct Cogging;

impl Effect for Cogging {
    fn info(&self) -> &'static EffectInfo {
        const { entry("cogging") }
    }

    fn hooks(&self) -> Hooks {
        Hooks { force: true, ..Hooks::NONE }
    }

    fn starts(&self, scales: &DataScales) -> Vec<Vec<f64>> {
        scales
            .periodic_pitches_mm(3)
            .into_iter()
            .map(|(pitch, force)| vec![-force, pitch])
            .collect()
    }

    fn stands(&self, values: &[f64], scales: &DataScales) -> bool {
        // A period longer than the travel is only another shape of the stiffness.
        values[1] <= 2.0 * scales.travel_mm
    }

    fn force_mn<S: Scalar>(&self, p: &[S], at: &Point<'_, S>, _memory: &[S]) -> S {
        let phase = (at.displacement_mm / p[1]).scaled(std::f64::consts::TAU);
        -(p[0] * phase.sin()).scaled(MN_PER_N)
    }
}
