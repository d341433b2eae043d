//! A low-pass in the pressure sensors.

use super::low_passed;
use crate::effects::{DataScales, Effect, EffectInfo, Hooks, Observed, entry};
use pam_core::Scalar;
use std::f64::consts::TAU;

/// Both pressures through `1/(1 + s/(2π cutoff))`, in its steady state at the start.
#[derive(Debug, Clone, Copy)]
pub struct PressureSensorLag;

impl Effect for PressureSensorLag {
    fn info(&self) -> &'static EffectInfo {
        const { entry("pressure_sensor_lag") }
    }

    fn hooks(&self) -> Hooks {
        Hooks { observe: true, ..Hooks::NONE }
    }

    fn starts(&self, _scales: &DataScales) -> Vec<Vec<f64>> {
        [3.0, 15.0, 50.0].map(|f| vec![f]).to_vec()
    }

    fn observe<S: Scalar>(&self, p: &[S], seen: &mut Observed<'_, S>) {
        let rate = p[0].scaled(TAU * seen.step_s);
        for series in &mut seen.pressures_kpa {
            low_passed(rate, series);
        }
    }
}
