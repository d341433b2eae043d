//! Laws that were written without knowledge of the search, and chosen before any file of the project was read.

use super::shared::{cross_leak, cubic_spring, force_in_reading, pressure_damping, soft_stop};
use super::{HiddenLaw, law};

/// Ten laws that were written without knowledge of the search or of the earlier lists, two of them with memory, at other pressures.
///
/// # Panics
/// Never.
#[must_use]
pub fn tenth_outside() -> Vec<HiddenLaw> {
    let mut all = vec![
        law(
            "quadratic_drag",
            &[("n_s2_mm2", 0.045)],
            "parameters.c = { range = [0, 10], absent = 0, start = [0.03] }\nacts.force_n = \"-c * v * abs(v)\"",
            &["v"],
        ),
        cubic_spring(4.0, 100.0, 2.8),
        HiddenLaw {
            without: &["load_friction"],
            ..law(
                "pressure_friction",
                &[("n_kpa", 0.012)],
                "parameters.c = { range = [0, 1], absent = 0, start = [8e-3] }\nacts.dry_friction_n = \"c * max(pf + pe - 2 * p_atm, 0)\"",
                &["pe", "pf"],
            )
        },
        HiddenLaw {
            or: &["v", "x"],
            ..law(
                "worn_guide",
                &[("n_mm2", 5.0)],
                "parameters.c = { range = [0, 500], absent = 0, start = [3.5] }\nacts.dry_friction_n = \"c * x^2\"",
                &["x"],
            )
        },
        pressure_damping(1e-3, 7e-4),
        soft_stop([12.0, 0.6], 8.0, [0.5, 0.75]),
        cross_leak(1.2e-6, 8e-7),
        force_in_reading("frame_give", 4e-4, 2.8e-4),
        HiddenLaw {
            remembers: true,
            ..law(
                "warm_grease",
                &[("n", 12.0), ("mm_s", 5.0), ("tau_s", 6.0)],
                "parameters.n = { range = [0, 500], absent = 0, start = [8] }\nparameters.w = { range = [0.1, 100], log = true, start = [4, 7] }\nparameters.tau_s = { range = [0.01, 100], log = true, start = [4, 8] }\nmemory.z = { start = \"0\", rate = \"(abs(v) / w - z) / tau_s\" }\nacts.dry_friction_n = \"n / (1 + z)\"",
                &["v"],
            )
        },
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
