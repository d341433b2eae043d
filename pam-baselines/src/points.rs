//! Points of the equation of motion in recordings: smoothed state, acceleration and force.

use pam_core::{ForceInput, SealedMasses};
use pam_data::Recording;
use pam_data::preprocess::{LowPass, gradient};
use pam_data::recording::median_step_s;

/// Cutoff of the smoothing, Hz: a first-order low-pass, forward and back, twice.
const CUTOFF_HZ: f64 = 20.0;

/// One point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionPoint {
    /// Displacement x, mm.
    pub displacement_mm: f64,
    /// Velocity ẋ, mm/s.
    pub velocity_mm_s: f64,
    /// Acceleration ẍ, mm/s².
    pub acceleration_mm_s2: f64,
    /// External force, mN.
    pub force_mn: f64,
    /// Pressures of flexor and extensor, kPa absolute.
    pub pressures_kpa: [f64; 2],
}

impl MotionPoint {
    /// The point with the air of its recording, for force models.
    #[must_use]
    pub fn input(&self, masses: SealedMasses) -> ForceInput<f64> {
        ForceInput {
            displacement_mm: self.displacement_mm,
            velocity_mm_s: self.velocity_mm_s,
            mass_flexor_g: masses.flexor_g,
            mass_extensor_g: masses.extensor_g,
        }
    }
}

/// Points of a recording every `spacing_s`. Displacement and force are smoothed alike, so that what is
/// linear in the equation of motion is not biased; the ends, which the filter makes up, are left out.
#[must_use]
pub fn motion_points(r: &Recording, spacing_s: f64) -> Vec<MotionPoint> {
    let step = median_step_s(&r.time_s);
    let smooth = |values: &[f64]| match LowPass::new(CUTOFF_HZ, 1.0 / step) {
        Some(filter) if values.len() >= LowPass::shortest() => {
            filter.forward_backward(&filter.forward_backward(values))
        }
        _ => values.to_vec(),
    };
    let x = smooth(&r.displacement_mm);
    let force = smooth(&r.force_mn);
    let v = gradient(&x, step);
    let a = gradient(&v, step);
    let stride = ((spacing_s / step).round() as usize).max(1);
    let edge = (2.0 / (CUTOFF_HZ * step)).ceil() as usize;
    (edge..r.len().saturating_sub(edge))
        .step_by(stride)
        .map(|k| MotionPoint {
            displacement_mm: x[k],
            velocity_mm_s: v[k],
            acceleration_mm_s2: a[k],
            force_mn: force[k],
            pressures_kpa: [r.pressure_flexor_kpa[k], r.pressure_extensor_kpa[k]],
        })
        .collect()
}
