//! Laws that were written without knowledge of the search, by an author who had seen only the lists of `developed`,
//! `later` and `outside` (up to the third).

use super::{HiddenLaw, law};

/// Ten laws that were written without knowledge of the search, two of them with memory, at other pressures.
///
/// # Panics
/// Never.
#[must_use]
pub fn fifth_outside() -> Vec<HiddenLaw> {
    let mut all = vec![
        law(
            "core_loss",
            &[("s_mm", 0.012)],
            "parameters.c = { range = [-1, 1], absent = 0, start = [0.006] }\nacts.force_n = \"-c * force * abs(v)\"",
            &["force", "v"],
        ),
        law(
            "bladder_bulge",
            &[("n_mm2_kpa", 0.025)],
            "parameters.c = { range = [-5, 5], absent = 0, start = [0.015] }\nacts.force_n = \"-c * (pf - p_atm) * x * abs(x)\"",
            &["pf", "x"],
        ),
        HiddenLaw {
            remembers: true,
            or: &["x"],
            ..law(
                "payne_bushing",
                &[("n", 15.0), ("width_mm", 0.6), ("tau_s", 0.4)],
                "parameters.n = { range = [0, 500], absent = 0, start = [10] }\nparameters.w = { range = [0.01, 10], log = true, start = [0.5] }\nparameters.tau_s = { range = [0.01, 100], log = true, start = [0.3] }\nmemory.z = { start = \"0\", rate = \"v - z / tau_s\" }\nacts.force_n = \"-n * tanh(z / w)\"",
                &["v"],
            )
        },
        HiddenLaw {
            // A dry friction opposes the velocity, whether or not its level depends on it.
            or: &["pe", "v", "x"],
            ..law(
                "capstan_friction",
                &[("n_kpa", 0.025), ("width_mm", 2.0)],
                "parameters.c = { range = [0, 5], absent = 0, start = [0.015] }\nparameters.w = { range = [0.2, 50], log = true, start = [1.5, 3] }\nacts.dry_friction_n = \"c * max(pe - p_atm, 0) * exp(x / w)\"",
                &["pe", "x"],
            )
        },
        HiddenLaw {
            or: &["v", "x"],
            ..law(
                "mesh_friction",
                &[("n", 18.0), ("pitch_mm", 0.8)],
                "parameters.n = { range = [0, 500], absent = 0, start = [12] }\nparameters.pitch_mm = { range = [0.05, 10], log = true, start = [0.75, 0.8, 0.85] }\nacts.dry_friction_n = \"n * sin(pi * x / pitch_mm)^2\"",
                &["x"],
            )
        },
        law(
            "tilting_fitting",
            &[("g_s_kpa_n", 6e-9), ("from_n", 40.0)],
            "parameters.c = { range = [0, 1e-5], absent = 0, start = [4e-9] }\nparameters.from_n = { range = [1, 500], log = true, start = [30, 50] }\nacts.air_flexor_g_s = \"-c * (pf - p_atm) * max(force - from_n, 0)\"",
            &["force", "pf"],
        ),
        law(
            "growing_tear",
            &[("g_s2_kpa", 2e-8)],
            "parameters.c = { range = [0, 1e-4], absent = 0, start = [1e-8] }\nacts.air_extensor_g_s = \"-c * (pe - p_atm) * t\"",
            &["pe", "t"],
        ),
        law(
            "sampling_beat",
            &[("kpa", 1.2), ("frequency_hz", 1.37)],
            "parameters.a = { range = [0, 100], absent = 0, start = [0.8] }\nparameters.frequency_hz = { range = [0.1, 20], log = true, start = [1.34, 1.37, 1.4] }\nlet.beat = \"a * sin(2 * pi * frequency_hz * t)\"\nacts.pressure_flexor_kpa = \"pf + beat\"\nacts.pressure_extensor_kpa = \"pe + beat\"",
            &["t"],
        ),
        law(
            "tube_drop",
            &[("kpa_s2_mm2", 0.02)],
            "parameters.c = { range = [-1, 1], absent = 0, start = [0.01] }\nacts.pressure_flexor_kpa = \"pf + c * v * abs(v)\"",
            &["v"],
        ),
        HiddenLaw {
            remembers: true,
            ..law(
                "tendon_elongation",
                &[("mm_n", 8e-4), ("tau_s", 0.25)],
                "parameters.c = { range = [-1, 1], absent = 0, start = [5e-4] }\nparameters.tau_s = { range = [0.01, 100], log = true, start = [0.2] }\nmemory.z = { start = \"0\", rate = \"(force - z) / tau_s\" }\nacts.position_mm = \"x + c * z\"",
                &["force"],
            )
        },
    ];
    all.iter_mut().for_each(|law| law.psi = CONDITIONS);
    all
}

/// Gauge pressures of the recordings of [`fifth_outside`], psi.
const CONDITIONS: [[f64; 2]; 3] = [[58.0, 43.0], [37.0, 54.0], [64.0, 69.0]];
