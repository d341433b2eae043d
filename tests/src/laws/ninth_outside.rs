//! Laws that were written without knowledge of the search, and chosen before any of the earlier lists was seen.

use super::{HiddenLaw, law};

/// Ten laws that were written without knowledge of the search or of the earlier lists, two of them with memory, at other pressures.
///
/// # Panics
/// Never.
#[must_use]
pub fn ninth_outside() -> Vec<HiddenLaw> {
    let mut all = vec![
        law(
            "cubic_spring",
            &[("n_mm3", 3.0)],
            "parameters.k = { range = [0, 100], absent = 0, start = [2] }\nacts.force_n = \"-k * x^3\"",
            &["x"],
        ),
        law(
            "quadratic_drag",
            &[("n_s2_mm2", 0.1)],
            "parameters.c = { range = [0, 10], absent = 0, start = [0.07] }\nacts.force_n = \"-c * v * abs(v)\"",
            &["v"],
        ),
        law(
            "pressure_damping",
            &[("n_s_mm_kpa", 1.5e-3)],
            "parameters.c = { range = [0, 1], absent = 0, start = [1e-3] }\nacts.force_n = \"-c * (pf + pe - 2 * p_atm) * v\"",
            &["pe", "pf", "v"],
        ),
        law(
            "amplifier_drift",
            &[("n", 9.0), ("tau_s", 6.0)],
            "parameters.n = { range = [-500, 500], absent = 0, start = [6] }\nparameters.tau_s = { range = [0.1, 100], log = true, start = [4, 8] }\nacts.force_n = \"n * (1 - exp(-t / tau_s))\"",
            &["t"],
        ),
        law(
            "magnet_fade",
            &[("per_s", 5e-3)],
            "parameters.c = { range = [-1, 1], absent = 0, start = [3.5e-3] }\nacts.force_n = \"-c * t * force\"",
            &["force", "t"],
        ),
        law(
            "edge_friction",
            &[("n_mm", 7.0)],
            "parameters.c = { range = [0, 500], absent = 0, start = [5] }\nacts.dry_friction_n = \"c * abs(x)\"",
            &["x"],
        ),
        HiddenLaw {
            remembers: true,
            ..law(
                "polished_surface",
                &[("n", 12.0), ("path_mm", 40.0)],
                "parameters.n = { range = [0, 500], absent = 0, start = [9] }\nparameters.path_mm = { range = [1, 1000], log = true, start = [25, 55] }\nmemory.s = { start = \"0\", rate = \"abs(v)\" }\nacts.dry_friction_n = \"n * exp(-s / path_mm)\"",
                &["v"],
            )
        },
        law(
            "cross_leak",
            &[("g_s_kpa", 4e-7)],
            "parameters.c = { range = [0, 1e-3], absent = 0, start = [3e-7] }\nlet.flow = \"c * (pf - pe)\"\nacts.air_flexor_g_s = \"-flow\"\nacts.air_extensor_g_s = \"flow\"",
            &["pe", "pf"],
        ),
        // A memory cannot begin at a pressure: for ten milliseconds it catches up with the one at rest and nothing flows.
        HiddenLaw {
            remembers: true,
            ..law(
                "side_volume",
                &[("g_s_kpa", 2e-4), ("tau_s", 0.4)],
                "parameters.c = { range = [0, 1], absent = 0, start = [1.4e-4] }\nparameters.tau_s = { range = [0.01, 100], log = true, start = [0.25, 0.6] }\nmemory.z = { start = \"400\", rate = \"(pf - z) / if(t < 0.01, 1e-3, tau_s)\" }\nacts.air_flexor_g_s = \"-c * (pf - z) * (t >= 0.01)\"",
                &["pf"],
            )
        },
        law(
            "frame_give",
            &[("mm_n", 5e-4)],
            "parameters.c = { range = [-1, 1], absent = 0, start = [3.5e-4] }\nacts.position_mm = \"x + c * force\"",
            &["force"],
        ),
    ];
    all.iter_mut().for_each(|law| law.psi = CONDITIONS);
    all
}

/// Gauge pressures of the recordings of [`ninth_outside`], psi.
const CONDITIONS: [[f64; 2]; 3] = [[52.0, 33.0], [38.0, 67.0], [72.0, 58.0]];
