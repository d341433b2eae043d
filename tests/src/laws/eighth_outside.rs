//! Laws that were written without knowledge of the search, and chosen before any file of the project was read.

use super::shared::{
    braid_damping, cross_leak, cubic_spring, grease_thinning, motor_heating, soft_stop,
};
use super::{HiddenLaw, law};

/// Ten laws that were written without knowledge of the search or of the earlier lists, two of them with memory, at other pressures.
///
/// # Panics
/// Never.
#[must_use]
pub fn eighth_outside() -> Vec<HiddenLaw> {
    let mut all = vec![
        cubic_spring(3.0, 100.0, 2.0),
        soft_stop([18.0, 0.5], 12.0, [0.4, 0.6]),
        braid_damping(8e-4, 6e-4),
        grease_thinning([5.0, 2.0], 3.5, [1.4, 3.0]),
        law(
            "tight_spot",
            &[("n", 15.0), ("at_mm", 0.3), ("width_mm", 0.25)],
            "parameters.n = { range = [0, 500], absent = 0, start = [10] }\nparameters.at_mm = { range = [-5, 5], start = [0.2, 0.35] }\nparameters.w = { range = [0.01, 10], log = true, start = [0.2, 0.35] }\nacts.dry_friction_n = \"n * exp(-((x - at_mm) / w)^2)\"",
            &["x"],
        ),
        cross_leak(4e-7, 3e-7),
        HiddenLaw {
            // The hose begins at the pressure of the flexor, which a start value cannot name: it gets there at once.
            remembers: true,
            ..law(
                "hose_volume",
                &[("g_s_kpa", 1e-4), ("tau_s", 0.5)],
                "parameters.c = { range = [0, 1e-2], absent = 0, start = [7e-5] }\nparameters.tau_s = { range = [0.01, 100], log = true, start = [0.35, 0.7] }\nmemory.z = { start = \"0\", rate = \"(pf - z) / if(t < 0.02, 1e-3, tau_s)\" }\nacts.air_flexor_g_s = \"-c * (pf - z) * (t >= 0.02)\"",
                &["pf"],
            )
        },
        law(
            "cable_pickup",
            &[("kpa_n", 0.03)],
            "parameters.c = { range = [-1, 1], absent = 0, start = [0.02] }\nacts.pressure_extensor_kpa = \"pe + c * force\"",
            &["force"],
        ),
        law(
            "bent_position",
            &[("per_mm", 0.05)],
            "parameters.b = { range = [-0.3, 0.3], absent = 0, start = [0.035] }\nacts.position_mm = \"x + b * x^2\"",
            &["x"],
        ),
        motor_heating([7e-6, 8.0], 5e-6, &[5.0, 10.0]),
    ];
    all.iter_mut().for_each(|law| law.psi = CONDITIONS);
    all
}

/// Gauge pressures of the recordings of [`eighth_outside`], psi.
const CONDITIONS: [[f64; 2]; 3] = [[55.0, 42.0], [44.0, 60.0], [73.0, 64.0]];
