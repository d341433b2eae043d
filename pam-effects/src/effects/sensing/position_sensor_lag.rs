//! A low-pass in the position sensor.

use super::low_passed;
use crate::effects::{DataScales, Effect, EffectInfo, Hooks, Observed, entry};
use pam_core::Scalar;
use std::f64::consts::TAU;

/// The displacement, and with it the velocity, through `1/(1 + s/(2π cutoff))`, in its steady state at the start.
#[derive(Debug, Clone, Copy)]
pub struct PositionSensorLag;

impl Effect for PositionSensorLag {
    fn info(&self) -> &'static EffectInfo {
        const { entry("position_sensor_lag") }
    }

    fn hooks(&self) -> Hooks {
        Hooks { observe: true, ..Hooks::NONE }
    }

    fn starts(&self, _scales: &DataScales) -> Vec<Vec<f64>> {
        [3.0, 15.0, 50.0].map(|f| vec![f]).to_vec()
    }

    fn observe<S: Scalar>(&self, p: &[S], seen: &mut Observed<'_, S>) {
        let rate = p[0].scaled(TAU * seen.step_s);
        low_passed(rate, seen.displacement_mm);
        low_passed(rate, seen.velocity_mm_s);
    }
}
