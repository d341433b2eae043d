//! The pressures come late.

use crate::effects::{DataScales, Effect, EffectInfo, Observed, entry};
use pam_core::Scalar;

/// Both pressures are shown `delay` later.
#[derive(Debug, Clone, Copy)]
pub struct PressureDelay;

impl Effect for PressureDelay {
    fn info(&self) -> &'static EffectInfo {
        const { entry("pressure_delay") }
    }

    fn starts(&self, _scales: &DataScales) -> Vec<Vec<f64>> {
        vec![vec![1.0], vec![30.0]]
    }

    fn observe<S: Scalar>(&self, p: &[S], seen: &mut Observed<'_, S>) {
        let shift = p[0].scaled(1e-3 / seen.step_s);
        let whole = shift.real().floor();
        let part = shift - S::constant(whole);
        let whole = whole as usize;
        for series in &mut seen.pressures_kpa {
            let first = series[0];
            for k in (0..series.len()).rev() {
                let at = |back: usize| if back <= k { series[k - back] } else { first };
                let (near, far) = (at(whole), at(whole + 1));
                series[k] = near + part * (far - near);
            }
        }
    }
}
