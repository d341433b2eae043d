//! Laws that were written without knowledge of the search, and chosen as the most plausible ones before any file was opened.

use super::shared::{
    cross_leak, cubic_spring, force_in_reading, motor_heating, pressure_damping, quadratic_drag,
    soft_stop,
};
use super::{HiddenLaw, law};

/// Ten laws that were written without knowledge of the search or of the earlier lists, two of them with memory, at other pressures.
///
/// # Panics
/// Never.
#[must_use]
pub fn thirteenth_outside() -> Vec<HiddenLaw> {
    let mut all = vec![
        cubic_spring(3.5, 100.0, 2.5),
        quadratic_drag(0.06, 0.04),
        soft_stop([15.0, 0.6], 10.0, [0.45, 0.7]),
        law(
            "gear_friction",
            &[("share", 0.06)],
            "parameters.c = { range = [0, 10], absent = 0, start = [0.04] }\nacts.dry_friction_n = \"c * abs(force)\"",
            &["force"],
        ),
        pressure_damping(1e-3, 7e-4),
        cross_leak(8e-7, 5.5e-7),
        force_in_reading("frame_give", 3e-4, 2e-4),
        law(
            "sensor_drift",
            &[("kpa_s", 0.2)],
            "parameters.c = { range = [-10, 10], absent = 0, start = [0.14] }\nacts.pressure_flexor_kpa = \"pf + c * t\"",
            &["t"],
        ),
        HiddenLaw {
            remembers: true,
            ..law(
                "thixotropic_damping",
                &[("n_s_mm", 1.6), ("shear_mm", 16.0), ("tau_s", 4.0)],
                "parameters.c = { range = [0, 100], absent = 0, start = [1.1] }\nparameters.shear_mm = { range = [0.1, 1000], log = true, start = [11, 22] }\nparameters.tau_s = { range = [0.01, 100], log = true, start = [3, 6] }\nmemory.s = { start = \"1\", rate = \"(1 - s) / tau_s - s * abs(v) / shear_mm\" }\nacts.force_n = \"-c * s * v\"",
                &["v"],
            )
        },
        motor_heating([4e-6, 8.0], 3e-6, &[5.0, 10.0]),
    ];
    all.iter_mut().for_each(|law| law.psi = CONDITIONS);
    all
}

/// Gauge pressures of the recordings of [`thirteenth_outside`], psi.
const CONDITIONS: [[f64; 2]; 3] = [[59.0, 41.0], [46.0, 74.0], [33.0, 51.0]];
