//! Laws that were written without knowledge of the search, and chosen as the most plausible ones before any file was opened.

use super::shared::{
    cross_leak, force_in_reading, pressure_friction, quadratic_drag, side_volume, soft_stop,
};
use super::{HiddenLaw, law};

/// Ten laws that were written without knowledge of the search or of the earlier lists, two of them with memory, at other pressures.
///
/// # Panics
/// Never.
#[must_use]
pub fn eleventh_outside() -> Vec<HiddenLaw> {
    let mut all = vec![
        soft_stop([14.0, 0.5], 10.0, [0.4, 0.6]),
        quadratic_drag(0.07, 0.05),
        pressure_friction(0.012, 8e-3),
        law(
            "rail_pinch",
            &[("n_mm", 8.0)],
            "parameters.c = { range = [0, 500], absent = 0, start = [5.5] }\nacts.dry_friction_n = \"c * max(-x, 0)\"",
            &["x"],
        ),
        HiddenLaw {
            remembers: true,
            ..law(
                "contact_ageing",
                &[("n", 14.0), ("slip_mm", 2.0), ("tau_s", 0.5)],
                "parameters.n = { range = [0, 500], absent = 0, start = [10] }\nparameters.slip_mm = { range = [0.01, 1000], log = true, start = [1.4, 3] }\nparameters.tau_s = { range = [0.01, 100], log = true, start = [0.35, 0.7] }\nmemory.s = { start = \"1\", rate = \"(1 - s) / tau_s - s * abs(v) / slip_mm\" }\nacts.dry_friction_n = \"n * s\"",
                &["v"],
            )
        },
        cross_leak(1.2e-6, 8e-7),
        law(
            "bladder_crack",
            &[("g_s_mm_kpa", 1e-6)],
            "parameters.c = { range = [0, 1e-3], absent = 0, start = [7e-7] }\nacts.air_flexor_g_s = \"-c * (pf - p_atm) * max(x, 0)\"",
            &["pf", "x"],
        ),
        side_volume([1.5e-4, 0.8], 1e-4, [0.5, 1.2]),
        force_in_reading("frame_give", 3e-4, 2e-4),
        law(
            "sensor_warmup",
            &[("kpa", 4.0), ("tau_s", 6.0)],
            "parameters.a = { range = [-100, 100], absent = 0, start = [2.8] }\nparameters.tau_s = { range = [0.1, 100], log = true, start = [4, 8] }\nacts.pressure_extensor_kpa = \"pe + a * (1 - exp(-t / tau_s))\"",
            &["t"],
        ),
    ];
    all.iter_mut().for_each(|law| law.psi = CONDITIONS);
    all
}

/// Gauge pressures of the recordings of [`eleventh_outside`], psi.
const CONDITIONS: [[f64; 2]; 3] = [[47.0, 69.0], [75.0, 58.0], [42.0, 35.0]];
