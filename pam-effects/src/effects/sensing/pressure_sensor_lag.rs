//! A low-pass in the pressure sensors.

use crate::effects::{DataScales, Effect, EffectInfo, Observed, entry};
use pam_core::Scalar;

/// Both pressures through `1/(1 + s/(2π cutoff))`, in its steady state at the start.
#[derive(Debug, Clone, Copy)]
pub struct PressureSensorLag;

impl Effect for PressureSensorLag {
    fn info(&self) -> &'static EffectInfo {
        const { entry("pressure_sensor_lag") }
    }

    fn starts(&self, _scales: &DataScales) -> Vec<Vec<f64>> {
        [3.0, 15.0, 50.0].map(|f| vec![f]).to_vec()
    }

    fn observe<S: Scalar>(&self, p: &[S], seen: &mut Observed<'_, S>) {
        // Exact for an input that is a straight line between two values.
        let rate = p[0].scaled(std::f64::consts::TAU * seen.step_s);
        let keep = (-rate).exp();
        let ramp = (S::constant(1.0) - keep) / rate;
        for series in &mut seen.pressures_kpa {
            let (mut state, mut before) = (series[0], series[0]);
            for p in series.iter_mut() {
                let now = *p;
                state = now - ramp * (now - before) + keep * (state - before);
                before = now;
                *p = state;
            }
        }
    }
}
