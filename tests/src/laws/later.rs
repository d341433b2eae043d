//! Laws that were written after the search was changed on earlier ones.

use super::{HiddenLaw, law};

/// Ten laws that were written after the search was changed on those of [`unseen`](super::unseen), two of them with memory, at other pressures.
///
/// # Panics
/// Never.
#[must_use]
pub fn fresh() -> Vec<HiddenLaw> {
    let mut all = vec![
        law(
            "extensor_friction",
            &[("n_kpa", 0.06)],
            "parameters.c = { range = [0, 1], absent = 0, start = [0.03] }\nacts.dry_friction_n = \"c * max(pe - p_atm, 0)\"",
            &["pe"],
        ),
        law(
            "stiffening_spring",
            &[("n_mm", 12.0), ("scale_mm", 0.6)],
            "parameters.k = { range = [0, 500], absent = 0, start = [8] }\nparameters.w = { range = [0.05, 50], log = true, start = [0.8] }\nacts.force_n = \"-k * w * (sinh(x / w) - x / w)\"",
            &["x"],
        ),
        law(
            "outer_damping",
            &[("n_s_mm2", 6.0), ("from_mm", 0.5)],
            "parameters.c = { range = [0, 200], absent = 0, start = [4] }\nparameters.from_mm = { range = [0.01, 5], log = true, start = [0.4] }\nacts.force_n = \"-c * v * max(abs(x) - from_mm, 0)\"",
            &["v", "x"],
        ),
        law(
            "difference_damping",
            &[("n_s_mm_kpa", 0.008)],
            "parameters.c = { range = [-1, 1], absent = 0, start = [0.004] }\nacts.force_n = \"-c * (pf - pe) * v\"",
            &["pe", "pf", "v"],
        ),
        law(
            "quadratic_spring",
            &[("n_mm2", 10.0)],
            "parameters.k = { range = [0, 500], absent = 0, start = [6] }\nacts.force_n = \"-k * x * abs(x)\"",
            &["x"],
        ),
        law(
            "opening_crosstalk",
            &[("g_s_mm_kpa", 2e-6)],
            "parameters.c = { range = [0, 1e-3], absent = 0, start = [1e-6] }\nlet.flow = \"c * (pf - pe) * max(x, 0)\"\nacts.air_flexor_g_s = \"-flow\"\nacts.air_extensor_g_s = \"flow\"",
            &["pe", "pf", "x"],
        ),
        law(
            "bent_pressure",
            &[("per_kpa", 1.5e-4)],
            "parameters.a = { range = [-1, 1], absent = 0, start = [1e-4] }\nacts.pressure_flexor_kpa = \"pf + a * (pf - p_atm)^2\"",
            &["pf"],
        ),
        law(
            "bent_position",
            &[("per_mm", 0.04)],
            "parameters.a = { range = [-1, 1], absent = 0, start = [0.02] }\nacts.position_mm = \"x + a * x^2\"",
            &["x"],
        ),
        HiddenLaw {
            remembers: true,
            ..law(
                "worked_spring",
                &[("n_s2_mm3", 0.6), ("time_s", 1.0)],
                "parameters.k = { range = [0, 50], absent = 0, start = [0.3] }\nparameters.time_s = { range = [0.01, 100], log = true, start = [0.8] }\nmemory.z = { start = \"0\", rate = \"(v^2 - z) / time_s\" }\nacts.force_n = \"-k * x * z\"",
                &["v", "x"],
            )
        },
        HiddenLaw {
            remembers: true,
            ..law(
                "loaded_damping",
                &[("s_mm", 0.04), ("time_s", 0.8)],
                "parameters.c = { range = [0, 10], absent = 0, start = [0.02] }\nparameters.time_s = { range = [0.01, 100], log = true, start = [0.6] }\nmemory.z = { start = \"0\", rate = \"(abs(force) - z) / time_s\" }\nacts.force_n = \"-c * z * v\"",
                &["force", "v"],
            )
        },
    ];
    all.iter_mut().for_each(|law| law.psi = FRESH_CONDITIONS);
    all
}

/// Six laws that were written after the search was changed on those of [`fresh`], two of them with memory, at other pressures.
///
/// # Panics
/// Never.
#[must_use]
pub fn last() -> Vec<HiddenLaw> {
    let mut all = vec![
        law(
            "central_damping",
            &[("n_s_mm", 4.0), ("width_mm", 0.4)],
            "parameters.c = { range = [0, 100], absent = 0, start = [2] }\nparameters.w = { range = [0.01, 10], log = true, start = [0.6] }\nacts.force_n = \"-c * v / (1 + (x / w)^2)\"",
            &["v", "x"],
        ),
        law(
            "pressure_bow",
            &[("n_mm2_kpa", 0.03)],
            "parameters.c = { range = [-10, 10], absent = 0, start = [0.01] }\nacts.force_n = \"-c * (pf - p_atm) * x^2\"",
            &["pf", "x"],
        ),
        law(
            "square_leak",
            &[("g_s_kpa2", 2e-9)],
            "parameters.c = { range = [0, 1e-3], absent = 0, start = [1e-9] }\nacts.air_flexor_g_s = \"-c * (pf - p_atm)^2\"",
            &["pf"],
        ),
        HiddenLaw {
            remembers: true,
            ..law(
                "lasting_friction",
                &[("share", 0.12), ("time_s", 1.0)],
                "parameters.c = { range = [0, 10], absent = 0, start = [0.05] }\nparameters.time_s = { range = [0.01, 100], log = true, start = [0.7] }\nmemory.z = { start = \"0\", rate = \"(abs(force) - z) / time_s\" }\nacts.dry_friction_n = \"c * z\"",
                &["force"],
            )
        },
        HiddenLaw {
            remembers: true,
            ..law(
                "creeping_spring",
                &[("n_mm2", 8.0), ("time_s", 0.4)],
                "parameters.k = { range = [-100, 100], absent = 0, start = [4] }\nparameters.time_s = { range = [0.01, 100], log = true, start = [0.6] }\nmemory.z = { start = \"0\", rate = \"(x * abs(x) - z) / time_s\" }\nacts.force_n = \"-k * z\"",
                &["x"],
            )
        },
        law(
            "strained_pressure",
            &[("kpa_mm2", 1.5)],
            "parameters.c = { range = [-100, 100], absent = 0, start = [0.5] }\nacts.pressure_extensor_kpa = \"pe + c * x^2\"",
            &["x"],
        ),
    ];
    all.iter_mut().for_each(|law| law.psi = LAST_CONDITIONS);
    all
}

/// Gauge pressures of the recordings of [`fresh`], psi.
const FRESH_CONDITIONS: [[f64; 2]; 3] = [[55.0, 35.0], [40.0, 60.0], [70.0, 50.0]];
/// Gauge pressures of the recordings of [`last`], psi.
const LAST_CONDITIONS: [[f64; 2]; 3] = [[60.0, 45.0], [35.0, 50.0], [50.0, 65.0]];
