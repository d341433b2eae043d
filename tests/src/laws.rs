//! Study of the search for laws: laws that stand in no list, hidden by the plant of the studies, which shares no code with the
//! search, and null sets.

use crate::diagnose::subject;
use crate::plant::{Excitation, Experiment, Hidden, Plant, Sensors};
use crate::study::data::data;
use crate::study::outcome::cpu_s;
use crate::study::{Case, Kind, ModelError, design};
use pam_data::{SavedModel, Subject, load_model};
use pam_diagnose::test_set::ChannelReduction;
use pam_diagnose::{
    DiagnoseOptions, DiagnosisSettings, JointDiagnosis, RecordingSets, diagnose, learn_remainder,
};
use pam_effects::{ExtendedModel, expression};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// A law that is hidden, with what a right answer has.
#[derive(Debug, Clone)]
pub struct HiddenLaw {
    /// Its id.
    pub id: &'static str,
    /// As the plant hides it.
    pub hidden: Hidden,
    /// As an effect of expressions, for what the law itself reaches on the test set.
    definition: &'static str,
    /// Its variables.
    pub variables: &'static [&'static str],
    /// Variables with which the same law can be written.
    pub or: &'static [&'static str],
    /// Whether it remembers.
    pub remembers: bool,
    /// Candidates that are taken out of the list, since they would name it.
    pub without: &'static [&'static str],
    /// Gauge pressures of the recordings, psi.
    pub psi: [[f64; 2]; 3],
}

/// A law of displacement, velocity, pressures or time without memory.
fn law(
    id: &'static str,
    values: &[(&str, f64)],
    definition: &'static str,
    variables: &'static [&'static str],
) -> HiddenLaw {
    HiddenLaw {
        id,
        hidden: Hidden::new(id, values),
        definition,
        variables,
        or: &[],
        remembers: false,
        without: &[],
        psi: CONDITIONS,
    }
}

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
        HiddenLaw {
            without: &["load_friction"],
            ..law(
                "pressure_friction",
                &[("n_kpa", 0.05)],
                "parameters.c = { range = [0, 1], absent = 0, start = [0.03] }\nacts.dry_friction_n = \"c * max(pf + pe - 2 * p_atm, 0)\"",
                &["pe", "pf"],
            )
        },
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

/// Ten laws that were written after the search was changed on those of [`unseen`], two of them with memory, at other pressures.
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
            // Friction turns with the velocity, whether the law says so or it is dry.
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

/// Gauge pressures of the recordings, psi.
const CONDITIONS: [[f64; 2]; 3] = [[40.0, 40.0], [70.0, 45.0], [35.0, 60.0]];
/// Those with laws that were written after the search.
const OTHER_CONDITIONS: [[f64; 2]; 3] = [[45.0, 30.0], [50.0, 70.0], [65.0, 60.0]];
/// Those with laws that were written last.
const FRESH_CONDITIONS: [[f64; 2]; 3] = [[55.0, 35.0], [40.0, 60.0], [70.0, 50.0]];
/// Those with laws that were written after the last change of the library.
const LAST_CONDITIONS: [[f64; 2]; 3] = [[60.0, 45.0], [35.0, 50.0], [50.0, 65.0]];
/// Those with laws that were written without knowledge of the search.
const OUTSIDE_CONDITIONS: [[f64; 2]; 3] = [[65.0, 40.0], [40.0, 55.0], [60.0, 70.0]];
/// Those with further laws that were written without knowledge of the search.
const SECOND_OUTSIDE_CONDITIONS: [[f64; 2]; 3] = [[40.0, 65.0], [70.0, 60.0], [50.0, 35.0]];
/// Those with a third list of laws that were written without knowledge of the search.
const THIRD_OUTSIDE_CONDITIONS: [[f64; 2]; 3] = [[62.0, 38.0], [45.0, 65.0], [55.0, 50.0]];
/// Length of a recording of the study, s.
pub const LENGTH_S: f64 = 20.0;
/// Length of one of the published protocol, s.
const PUBLISHED_S: f64 = 70.0;

/// Recordings of a length with a hidden law, by a seed of their noise.
#[must_use]
pub fn recordings(saved: &SavedModel, law: &HiddenLaw, seed: u64, length_s: f64) -> Vec<Subject> {
    let plant = Plant::of(&saved.model);
    let (effects, sensors) = ([law.hidden.clone()], Sensors::default());
    law.psi
        .par_iter()
        .enumerate()
        .map(|(i, &psi)| {
            let excitation = Excitation::published(length_s / PUBLISHED_S);
            let name = format!("nn_{:.0}{:.0}", psi[0], psi[1]);
            let seed = 1000 * seed + i as u64;
            let run = Experiment::new(&name, psi, &excitation, &effects, &sensors, seed);
            subject(saved, plant.record(&run))
        })
        .collect()
}

/// Null sets of the design of the study, whose model has no error, every so-manieth.
#[must_use]
pub fn nulls(count: usize) -> Vec<Case> {
    let all = design::full().into_iter().filter(|c| {
        c.kind == Kind::Null && c.factors.model_error == ModelError::None && c.repeats.is_none()
    });
    let all: Vec<Case> = all.filter(|c| c.id.starts_with("nulls")).collect();
    let every = (all.len() / count.max(1)).max(1);
    all.into_iter().step_by(every).take(count).collect()
}

/// What the search said of a case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LawOutcome {
    /// The case: a law or a null set.
    pub id: String,
    /// Whether something is hidden.
    pub hidden: bool,
    /// Verdict of the diagnosis alone.
    pub diagnosis: String,
    /// Causes that the diagnosis alone names.
    pub named_before: Vec<String>,
    /// Verdict with the remainder.
    pub verdict: String,
    /// Causes that are named in the end, beside a law.
    pub named: Vec<String>,
    /// What became of the remainder.
    pub outcome: String,
    /// Causes that the diagnosis alone named and a law replaces, with the reasons.
    pub replaced: Vec<(String, String)>,
    /// Reasons of the verdict.
    pub reasons: Vec<String>,
    /// The law.
    pub law: Option<String>,
    /// Its numbers: value and 95 % interval.
    pub parameters: Vec<(String, [f64; 3])>,
    /// Its variables.
    pub variables: Vec<String>,
    /// Whether it remembers.
    pub remembers: bool,
    /// Whether the variables are those of the hidden law.
    pub right: bool,
    /// Groups of variables on which the correction depends, with the ratio of the errors without them and with them.
    pub depends_on: Vec<(String, f64)>,
    /// Laws that were fitted, with the causes beside them, the number of their parameters and their log odds to the first one.
    #[serde(default)]
    pub ranking: Vec<(String, usize, f64)>,
    /// Share of the error of the test set that the law removes, and that the hidden law itself removes when it is fitted.
    pub reduction: Option<[f64; 2]>,
    /// CPU time of the diagnosis, and of the remainder, s.
    pub cpu_s: [f64; 2],
    /// Wall-clock time of the remainder, s.
    pub wall_s: f64,
}

impl LawOutcome {
    /// Share of what the hidden law reaches.
    #[must_use]
    pub fn reached(&self) -> Option<f64> {
        self.reduction.map(|[own, best]| own / best)
    }

    /// Whether the law is found: the right variables, and at least 80 % of what the hidden law reaches.
    #[must_use]
    pub fn is_found(&self) -> bool {
        self.right && self.reached().is_some_and(|r| r >= 0.8)
    }
}

/// The error reduction over all channels, from the errors before of one list to those after of another.
fn reduction(before: &[ChannelReduction], after: &[ChannelReduction]) -> f64 {
    let (mut from, mut to) = (0.0, 0.0);
    for (b, a) in before.iter().zip(after).filter(|(b, _)| b.key != "v") {
        let variance = b.rmse_before.powi(2) / (1.0 - b.r2_before).max(1e-12);
        from += b.rmse_before.powi(2) / variance;
        to += a.rmse_after.powi(2) / variance;
    }
    1.0 - (to / from).sqrt()
}

fn published() -> SavedModel {
    load_model(crate::published_weights()).expect("the published weights")
}

/// The remainder is learned, and timed, by itself.
fn without_law(settings: &DiagnosisSettings) -> DiagnoseOptions {
    DiagnoseOptions { law: false, settings: *settings, ..DiagnoseOptions::default() }
}

fn run(
    model: &ExtendedModel,
    sets: &RecordingSets<'_>,
    options: &DiagnoseOptions,
    id: &str,
) -> (LawOutcome, Option<(JointDiagnosis, Vec<ChannelReduction>)>) {
    let cpu = || cpu_s().unwrap_or(f64::NAN);
    let start = cpu();
    let none = LawOutcome {
        id: id.to_owned(),
        hidden: false,
        diagnosis: "refused".into(),
        named_before: Vec::new(),
        verdict: "refused".into(),
        named: Vec::new(),
        outcome: String::new(),
        replaced: Vec::new(),
        reasons: Vec::new(),
        law: None,
        parameters: Vec::new(),
        variables: Vec::new(),
        remembers: false,
        right: false,
        depends_on: Vec::new(),
        ranking: Vec::new(),
        reduction: None,
        cpu_s: [0.0; 2],
        wall_s: 0.0,
    };
    let found = match diagnose(model, sets, options, &|_, _| {}) {
        Ok(found) => found,
        Err(e) => return (LawOutcome { outcome: e.to_string(), ..none }, None),
    };
    let between = cpu();
    let named_before = found.named().into_iter().map(str::to_owned).collect();
    let (diagnosis, before) = (found.verdict.to_string(), found.error_reduction.channels.clone());
    let clock = Instant::now();
    let found = match learn_remainder(model, sets, options, found, &|_| {}) {
        Ok(found) => found,
        Err(e) => return (LawOutcome { diagnosis, outcome: e.to_string(), ..none }, None),
    };
    let wall_s = clock.elapsed().as_secs_f64();
    let cpu_s = [between - start, cpu() - between];
    let remainder = found.remainder.as_ref().expect("it was asked for");
    let law = remainder.law.as_ref();
    let mut variables = law.map_or_else(Vec::new, |l| l.variables.clone());
    variables.sort();
    let outcome = LawOutcome {
        diagnosis,
        named_before,
        verdict: found.verdict.to_string(),
        named: match law {
            Some(l) => l.beside.clone(),
            None => found.named().into_iter().map(str::to_owned).collect(),
        },
        outcome: remainder.outcome.to_string(),
        replaced: law.map_or_else(Vec::new, |l| {
            l.replaces.iter().map(|r| (r.effect.clone(), r.reason())).collect()
        }),
        reasons: found.reasons.clone(),
        law: law.map(|l| l.expression.clone()),
        parameters: law.map_or_else(Vec::new, |l| {
            let of = |(n, i): &(String, pam_diagnose::fit::Interval)| {
                (n.clone(), [i.value, i.ci95[0], i.ci95[1]])
            };
            l.parameters.iter().map(of).collect()
        }),
        depends_on: remainder.correction.as_ref().map_or_else(Vec::new, |c| {
            c.depends_on.iter().map(|d| (d.on.clone(), d.error_ratio)).collect()
        }),
        ranking: remainder
            .ranking
            .iter()
            .map(|r| (format!("{} beside {:?}", r.expression, r.beside), r.parameters, r.log_odds))
            .collect(),
        variables,
        remembers: law.is_some_and(|l| l.remembers),
        cpu_s,
        wall_s,
        ..none
    };
    (outcome, Some((found, before)))
}

/// Hides a law in recordings of a length, looks for it, and compares it with itself.
///
/// # Panics
/// If the published weights cannot be read.
#[must_use]
pub fn run_law(
    law: &HiddenLaw,
    seed: u64,
    length_s: f64,
    settings: &DiagnosisSettings,
) -> LawOutcome {
    let saved = published();
    let data = recordings(&saved, law, seed, length_s);
    let model = ExtendedModel::from_saved(saved).expect("no effects");
    let sets = RecordingSets { data: &data, test: None, baseline: None };
    let mut options = without_law(settings);
    options.candidates.retain(|e| !law.without.contains(&e.info().id));
    let (mut outcome, found) = run(&model, &sets, &options, &format!("{}-{seed}", law.id));
    outcome.hidden = true;
    let Some((found, before)) = found else { return outcome };
    let remainder = found.remainder.as_ref().expect("it was asked for");
    let Some(l) = &remainder.law else { return outcome };
    // Friction turns with the velocity, whether the law says so or it is dry.
    let own: Vec<&str> = outcome.variables.iter().map(String::as_str).collect();
    let mut with_velocity = law.variables.to_vec();
    with_velocity.push("v");
    let friction = law.definition.contains("dry_friction_n");
    outcome.right = (own == law.variables
        || (!law.or.is_empty() && own == law.or)
        || (friction && own == with_velocity))
        && l.remembers == law.remembers;
    // What the hidden law itself reaches.
    let text = format!(
        "[[effect]]\nid = \"hidden_law\"\ndescription = \"the hidden law\"\n{}\n",
        law.definition
    );
    let truth = expression::parse(&text).expect("a definition");
    let options = DiagnoseOptions { candidates: truth, ..without_law(settings) };
    if let Ok(best) = diagnose(&model, &sets, &options, &|_, _| {}) {
        let own = reduction(&before, &l.error_reduction.channels);
        outcome.reduction = Some([own, reduction(&before, &best.error_reduction.channels)]);
    }
    outcome
}

/// Looks for a law in a null set.
#[must_use]
pub fn run_null(case: &Case, settings: &DiagnosisSettings) -> LawOutcome {
    let made = data(case);
    let model = ExtendedModel::from_saved(made.model.clone()).expect("no effects");
    let sets =
        RecordingSets { data: &made.subjects, test: None, baseline: made.baseline.as_deref() };
    run(&model, &sets, &without_law(settings), &case.id).0
}
