//! Laws that were written without knowledge of the search, and chosen before any of the earlier lists was seen.

use super::shared::{
    cross_leak, cubic_spring, edge_friction, force_in_reading, pressure_damping, quadratic_drag,
    side_volume,
};
use super::{HiddenLaw, law};

/// Ten laws that were written without knowledge of the search or of the earlier lists, two of them with memory, at other pressures.
///
/// # Panics
/// Never.
#[must_use]
pub fn ninth_outside() -> Vec<HiddenLaw> {
    let mut all = vec![
        cubic_spring(3.0, 100.0, 2.0),
        quadratic_drag(0.1, 0.07),
        pressure_damping(1.5e-3, 1e-3),
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
        edge_friction(7.0),
        HiddenLaw {
            remembers: true,
            ..law(
                "polished_surface",
                &[("n", 12.0), ("path_mm", 40.0)],
                "parameters.n = { range = [0, 500], absent = 0, start = [9] }\nparameters.path_mm = { range = [1, 1000], log = true, start = [25, 55] }\nmemory.s = { start = \"0\", rate = \"abs(v)\" }\nacts.dry_friction_n = \"n * exp(-s / path_mm)\"",
                &["v"],
            )
        },
        cross_leak(4e-7, 3e-7),
        side_volume([2e-4, 0.4], 1.4e-4, [0.25, 0.6]),
        force_in_reading("frame_give", 5e-4, 3.5e-4),
    ];
    all.iter_mut().for_each(|law| law.psi = CONDITIONS);
    all
}

/// Gauge pressures of the recordings of [`ninth_outside`], psi.
const CONDITIONS: [[f64; 2]; 3] = [[52.0, 33.0], [38.0, 67.0], [72.0, 58.0]];
