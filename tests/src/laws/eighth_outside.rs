//! Laws that were written without knowledge of the search, and chosen before any file of the project was read.

use super::{HiddenLaw, law};

/// Ten laws that were written without knowledge of the search or of the earlier lists, two of them with memory, at other pressures.
///
/// # Panics
/// Never.
#[must_use]
pub fn eighth_outside() -> Vec<HiddenLaw> {
    let mut all = vec![
        law(
            "cubic_spring",
            &[("n_mm3", 3.0)],
            "parameters.k = { range = [0, 100], absent = 0, start = [2] }\nacts.force_n = \"-k * x^3\"",
            &["x"],
        ),
        law(
            "soft_stop",
            &[("n_mm", 18.0), ("from_mm", 0.5)],
            "parameters.k = { range = [0, 500], absent = 0, start = [12] }\nparameters.from_mm = { range = [0.01, 5], log = true, start = [0.4, 0.6] }\nacts.force_n = \"-k * max(x - from_mm, 0)\"",
            &["x"],
        ),
        law(
            "braid_damping",
            &[("n_s_mm_kpa", 8e-4)],
            "parameters.c = { range = [0, 1], absent = 0, start = [6e-4] }\nacts.force_n = \"-c * (pf + pe) * v\"",
            &["pe", "pf", "v"],
        ),
        law(
            "grease_thinning",
            &[("n_s_mm", 5.0), ("mm_s", 2.0)],
            "parameters.c = { range = [0, 100], absent = 0, start = [3.5] }\nparameters.w = { range = [0.1, 100], log = true, start = [1.4, 3] }\nacts.force_n = \"-c * v / (1 + abs(v) / w)\"",
            &["v"],
        ),
        law(
            "tight_spot",
            &[("n", 15.0), ("at_mm", 0.3), ("width_mm", 0.25)],
            "parameters.n = { range = [0, 500], absent = 0, start = [10] }\nparameters.at_mm = { range = [-5, 5], start = [0.2, 0.35] }\nparameters.w = { range = [0.01, 10], log = true, start = [0.2, 0.35] }\nacts.dry_friction_n = \"n * exp(-((x - at_mm) / w)^2)\"",
            &["x"],
        ),
        law(
            "cross_leak",
            &[("g_s_kpa", 4e-7)],
            "parameters.c = { range = [0, 1e-3], absent = 0, start = [3e-7] }\nlet.flow = \"c * (pf - pe)\"\nacts.air_flexor_g_s = \"-flow\"\nacts.air_extensor_g_s = \"flow\"",
            &["pe", "pf"],
        ),
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
        HiddenLaw {
            remembers: true,
            ..law(
                "motor_heating",
                &[("per_n2", 7e-6), ("tau_s", 8.0)],
                "parameters.c = { range = [0, 1e-3], absent = 0, start = [5e-6] }\nparameters.tau_s = { range = [0.01, 100], log = true, start = [5, 10] }\nmemory.z = { start = \"0\", rate = \"(force^2 - z) / tau_s\" }\nacts.force_n = \"-c * z * force\"",
                &["force"],
            )
        },
    ];
    all.iter_mut().for_each(|law| law.psi = CONDITIONS);
    all
}

/// Gauge pressures of the recordings of [`eighth_outside`], psi.
const CONDITIONS: [[f64; 2]; 3] = [[55.0, 42.0], [44.0, 60.0], [73.0, 64.0]];
