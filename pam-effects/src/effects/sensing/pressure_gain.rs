//! The pressure sensors are off by a factor.

use crate::effects::{DataScales, Effect, EffectInfo, Hooks, Observed, Rest, entry};
use pam_core::Scalar;
use pam_core::units::ATMOSPHERE_KPA;

/// Measured gauge pressure is `(1 + relative)` times the true one; the sealed masses follow from true
/// pressures.
#[derive(Debug, Clone, Copy)]
pub struct PressureGain;

impl Effect for PressureGain {
    fn info(&self) -> &'static EffectInfo {
        const { entry("pressure_gain") }
    }

    fn stands(&self, values: &[f64], _scales: &DataScales) -> bool {
        // A sensor that is off by a fifth is broken, not out of calibration.
        values.iter().all(|relative| relative.abs() <= 0.2)
    }

    fn hooks(&self) -> Hooks {
        Hooks { rest: true, observe: true, ..Hooks::NONE }
    }

    fn starts(&self, _scales: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![0.0, 0.0]]
    }

    fn rest<S: Scalar>(&self, p: &[S], rest: &mut Rest<S>) {
        let atmosphere = S::constant(ATMOSPHERE_KPA);
        for (i, &relative) in p.iter().enumerate() {
            let gain = relative + S::constant(1.0);
            for reading in [&mut rest.sealed_kpa[i], &mut rest.start_kpa[i]] {
                *reading = atmosphere + (*reading - atmosphere) / gain;
            }
        }
    }

    fn observe<S: Scalar>(&self, p: &[S], seen: &mut Observed<'_, S>) {
        let atmosphere = S::constant(ATMOSPHERE_KPA);
        for (series, &relative) in seen.pressures_kpa.iter_mut().zip(p) {
            series.iter_mut().for_each(|p| *p += relative * (*p - atmosphere));
        }
    }
}
