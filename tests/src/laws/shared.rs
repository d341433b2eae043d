//! Laws that several lists have, with numbers and starting values of each.

use super::{HiddenLaw, law};

/// `F = −k x³`, with k up to a largest one.
pub(super) fn cubic_spring(n_mm3: f64, largest: f64, start: f64) -> HiddenLaw {
    let definition = format!(
        "parameters.k = {{ range = [0, {largest:?}], absent = 0, start = [{start:?}] }}\nacts.force_n = \"-k * x^3\""
    );
    law("cubic_spring", &[("n_mm3", n_mm3)], definition, &["x"])
}

/// `F = −c v |v|`.
pub(super) fn quadratic_drag(n_s2_mm2: f64, start: f64) -> HiddenLaw {
    let definition = format!(
        "parameters.c = {{ range = [0, 10], absent = 0, start = [{start:?}] }}\nacts.force_n = \"-c * v * abs(v)\""
    );
    law("quadratic_drag", &[("n_s2_mm2", n_s2_mm2)], definition, &["v"])
}

/// `F = −k max(x − x₀, 0)`.
pub(super) fn soft_stop([n_mm, from_mm]: [f64; 2], start: f64, starts_mm: [f64; 2]) -> HiddenLaw {
    let definition = format!(
        "parameters.k = {{ range = [0, 500], absent = 0, start = [{start:?}] }}\nparameters.from_mm = {{ range = [0.01, 5], log = true, start = {starts_mm:?} }}\nacts.force_n = \"-k * max(x - from_mm, 0)\""
    );
    law("soft_stop", &[("n_mm", n_mm), ("from_mm", from_mm)], definition, &["x"])
}

/// `F = −c (P_f + P_e − 2 P_atm) v`.
pub(super) fn pressure_damping(n_s_mm_kpa: f64, start: f64) -> HiddenLaw {
    let definition = format!(
        "parameters.c = {{ range = [0, 1], absent = 0, start = [{start:?}] }}\nacts.force_n = \"-c * (pf + pe - 2 * p_atm) * v\""
    );
    law("pressure_damping", &[("n_s_mm_kpa", n_s_mm_kpa)], definition, &["pe", "pf", "v"])
}

/// `F = −c (P_f + P_e) v` with the absolute pressures.
pub(super) fn braid_damping(n_s_mm_kpa: f64, start: f64) -> HiddenLaw {
    let definition = format!(
        "parameters.c = {{ range = [0, 1], absent = 0, start = [{start:?}] }}\nacts.force_n = \"-c * (pf + pe) * v\""
    );
    law("braid_damping", &[("n_s_mm_kpa", n_s_mm_kpa)], definition, &["pe", "pf", "v"])
}

/// `F = −c v / (1 + |v|/w)`.
pub(super) fn grease_thinning(
    [n_s_mm, mm_s]: [f64; 2],
    start: f64,
    starts_mm_s: [f64; 2],
) -> HiddenLaw {
    let definition = format!(
        "parameters.c = {{ range = [0, 100], absent = 0, start = [{start:?}] }}\nparameters.w = {{ range = [0.1, 100], log = true, start = {starts_mm_s:?} }}\nacts.force_n = \"-c * v / (1 + abs(v) / w)\""
    );
    law("grease_thinning", &[("n_s_mm", n_s_mm), ("mm_s", mm_s)], definition, &["v"])
}

/// `F = −c z F_drive` with `ż = (F_drive² − z)/τ`.
pub(super) fn motor_heating([per_n2, tau_s]: [f64; 2], start: f64, starts_s: &[f64]) -> HiddenLaw {
    let definition = format!(
        "parameters.c = {{ range = [0, 1e-3], absent = 0, start = [{start:?}] }}\nparameters.tau_s = {{ range = [0.01, 100], log = true, start = {starts_s:?} }}\nmemory.z = {{ start = \"0\", rate = \"(force^2 - z) / tau_s\" }}\nacts.force_n = \"-c * z * force\""
    );
    let values = [("per_n2", per_n2), ("tau_s", tau_s)];
    HiddenLaw { remembers: true, ..law("motor_heating", &values, definition, &["force"]) }
}

/// Dry friction `c |x|`.
pub(super) fn edge_friction(n_mm: f64) -> HiddenLaw {
    let definition = "parameters.c = { range = [0, 500], absent = 0, start = [5] }\nacts.dry_friction_n = \"c * abs(x)\"";
    law("edge_friction", &[("n_mm", n_mm)], definition, &["x"])
}

/// Dry friction `c x²`.
pub(super) fn worn_guide(n_mm2: f64, start: f64) -> HiddenLaw {
    let definition = format!(
        "parameters.c = {{ range = [0, 500], absent = 0, start = [{start:?}] }}\nacts.dry_friction_n = \"c * x^2\""
    );
    // A dry friction opposes the velocity, whether or not its level depends on it.
    HiddenLaw { or: &["v", "x"], ..law("worn_guide", &[("n_mm2", n_mm2)], definition, &["x"]) }
}

/// Dry friction `c max(P_f + P_e − 2 P_atm, 0)`.
pub(super) fn pressure_friction(n_kpa: f64, start: f64) -> HiddenLaw {
    let definition = format!(
        "parameters.c = {{ range = [0, 1], absent = 0, start = [{start:?}] }}\nacts.dry_friction_n = \"c * max(pf + pe - 2 * p_atm, 0)\""
    );
    // The candidate is the same law, with the mean of the two gauge pressures in the place of their sum.
    HiddenLaw {
        without: &["load_friction"],
        ..law("pressure_friction", &[("n_kpa", n_kpa)], definition, &["pe", "pf"])
    }
}

/// Dry friction `n / (1 + z)` of 12 N at rest, with `ż = (|v|/w − z)/τ` and `w` 5 mm/s.
pub(super) fn warm_grease(tau_s: f64, starts_s: [f64; 2]) -> HiddenLaw {
    let definition = format!(
        "parameters.n = {{ range = [0, 500], absent = 0, start = [8] }}\nparameters.w = {{ range = [0.1, 100], log = true, start = [4, 7] }}\nparameters.tau_s = {{ range = [0.01, 100], log = true, start = {starts_s:?} }}\nmemory.z = {{ start = \"0\", rate = \"(abs(v) / w - z) / tau_s\" }}\nacts.dry_friction_n = \"n / (1 + z)\""
    );
    let values = [("n", 12.0), ("mm_s", 5.0), ("tau_s", tau_s)];
    HiddenLaw { remembers: true, ..law("warm_grease", &values, definition, &["v"]) }
}

/// Air from the flexor to the extensor, `c (P_f − P_e)`.
pub(super) fn cross_leak(g_s_kpa: f64, start: f64) -> HiddenLaw {
    let definition = format!(
        "parameters.c = {{ range = [0, 1e-3], absent = 0, start = [{start:?}] }}\nlet.flow = \"c * (pf - pe)\"\nacts.air_flexor_g_s = \"-flow\"\nacts.air_extensor_g_s = \"flow\""
    );
    law("cross_leak", &[("g_s_kpa", g_s_kpa)], definition, &["pe", "pf"])
}

/// Air into the flexor `−c (P_f − z)` with `ż = (P_f − z)/τ`.
///
/// Written when a memory state could not begin at a pressure: for ten milliseconds it catches up with the one at rest, and nothing flows.
pub(super) fn side_volume([g_s_kpa, tau_s]: [f64; 2], start: f64, starts_s: [f64; 2]) -> HiddenLaw {
    let definition = format!(
        "parameters.c = {{ range = [0, 1], absent = 0, start = [{start:?}] }}\nparameters.tau_s = {{ range = [0.01, 100], log = true, start = {starts_s:?} }}\nmemory.z = {{ start = \"400\", rate = \"(pf - z) / if(t < 0.01, 1e-3, tau_s)\" }}\nacts.air_flexor_g_s = \"-c * (pf - z) * (t >= 0.01)\""
    );
    let values = [("g_s_kpa", g_s_kpa), ("tau_s", tau_s)];
    HiddenLaw { remembers: true, ..law("side_volume", &values, definition, &["pf"]) }
}

/// Reading of the displacement `x + c F_drive`.
pub(super) fn force_in_reading(id: &'static str, mm_n: f64, start: f64) -> HiddenLaw {
    let definition = format!(
        "parameters.c = {{ range = [-1, 1], absent = 0, start = [{start:?}] }}\nacts.position_mm = \"x + c * force\""
    );
    law(id, &[("mm_n", mm_n)], definition, &["force"])
}
