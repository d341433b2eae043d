//! Laws that were written without knowledge of the search, and chosen before any file of the project was read.

use super::shared::{
    cross_leak, cubic_spring, force_in_reading, pressure_damping, pressure_friction,
    quadratic_drag, soft_stop, warm_grease, worn_guide,
};
use super::{HiddenLaw, law};

/// Ten laws that were written without knowledge of the search or of the earlier lists, two of them with memory, at other pressures.
///
/// # Panics
/// Never.
#[must_use]
pub fn tenth_outside() -> Vec<HiddenLaw> {
    let mut all = vec![
        quadratic_drag(0.045, 0.03),
        cubic_spring(4.0, 100.0, 2.8),
        pressure_friction(0.012, 8e-3),
        worn_guide(5.0, 3.5),
        pressure_damping(1e-3, 7e-4),
        soft_stop([12.0, 0.6], 8.0, [0.5, 0.75]),
        cross_leak(1.2e-6, 8e-7),
        force_in_reading("frame_give", 4e-4, 2.8e-4),
        warm_grease(6.0, [4.0, 8.0]),
        HiddenLaw {
            // The velocity times the step is the change of x.
            remembers: true,
            or: &["x"],
            ..law(
                "bristle_friction",
                &[("n", 8.0), ("bend_mm", 0.3)],
                "parameters.n = { range = [0, 500], absent = 0, start = [5.5] }\nparameters.bend_mm = { range = [0.01, 10], log = true, start = [0.2, 0.4] }\nmemory.z = { start = \"0\", rate = \"(v - abs(v) * z) / bend_mm\" }\nacts.force_n = \"-n * z\"",
                &["v"],
            )
        },
    ];
    all.iter_mut().for_each(|law| law.psi = CONDITIONS);
    all
}

/// Gauge pressures of the recordings of [`tenth_outside`], psi.
const CONDITIONS: [[f64; 2]; 3] = [[36.0, 58.0], [64.0, 47.0], [52.0, 73.0]];
