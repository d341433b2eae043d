//! Laws that were written without knowledge of the search or of the earlier lists, by an author who chose them before any
//! file of the project was read.

use super::shared::{
    cross_leak, cubic_spring, force_in_reading, motor_heating, pressure_damping, soft_stop,
    worn_guide,
};
use super::{HiddenLaw, law};

/// Ten laws that were written without knowledge of the search or of the earlier lists, two of them with memory, at other
/// pressures.
///
/// # Panics
/// Never.
#[must_use]
pub fn sixth_outside() -> Vec<HiddenLaw> {
    let mut all = vec![
        cubic_spring(4.0, 200.0, 2.5),
        pressure_damping(0.0025, 0.0015),
        soft_stop([24.0, 0.4], 16.0, [0.3, 0.5]),
        law(
            "seam_leak",
            &[("g_s_kpa2", 3e-10)],
            "parameters.c = { range = [0, 1e-6], absent = 0, start = [2e-10] }\nacts.air_extensor_g_s = \"-c * (pe^2 - p_atm^2)\"",
            &["pe"],
        ),
        worn_guide(7.0, 5.0),
        law(
            "running_in",
            &[("n", 30.0), ("tau_s", 6.0)],
            "parameters.n = { range = [0, 500], absent = 0, start = [20] }\nparameters.tau_s = { range = [0.1, 1000], log = true, start = [4] }\nacts.dry_friction_n = \"n * exp(-t / tau_s)\"",
            &["t"],
        ),
        cross_leak(5e-7, 3e-7),
        force_in_reading("frame_give", 5e-4, 3e-4),
        motor_heating([8e-6, 8.0], 5e-6, &[5.0]),
        HiddenLaw {
            remembers: true,
            or: &["x"],
            ..law(
                "flexor_heat",
                &[("kpa_mm", 4.0), ("tau_s", 0.5)],
                "parameters.c = { range = [-100, 100], absent = 0, start = [2.5] }\nparameters.tau_s = { range = [0.01, 100], log = true, start = [0.35] }\nmemory.z = { start = \"0\", rate = \"v - z / tau_s\" }\nacts.pressure_flexor_kpa = \"pf - c * z\"",
                &["v"],
            )
        },
    ];
    all.iter_mut().for_each(|law| law.psi = CONDITIONS);
    all
}

/// Gauge pressures of the recordings of [`sixth_outside`], psi.
const CONDITIONS: [[f64; 2]; 3] = [[66.0, 49.0], [38.0, 55.0], [72.0, 63.0]];
