//! Laws that were written without knowledge of the search, and chosen before any of the earlier lists was seen.

use super::shared::{
    braid_damping, cross_leak, cubic_spring, edge_friction, force_in_reading, grease_thinning,
    motor_heating,
};
use super::{HiddenLaw, law};

/// Ten laws that were written without knowledge of the search or of the earlier lists, two of them with memory, at other pressures.
///
/// # Panics
/// Never.
#[must_use]
pub fn seventh_outside() -> Vec<HiddenLaw> {
    let mut all = vec![
        grease_thinning([4.0, 3.0], 2.5, [2.0, 4.0]),
        cubic_spring(2.5, 100.0, 1.8),
        braid_damping(1e-3, 7e-4),
        law(
            "fan_disturbance",
            &[("force_n", 14.0), ("frequency_hz", 6.3)],
            "parameters.n = { range = [0, 500], absent = 0, start = [10] }\nparameters.frequency_hz = { range = [0.1, 20], log = true, start = [6.25, 6.3, 6.35] }\nacts.force_n = \"n * sin(2 * pi * frequency_hz * t)\"",
            &["t"],
        ),
        motor_heating([4e-6, 6.0], 3e-6, &[4.0, 8.0]),
        edge_friction(8.0),
        HiddenLaw {
            remembers: true,
            ..law(
                "seal_warmup",
                &[("n", 18.0), ("mm_s", 5.0), ("tau_s", 4.0)],
                "parameters.n = { range = [0, 500], absent = 0, start = [13] }\nparameters.w = { range = [0.1, 100], log = true, start = [4, 7] }\nparameters.tau_s = { range = [0.01, 100], log = true, start = [3, 5] }\nmemory.z = { start = \"0\", rate = \"(abs(v) - z) / tau_s\" }\nacts.dry_friction_n = \"n * exp(-z / w)\"",
                &["v"],
            )
        },
        cross_leak(3e-7, 2e-7),
        force_in_reading("frame_flex", 4e-4, 3e-4),
        law(
            "motor_pickup",
            &[("kpa_n", 0.02)],
            "parameters.c = { range = [-1, 1], absent = 0, start = [0.015] }\nacts.pressure_flexor_kpa = \"pf + c * force\"",
            &["force"],
        ),
    ];
    all.iter_mut().for_each(|law| law.psi = CONDITIONS);
    all
}

/// Gauge pressures of the recordings of [`seventh_outside`], psi.
const CONDITIONS: [[f64; 2]; 3] = [[48.0, 71.0], [66.0, 39.0], [34.0, 45.0]];
