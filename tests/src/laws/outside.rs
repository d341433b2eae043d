//! Laws that were written without knowledge of the search.

use super::{HiddenLaw, law};

/// Ten laws that were written without knowledge of the search, two of them with memory, at other pressures.
///
/// # Panics
/// Never.
#[must_use]
pub fn outside() -> Vec<HiddenLaw> {
    let mut all = vec![
        law(
            "fan_disturbance",
            &[("force_n", 8.0), ("frequency_hz", 3.3), ("phase_rad", 0.9)],
            "parameters.n = { range = [0, 500], absent = 0, start = [5] }\nparameters.frequency_hz = { range = [0.1, 20], log = true, start = [3.25, 3.3, 3.35] }\nparameters.phase = { range = [0.01, 6.3], log = true, start = [1] }\nacts.force_n = \"n * sin(2 * pi * frequency_hz * t + phase)\"",
            &["t"],
        ),
        law(
            "difference_spring",
            &[("n_mm_kpa", 0.1)],
            "parameters.k = { range = [-5, 5], absent = 0, start = [0.05] }\nacts.force_n = \"-k * (pf - pe) * x\"",
            &["pe", "pf", "x"],
        ),
        law(
            "stretched_damping",
            &[("n_s_mm2", 2.0)],
            "parameters.c = { range = [0, 100], absent = 0, start = [1] }\nacts.force_n = \"-c * max(-x, 0) * v\"",
            &["v", "x"],
        ),
        law(
            "moment_arm",
            &[("per_mm", 0.08)],
            "parameters.c = { range = [-1, 1], absent = 0, start = [0.04] }\nacts.force_n = \"-c * x * force\"",
            &["force", "x"],
        ),
        HiddenLaw {
            remembers: true,
            ..law(
                "motor_heating",
                &[("per_n2", 7e-6), ("tau_s", 2.5)],
                "parameters.c = { range = [0, 1e-3], absent = 0, start = [4e-6] }\nparameters.time_s = { range = [0.01, 100], log = true, start = [2] }\nmemory.z = { start = \"0\", rate = \"(force^2 - z) / time_s\" }\nacts.force_n = \"-c * z * force\"",
                &["force"],
            )
        },
        HiddenLaw {
            // A dry friction opposes the velocity, whether or not its level depends on it.
            or: &["pf", "v", "x"],
            ..law(
                "braid_friction",
                &[("n_mm_kpa", 0.04)],
                "parameters.c = { range = [0, 5], absent = 0, start = [0.02] }\nacts.dry_friction_n = \"c * max(pf - p_atm, 0) * abs(x)\"",
                &["pf", "x"],
            )
        },
        law(
            "stretch_leak",
            &[("g_s_mm_kpa", 8e-7)],
            "parameters.c = { range = [0, 1e-3], absent = 0, start = [4e-7] }\nacts.air_extensor_g_s = \"-c * (pe - p_atm) * max(x, 0)\"",
            &["pe", "x"],
        ),
        HiddenLaw {
            remembers: true,
            or: &["x"],
            ..law(
                "heated_air",
                &[("kpa_mm", 3.0), ("tau_s", 0.15)],
                "parameters.c = { range = [-100, 100], absent = 0, start = [2] }\nparameters.time_s = { range = [0.01, 100], log = true, start = [0.2] }\nmemory.z = { start = \"0\", rate = \"v - z / time_s\" }\nacts.pressure_flexor_kpa = \"pf - c * z\"\nacts.pressure_extensor_kpa = \"pe + c * z\"",
                &["v"],
            )
        },
        law(
            "supply_sag",
            &[("kpa_n", 0.02)],
            "parameters.c = { range = [-1, 1], absent = 0, start = [0.01] }\nacts.pressure_flexor_kpa = \"pf - c * abs(force)\"",
            &["force"],
        ),
        law(
            "hall_position",
            &[("per_mm2", 0.04)],
            "parameters.a = { range = [-1, 1], absent = 0, start = [0.02] }\nacts.position_mm = \"x - a * x^3\"",
            &["x"],
        ),
    ];
    all.iter_mut().for_each(|law| law.psi = OUTSIDE_CONDITIONS);
    all
}

/// Ten further laws that were written without knowledge of the search, two of them with memory, at other pressures.
///
/// # Panics
/// Never.
#[must_use]
pub fn second_outside() -> Vec<HiddenLaw> {
    let mut all = vec![
        law(
            "hose_spring",
            &[("n_mm_kpa", 0.03)],
            "parameters.k = { range = [-5, 5], absent = 0, start = [0.02] }\nacts.force_n = \"-k * (pf - p_atm) * x\"",
            &["pf", "x"],
        ),
        law(
            "yielding_cable",
            &[("n", 12.0), ("width_mm", 0.5)],
            "parameters.n = { range = [0, 500], absent = 0, start = [8] }\nparameters.w = { range = [0.01, 10], log = true, start = [0.4] }\nacts.force_n = \"-n * tanh(x / w)\"",
            &["x"],
        ),
        law(
            "amplifier_drift",
            &[("n", 10.0), ("tau_s", 5.0)],
            "parameters.n = { range = [-500, 500], absent = 0, start = [6] }\nparameters.tau_s = { range = [0.1, 1000], log = true, start = [4] }\nacts.force_n = \"n * (1 - exp(-t / tau_s))\"",
            &["t"],
        ),
        law(
            "braid_brake",
            &[("n_s_mm_kpa", 0.004)],
            "parameters.c = { range = [0, 1], absent = 0, start = [0.002] }\nacts.force_n = \"-c * (pe - p_atm) * max(v, 0)\"",
            &["pe", "v"],
        ),
        HiddenLaw {
            remembers: true,
            ..law(
                "strain_softening",
                &[("n_mm2", 12.0), ("tau_s", 1.5)],
                "parameters.k = { range = [-100, 100], absent = 0, start = [6] }\nparameters.tau_s = { range = [0.01, 100], log = true, start = [1] }\nmemory.z = { start = \"0\", rate = \"(abs(x) - z) / tau_s\" }\nacts.force_n = \"k * z * x\"",
                &["x"],
            )
        },
        law(
            "gear_friction",
            &[("share", 0.06)],
            "parameters.c = { range = [0, 10], absent = 0, start = [0.03] }\nacts.dry_friction_n = \"c * abs(force)\"",
            &["force"],
        ),
        law(
            "tilt_friction",
            &[("n_kpa", 0.09)],
            "parameters.c = { range = [0, 5], absent = 0, start = [0.05] }\nacts.dry_friction_n = \"c * abs(pf - pe)\"",
            &["pe", "pf"],
        ),
        law(
            "opening_seal",
            &[("g_s_kpa", 2e-6), ("from_kpa", 330.0)],
            "parameters.c = { range = [0, 1e-3], absent = 0, start = [1e-6] }\nparameters.from_kpa = { range = [10, 2000], log = true, start = [250, 300, 350] }\nacts.air_extensor_g_s = \"-c * max(pe - p_atm - from_kpa, 0)\"",
            &["pe"],
        ),
        law(
            "encoder_interpolation",
            &[("amplitude_mm", 0.03), ("pitch_mm", 1.35)],
            "parameters.a = { range = [-1, 1], absent = 0, start = [0.02] }\nparameters.pitch_mm = { range = [0.05, 10], log = true, start = [1.2, 1.35, 1.5] }\nacts.position_mm = \"x + a * sin(2 * pi * x / pitch_mm)\"",
            &["x"],
        ),
        HiddenLaw {
            remembers: true,
            ..law(
                "warming_encoder",
                &[("mm_n2", 3e-6), ("tau_s", 3.0)],
                "parameters.c = { range = [-1e-3, 1e-3], absent = 0, start = [2e-6] }\nparameters.tau_s = { range = [0.01, 100], log = true, start = [2] }\nmemory.z = { start = \"0\", rate = \"(force^2 - z) / tau_s\" }\nacts.position_mm = \"x + c * z\"",
                &["force"],
            )
        },
    ];
    all.iter_mut().for_each(|law| law.psi = SECOND_OUTSIDE_CONDITIONS);
    all
}

/// Ten further laws that were written without knowledge of the search, two of them with memory, at other pressures.
///
/// # Panics
/// Never.
#[must_use]
pub fn third_outside() -> Vec<HiddenLaw> {
    let mut all = vec![
        HiddenLaw {
            remembers: true,
            ..law(
                "thixotropic_damping",
                &[("n_s_mm", 5.0), ("shear_mm", 8.0), ("tau_s", 3.0)],
                "parameters.c = { range = [0, 100], absent = 0, start = [3] }\nparameters.shear_mm = { range = [0.1, 1000], log = true, start = [6] }\nparameters.tau_s = { range = [0.01, 100], log = true, start = [2] }\nmemory.z = { start = \"0\", rate = \"abs(v) * (1 - z) / shear_mm - z / tau_s\" }\nacts.force_n = \"-c * (1 - z) * v\"",
                &["v"],
            )
        },
        law(
            "hertz_stop",
            &[("n_mm1p5", 20.0), ("from_mm", 0.3)],
            // A little is added beneath the root, whose slope is infinite at zero.
            "parameters.k = { range = [0, 500], absent = 0, start = [12] }\nparameters.from_mm = { range = [0.01, 5], log = true, start = [0.2, 0.4] }\nlet.depth = \"max(-x - from_mm, 0)\"\nacts.force_n = \"k * depth * sqrt(depth + 1e-6)\"",
            &["x"],
        ),
        law(
            "eddy_brake",
            &[("n_s_mm", 4.0), ("mm_s", 5.0)],
            "parameters.c = { range = [0, 100], absent = 0, start = [3] }\nparameters.w = { range = [0.01, 100], log = true, start = [4] }\nacts.force_n = \"-c * v / (1 + (v / w)^2)\"",
            &["v"],
        ),
        law(
            "pressure_hardening",
            &[("n_mm3_kpa", 0.009)],
            "parameters.c = { range = [0, 1], absent = 0, start = [0.005] }\nacts.force_n = \"-c * (pf + pe - 2 * p_atm) * x^3\"",
            &["pe", "pf", "x"],
        ),
        law(
            "torque_ripple",
            &[("share", 0.07), ("pitch_mm", 1.1)],
            "parameters.c = { range = [0, 1], absent = 0, start = [0.04] }\nparameters.pitch_mm = { range = [0.05, 10], log = true, start = [1, 1.1, 1.2] }\nacts.force_n = \"-c * force * sin(2 * pi * x / pitch_mm)\"",
            &["force", "x"],
        ),
        law(
            "seal_ridge",
            &[("n", 14.0), ("width_mm", 0.6)],
            "parameters.n = { range = [0, 500], absent = 0, start = [8] }\nparameters.w = { range = [0.01, 10], log = true, start = [0.4, 0.8] }\nacts.dry_friction_n = \"n * exp(-(x / w) * (x / w))\"",
            &["x"],
        ),
        law(
            "check_valve",
            &[("g_s_kpa", 1.5e-6)],
            "parameters.c = { range = [0, 1e-3], absent = 0, start = [1e-6] }\nlet.flow = \"c * max(pf - pe, 0)\"\nacts.air_flexor_g_s = \"-flow\"\nacts.air_extensor_g_s = \"flow\"",
            &["pe", "pf"],
        ),
        HiddenLaw {
            remembers: true,
            ..law(
                "friction_heat",
                &[("kpa_s_mm", 0.6), ("tau_s", 2.0)],
                "parameters.c = { range = [-100, 100], absent = 0, start = [0.4] }\nparameters.tau_s = { range = [0.01, 100], log = true, start = [1.5] }\nmemory.z = { start = \"0\", rate = \"(abs(v) - z) / tau_s\" }\nacts.pressure_flexor_kpa = \"pf + c * z\"\nacts.pressure_extensor_kpa = \"pe + c * z\"",
                &["v"],
            )
        },
        law(
            "sensor_range",
            &[("share", 0.6), ("from_kpa", 440.0)],
            "parameters.a = { range = [0, 1], absent = 0, start = [0.4] }\nparameters.from_kpa = { range = [10, 2000], log = true, start = [425, 435, 445] }\nacts.pressure_extensor_kpa = \"pe - a * max(pe - p_atm - from_kpa, 0)\"",
            &["pe"],
        ),
        law(
            "frame_bending",
            &[("mm_kpa", 4e-4)],
            "parameters.c = { range = [-1, 1], absent = 0, start = [2e-4] }\nacts.position_mm = \"x + c * (pf - pe)\"",
            &["pe", "pf"],
        ),
    ];
    all.iter_mut().for_each(|law| law.psi = THIRD_OUTSIDE_CONDITIONS);
    all
}

/// Gauge pressures of the recordings of [`outside`], psi.
const OUTSIDE_CONDITIONS: [[f64; 2]; 3] = [[65.0, 40.0], [40.0, 55.0], [60.0, 70.0]];
/// Gauge pressures of the recordings of [`second_outside`], psi.
const SECOND_OUTSIDE_CONDITIONS: [[f64; 2]; 3] = [[40.0, 65.0], [70.0, 60.0], [50.0, 35.0]];
/// Gauge pressures of the recordings of [`third_outside`], psi.
const THIRD_OUTSIDE_CONDITIONS: [[f64; 2]; 3] = [[62.0, 38.0], [45.0, 65.0], [55.0, 50.0]];
