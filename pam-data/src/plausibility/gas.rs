//! How pressures follow the displacement: the isothermal law of sealed air, `P V(x) = const`.

use super::blocks::{Blocks, Regression, differences, squares, without_drift};
use super::settings::PlausibilitySettings;
use crate::recording::Recording;
use pam_core::{ForceModel, JointModel};

/// A way to read a pressure column: the absolute pressure is `scale · value + offset_kpa`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct PressureReading {
    pub(super) scale: f64,
    pub(super) offset_kpa: f64,
}

impl PressureReading {
    /// As the format states it.
    pub(super) const STATED: Self = Self { scale: 1.0, offset_kpa: 0.0 };

    pub(super) fn kpa(&self, value: f64) -> f64 {
        self.scale * value + self.offset_kpa
    }
}

/// The relation of one chamber's pressure to the displacement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ChamberSlope {
    /// Measured over isothermal change of `ln P` with x; 1 if the law holds, negative if the chamber answers in the
    /// wrong direction.
    pub(super) ratio: f64,
    /// Share of the motion that the pressure explains.
    pub(super) r2: f64,
    /// Phase between pressure and displacement, rad, from 0 (in phase or in antiphase) to π/2: the arc tangent of the ratio between the
    /// two terms of the regression, that in the rate of the pressure and that in the pressure.
    pub(super) phase: f64,
}

/// Slopes of the volumes, `−d ln V/dx` of flexor and extensor at a displacement, 1/mm.
pub(super) fn expected_slopes<F>(model: &JointModel<f64, F>, x: f64) -> [f64; 2]
where
    F: ForceModel<f64>,
{
    let nu = model.physical().deformation;
    let limit = 0.9 * model.geometry.displacement_limit_mm(nu);
    let v = model.geometry.volumes(x.clamp(-limit, limit), nu);
    [-v.flexor_slope_mm2 / v.flexor_mm3, -v.extensor_slope_mm2 / v.extensor_mm3]
}

/// The slope of `ln P` over x, measured over `expected` (1/mm).
///
/// The regression is inverse, `x = a + b ln P + c d(ln P)/dt + drift`, because sensors are lagged: if `ln P` is a
/// first-order low-pass of the gas law with any time constant, `1/b` is the slope of the law without the lag. Noise in
/// the pressure shrinks b by R²; half of that is put back, since noise in x does not.
///
/// `None` if the column does not change or is not positive under this reading.
pub(super) fn chamber_slope(
    x: &[f64],
    values: &[f64],
    reading: PressureReading,
    expected: f64,
) -> Option<ChamberSlope> {
    if values.iter().any(|v| reading.kpa(*v) <= 0.0) {
        return None;
    }
    let logs: Vec<f64> = values.iter().map(|v| reading.kpa(*v).ln()).collect();
    let rate = without_drift(&differences(&logs));
    let (x, logs) = (without_drift(x), without_drift(&logs));
    // Rounding leaves something of a constant column.
    if squares(&logs) < 1e-18 * logs.len() as f64 {
        return None;
    }
    let fit = Regression::new(&x, &[&logs, &rate])?;
    let slope = 1.0 / fit.coefficients[0];
    let ratio = slope / expected * fit.r2.sqrt();
    let part = |k: usize, of: &[f64]| fit.coefficients[k].abs() * squares(of).sqrt();
    let phase = part(1, &rate).atan2(part(0, &logs));
    ratio.is_finite().then_some(ChamberSlope { ratio, r2: fit.r2, phase })
}

/// The deformation coefficients ν that flexor and extensor imply if `offset_kpa` is added to their pressures: near x = 0 the
/// gas law makes `d ln P/dx` of the flexor `−(2ν − 1)/L0`, and the extensor mirrors it. `None` if the recording is too short,
/// or a pressure is constant or not positive.
pub(crate) fn implied_deformation(
    recording: &Recording,
    offset_kpa: f64,
    length_mm: f64,
) -> Option<[f64; 2]> {
    let blocks = Blocks::new(recording, 1.0, &PlausibilitySettings::default())?;
    let reading = PressureReading { scale: 1.0, offset_kpa };
    let slope =
        |i: usize| Some(chamber_slope(&blocks.x, &blocks.pressures[i], reading, 1.0)?.ratio);
    Some([-slope(0)?, slope(1)?].map(|slope| 0.5 * (1.0 + length_mm * slope)))
}

/// The change of a pressure relative to what the motion would cause in a sealed chamber; 0 for a dead sensor.
pub(super) fn response(blocks: &Blocks, chamber: usize, expected: f64) -> f64 {
    let values = &blocks.pressures[chamber];
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let (x, p) = (without_drift(&blocks.x), without_drift(values));
    (squares(&p) / squares(&x)).sqrt() / (mean * expected).abs()
}
