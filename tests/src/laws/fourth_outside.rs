//! Further laws that were written without knowledge of the search.

use super::{HiddenLaw, law};

/// Ten laws that were written without knowledge of the search, two of them with memory, at other pressures.
///
/// # Panics
/// Never.
#[must_use]
pub fn fourth_outside() -> Vec<HiddenLaw> {
    let mut all = vec![
        law(
            "magnet_detent",
            &[("n", 30.0), ("width_mm", 0.5)],
            "parameters.n = { range = [0, 500], absent = 0, start = [20] }\nparameters.w = { range = [0.01, 10], log = true, start = [0.4, 0.8] }\nacts.force_n = \"-n * (x / w) * exp(-(x / w) * (x / w))\"",
            &["x"],
        ),
        law(
            "racked_frame",
            &[("per_kpa", 6e-4)],
            "parameters.c = { range = [-0.1, 0.1], absent = 0, start = [3e-4] }\nacts.force_n = \"-c * (pf - pe) * force\"",
            &["force", "pe", "pf"],
        ),
        law(
            "creeping_grease",
            &[("n_mm", 0.08)],
            "parameters.c = { range = [0, 10], absent = 0, start = [0.05] }\nacts.force_n = \"-c * t * v\"",
            &["t", "v"],
        ),
        HiddenLaw {
            remembers: true,
            or: &["x"],
            ..law(
                "orifice_relaxation",
                &[("n_mm", 10.0), ("per_mm_s", 2.0)],
                "parameters.k = { range = [0, 500], absent = 0, start = [6] }\nparameters.b = { range = [0.01, 1000], log = true, start = [1, 3] }\nmemory.z = { start = \"0\", rate = \"v - b * z * abs(z)\" }\nacts.force_n = \"-k * z\"",
                &["v"],
            )
        },
        HiddenLaw {
            // A dry friction opposes the velocity, whether or not its level depends on it.
            or: &["v", "x"],
            ..law(
                "brinelled_bearing",
                &[("n", 14.0), ("pitch_mm", 1.6)],
                "parameters.n = { range = [0, 500], absent = 0, start = [8] }\nparameters.pitch_mm = { range = [0.05, 10], log = true, start = [1.4, 1.6, 1.8] }\nacts.dry_friction_n = \"n * sin(pi * x / pitch_mm)^2\"",
                &["x"],
            )
        },
        HiddenLaw {
            remembers: true,
            or: &["x"],
            ..law(
                "settled_braid",
                &[("n_mm", 10.0), ("tau_s", 0.4)],
                "parameters.c = { range = [0, 500], absent = 0, start = [6] }\nparameters.tau_s = { range = [0.01, 100], log = true, start = [0.3] }\nmemory.z = { start = \"0\", rate = \"v - z / tau_s\" }\nacts.dry_friction_n = \"c * abs(z)\"",
                &["v"],
            )
        },
        law(
            "orifice_crosstalk",
            &[("g_s_kpa0p5", 6e-6)],
            // A little is added beneath the root, whose slope is infinite at zero.
            "parameters.c = { range = [0, 1e-3], absent = 0, start = [4e-6] }\nlet.flow = \"c * (pf - pe) / sqrt(abs(pf - pe) + 1)\"\nacts.air_flexor_g_s = \"-flow\"\nacts.air_extensor_g_s = \"flow\"",
            &["pe", "pf"],
        ),
        law(
            "pumping_seal",
            &[("g_mm_kpa", 8e-8)],
            "parameters.c = { range = [0, 1e-4], absent = 0, start = [4e-8] }\nacts.air_extensor_g_s = \"-c * (pe - p_atm) * max(v, 0)\"",
            &["pe", "v"],
        ),
        law(
            "pinched_gauge",
            &[("kpa_n", 0.05), ("from_n", 70.0)],
            "parameters.c = { range = [-1, 1], absent = 0, start = [0.03] }\nparameters.from_n = { range = [1, 500], log = true, start = [50, 100] }\nacts.pressure_extensor_kpa = \"pe + c * max(force - from_n, 0)\"",
            &["force"],
        ),
        law(
            "joined_scale",
            &[("share", 0.12), ("from_mm", 0.3)],
            "parameters.a = { range = [-1, 1], absent = 0, start = [0.08] }\nparameters.from_mm = { range = [0.01, 5], log = true, start = [0.2, 0.4] }\nacts.position_mm = \"x + a * max(x - from_mm, 0)\"",
            &["x"],
        ),
    ];
    all.iter_mut().for_each(|law| law.psi = FOURTH_OUTSIDE_CONDITIONS);
    all
}

/// Gauge pressures of the recordings of [`fourth_outside`], psi.
const FOURTH_OUTSIDE_CONDITIONS: [[f64; 2]; 3] = [[52.0, 68.0], [68.0, 44.0], [38.0, 48.0]];
