//! Laws that were written without knowledge of the search, and chosen as the most plausible ones before any file was opened.

use super::shared::{
    cross_leak, cubic_spring, quadratic_drag, side_volume, soft_stop, warm_grease, worn_guide,
};
use super::{HiddenLaw, law};

/// Ten laws that were written without knowledge of the search or of the earlier lists, two of them with memory, at other pressures.
///
/// # Panics
/// Never.
#[must_use]
pub fn twelfth_outside() -> Vec<HiddenLaw> {
    let mut all = vec![
        cubic_spring(4.0, 100.0, 2.8),
        quadratic_drag(0.05, 0.035),
        soft_stop([16.0, 0.7], 11.0, [0.55, 0.85]),
        worn_guide(4.5, 3.0),
        cross_leak(1.1e-6, 8e-7),
        HiddenLaw {
            // The candidate is the same law but for the volume of the chamber, which changes little.
            without: &["leak"],
            ..law(
                "gauge_leak",
                &[("g_s_kpa", 5e-7)],
                "parameters.c = { range = [0, 1e-3], absent = 0, start = [3.5e-7] }\nacts.air_extensor_g_s = \"-c * (pe - p_atm)\"",
                &["pe"],
            )
        },
        law(
            "pressure_drift",
            &[("kpa_s", 0.2)],
            "parameters.c = { range = [-10, 10], absent = 0, start = [0.14] }\nacts.pressure_flexor_kpa = \"pf + c * t\"",
            &["t"],
        ),
        law(
            "bent_position",
            &[("per_mm", 0.03)],
            "parameters.a = { range = [-0.3, 0.3], absent = 0, start = [0.02] }\nacts.position_mm = \"x + a * x^2\"",
            &["x"],
        ),
        warm_grease(8.0, [5.0, 10.0]),
        side_volume([1.5e-4, 1.5], 1e-4, [1.0, 2.2]),
    ];
    all.iter_mut().for_each(|law| law.psi = CONDITIONS);
    all
}

/// Gauge pressures of the recordings of [`twelfth_outside`], psi.
const CONDITIONS: [[f64; 2]; 3] = [[37.0, 63.0], [54.0, 46.0], [71.0, 58.0]];
