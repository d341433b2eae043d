//! Laws on which the search was developed, and the first ones that were written after it.

use super::shared::pressure_friction;
use super::{HiddenLaw, law};
use crate::plant::Hidden;

/// Eleven laws of forces, air and sensors, two of them with memory, and a friction that grows with the pressures without the
/// candidate that would name it.
///
/// # Panics
/// Never.
#[must_use]
pub fn laws() -> Vec<HiddenLaw> {
    vec![
        law(
            "cubic_spring",
            &[("n_mm3", 6.0)],
            "parameters.k = { range = [0, 100], absent = 0, start = [3] }\nacts.force_n = \"-k * x^3\"",
            &["x"],
        ),
        law(
            "quadratic_drag",
            &[("n_s2_mm2", 0.25)],
            "parameters.c = { range = [0, 10], absent = 0, start = [0.1] }\nacts.force_n = \"-c * v * abs(v)\"",
            &["v"],
        ),
        law(
            "pressure_damping",
            &[("n_s_mm_kpa", 0.003)],
            "parameters.c = { range = [0, 1], absent = 0, start = [0.002] }\nacts.force_n = \"-c * (pf + pe - 2 * p_atm) * v\"",
            &["pe", "pf", "v"],
        ),
        law(
            "displacement_damping",
            &[("n_s_mm3", 4.0)],
            "parameters.c = { range = [0, 100], absent = 0, start = [2] }\nacts.force_n = \"-c * x^2 * v\"",
            &["v", "x"],
        ),
        law(
            "one_way_damping",
            &[("n_s_mm", 2.0)],
            "parameters.c = { range = [0, 100], absent = 0, start = [1] }\nacts.force_n = \"-c * max(v, 0)\"",
            &["v"],
        ),
        law(
            "soft_stop",
            &[("n_mm", 25.0), ("from_mm", 0.5)],
            "parameters.k = { range = [0, 500], absent = 0, start = [10] }\nparameters.from_mm = { range = [0.01, 5], log = true, start = [0.4] }\nacts.force_n = \"-k * max(x - from_mm, 0)\"",
            &["x"],
        ),
        law(
            "flexor_friction",
            &[("n_kpa", 0.05)],
            "parameters.c = { range = [0, 1], absent = 0, start = [0.03] }\nacts.dry_friction_n = \"c * max(pf - p_atm, 0)\"",
            &["pf"],
        ),
        HiddenLaw {
            hidden: Hidden::new("chamber_crosstalk", &[("rate_per_s", 4e-3)]),
            ..law(
                "chamber_crosstalk",
                &[],
                "parameters.rate = { range = [0, 1], absent = 0, start = [0.003] }\nlet.flow = \"rate * mf * (pf - pe) / pf\"\nacts.air_flexor_g_s = \"-flow\"\nacts.air_extensor_g_s = \"flow\"",
                &["pe", "pf"],
            )
        },
        law(
            "reading_crosstalk",
            &[("share", 0.1)],
            "parameters.share = { range = [-1, 1], absent = 0, start = [0.05] }\nacts.pressure_extensor_kpa = \"pe + share * (pf - pe)\"",
            &["pe", "pf"],
        ),
        HiddenLaw {
            remembers: true,
            ..law(
                "second_path",
                &[("share", 0.15), ("time_s", 0.4)],
                "parameters.share = { range = [-1, 1], absent = 0, start = [0.1] }\nparameters.time_s = { range = [0.01, 100], log = true, start = [0.3] }\nmemory.z = { start = \"0\", rate = \"(force - z) / time_s\" }\nacts.force_n = \"-share * z\"",
                &["force"],
            )
        },
        HiddenLaw {
            remembers: true,
            ..law(
                "warming_damping",
                &[("n_s3_mm3", 0.03), ("time_s", 2.0)],
                "parameters.c = { range = [0, 10], absent = 0, start = [0.02] }\nparameters.time_s = { range = [0.01, 100], log = true, start = [1.5] }\nmemory.z = { start = \"0\", rate = \"(v^2 - z) / time_s\" }\nacts.force_n = \"-c * z * v\"",
                &["v"],
            )
        },
        pressure_friction(0.05, 0.03),
    ]
}

/// Thirteen laws that were written after the search, three of them with memory, at pressures of their own.
///
/// # Panics
/// Never.
#[must_use]
pub fn unseen() -> Vec<HiddenLaw> {
    let mut all = vec![
        law(
            "edge_friction",
            &[("n_mm", 18.0)],
            "parameters.c = { range = [0, 500], absent = 0, start = [10] }\nacts.dry_friction_n = \"c * abs(x)\"",
            &["x"],
        ),
        law(
            "quartic_spring",
            &[("n_mm4", 0.3)],
            "parameters.k = { range = [0, 200], absent = 0, start = [0.2] }\nacts.force_n = \"-k * x^4\"",
            &["x"],
        ),
        law(
            "extensor_damping",
            &[("n_s_mm_kpa", 0.005)],
            "parameters.c = { range = [0, 1], absent = 0, start = [0.003] }\nacts.force_n = \"-c * (pe - p_atm) * v\"",
            &["pe", "v"],
        ),
        law(
            "saturating_damping",
            &[("n", 15.0), ("mm_s", 3.0)],
            "parameters.n = { range = [0, 500], absent = 0, start = [10] }\nparameters.mm_s = { range = [0.01, 50], log = true, start = [2] }\nacts.force_n = \"-n * tanh(v / mm_s)\"",
            &["v"],
        ),
        law(
            "pressure_ripple",
            &[("n_kpa", 0.02), ("pitch_mm", 0.7)],
            "parameters.c = { range = [0, 1], absent = 0, start = [0.01] }\nparameters.pitch_mm = { range = [0.05, 5], log = true, start = [0.6, 0.7, 0.8] }\nacts.force_n = \"-c * (pf + pe - 2 * p_atm) * sin(2 * pi * x / pitch_mm)\"",
            &["pe", "pf", "x"],
        ),
        law(
            "one_sided_drag",
            &[("n_s2_mm2", 0.4)],
            "parameters.c = { range = [0, 20], absent = 0, start = [0.2] }\nacts.force_n = \"c * min(v, 0)^2\"",
            &["v"],
        ),
        HiddenLaw {
            remembers: true,
            or: &["pe", "pf", "x"],
            ..law(
                "pressure_hysteresis",
                &[("n_kpa", 0.03), ("slip_mm", 0.3)],
                "parameters.c = { range = [0, 1], absent = 0, start = [0.02] }\nparameters.slip_mm = { range = [0.01, 5], log = true, start = [0.2, 0.4] }\nmemory.z = { start = \"0\", step = \"clamp(z + dx / slip_mm, -1, 1)\" }\nacts.force_n = \"-c * (pf + pe - 2 * p_atm) * z\"",
                &["pe", "pf", "v"],
            )
        },
        HiddenLaw {
            remembers: true,
            or: &["pe", "pf", "x"],
            ..law(
                "pressure_relaxation",
                &[("n_mm_kpa", 0.05), ("time_s", 0.3)],
                "parameters.c = { range = [0, 5], absent = 0, start = [0.03] }\nparameters.time_s = { range = [0.01, 100], log = true, start = [0.2] }\nmemory.z = { start = \"0\", rate = \"v - z / time_s\" }\nacts.force_n = \"-c * (pf + pe - 2 * p_atm) * z\"",
                &["pe", "pf", "v"],
            )
        },
        law(
            "position_coupling",
            &[("n_s_mm2", 0.4)],
            "parameters.c = { range = [0, 50], absent = 0, start = [0.5] }\nacts.force_n = \"-c * x * v\"",
            &["v", "x"],
        ),
        law(
            "moving_leak",
            &[("g_mm_kpa", 4e-8)],
            "parameters.c = { range = [0, 1e-4], absent = 0, start = [2e-8] }\nacts.air_flexor_g_s = \"-c * (pf - p_atm) * abs(v)\"",
            &["pf", "v"],
        ),
        law(
            "turbulent_crosstalk",
            &[("g_s_kpa2", 8e-9)],
            "parameters.c = { range = [0, 1e-4], absent = 0, start = [4e-9] }\nlet.flow = \"c * (pf - pe) * abs(pf - pe)\"\nacts.air_flexor_g_s = \"-flow\"\nacts.air_extensor_g_s = \"flow\"",
            &["pe", "pf"],
        ),
        HiddenLaw {
            remembers: true,
            ..law(
                "running_friction",
                &[("n_s_mm", 4.0), ("time_s", 1.5)],
                "parameters.c = { range = [0, 100], absent = 0, start = [2] }\nparameters.time_s = { range = [0.01, 100], log = true, start = [1] }\nmemory.z = { start = \"0\", rate = \"(abs(v) - z) / time_s\" }\nacts.dry_friction_n = \"c * z\"",
                &["v"],
            )
        },
        law(
            "fading_damping",
            &[("n_s_mm", 3.0), ("time_s", 6.0)],
            "parameters.c = { range = [0, 100], absent = 0, start = [2] }\nparameters.time_s = { range = [0.1, 1000], log = true, start = [5] }\nacts.force_n = \"-c * exp(-t / time_s) * v\"",
            &["t", "v"],
        ),
    ];
    all.iter_mut().for_each(|law| law.psi = OTHER_CONDITIONS);
    all
}

/// Gauge pressures of the recordings of [`unseen`], psi.
const OTHER_CONDITIONS: [[f64; 2]; 3] = [[45.0, 30.0], [50.0, 70.0], [65.0, 60.0]];
