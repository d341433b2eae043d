//! Laws that were written without knowledge of the search, and chosen before any of the earlier lists was seen.

use super::{HiddenLaw, law};

/// Ten laws that were written without knowledge of the search or of the earlier lists, two of them with memory, at other pressures.
///
/// # Panics
/// Never.
#[must_use]
pub fn seventh_outside() -> Vec<HiddenLaw> {
    let mut all = vec![
        law(
            "grease_thinning",
            &[("n_s_mm", 4.0), ("mm_s", 3.0)],
            "parameters.c = { range = [0, 100], absent = 0, start = [2.5] }\nparameters.w = { range = [0.1, 100], log = true, start = [2, 4] }\nacts.force_n = \"-c * v / (1 + abs(v) / w)\"",
            &["v"],
        ),
        law(
            "cubic_spring",
            &[("n_mm3", 2.5)],
            "parameters.k = { range = [0, 100], absent = 0, start = [1.8] }\nacts.force_n = \"-k * x^3\"",
            &["x"],
        ),
        law(
            "braid_damping",
            &[("n_s_mm_kpa", 1e-3)],
            "parameters.c = { range = [0, 1], absent = 0, start = [7e-4] }\nacts.force_n = \"-c * (pf + pe) * v\"",
            &["pe", "pf", "v"],
        ),
        law(
            "fan_disturbance",
            &[("force_n", 14.0), ("frequency_hz", 6.3)],
            "parameters.n = { range = [0, 500], absent = 0, start = [10] }\nparameters.frequency_hz = { range = [0.1, 20], log = true, start = [6.25, 6.3, 6.35] }\nacts.force_n = \"n * sin(2 * pi * frequency_hz * t)\"",
            &["t"],
        ),
        HiddenLaw {
            remembers: true,
            ..law(
                "motor_heating",
                &[("per_n2", 4e-6), ("tau_s", 6.0)],
                "parameters.c = { range = [0, 1e-3], absent = 0, start = [3e-6] }\nparameters.tau_s = { range = [0.01, 100], log = true, start = [4, 8] }\nmemory.z = { start = \"0\", rate = \"(force^2 - z) / tau_s\" }\nacts.force_n = \"-c * z * force\"",
                &["force"],
            )
        },
        law(
            "edge_friction",
            &[("n_mm", 8.0)],
            "parameters.c = { range = [0, 500], absent = 0, start = [5] }\nacts.dry_friction_n = \"c * abs(x)\"",
            &["x"],
        ),
        HiddenLaw {
            remembers: true,
            ..law(
                "seal_warmup",
                &[("n", 18.0), ("mm_s", 5.0), ("tau_s", 4.0)],
                "parameters.n = { range = [0, 500], absent = 0, start = [13] }\nparameters.w = { range = [0.1, 100], log = true, start = [4, 7] }\nparameters.tau_s = { range = [0.01, 100], log = true, start = [3, 5] }\nmemory.z = { start = \"0\", rate = \"(abs(v) - z) / tau_s\" }\nacts.dry_friction_n = \"n * exp(-z / w)\"",
                &["v"],
            )
        },
        law(
            "cross_leak",
            &[("g_s_kpa", 3e-7)],
            "parameters.c = { range = [0, 1e-3], absent = 0, start = [2e-7] }\nlet.flow = \"c * (pf - pe)\"\nacts.air_flexor_g_s = \"-flow\"\nacts.air_extensor_g_s = \"flow\"",
            &["pe", "pf"],
        ),
        law(
            "frame_flex",
            &[("mm_n", 4e-4)],
            "parameters.c = { range = [-1, 1], absent = 0, start = [3e-4] }\nacts.position_mm = \"x + c * force\"",
            &["force"],
        ),
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
