//! Summary of a model file.

use crate::console::table;
use crate::options::describe_model;
use num_dual::Dual64;
use pam_autodiff::{FourPointSmoothed, linearise, stiffness_by_difference_n_mm};
use pam_core::{AnyForce, ForceInput, Scalar, SealedMasses};
use pam_data::SavedModel;
use serde_json::{Value, json};

/// Equal air masses at which a model's slopes are shown, g: 170, 412 and 653 kPa at x = 0.
const SHOWN_MASSES_G: [f64; 3] = [0.031_527_2, 0.076_314_35, 0.121_101_5];

/// Parameters, size and slopes of a model, as text and as JSON.
pub(super) fn model(saved: &SavedModel) -> (String, Value) {
    let p = saved.model.physical();
    let dual: AnyForce<Dual64> = saved.model.force.map(Dual64::constant);
    let mut rows = vec![
        ["m_f = m_e (g)", "P at x = 0 (kPa)", "K exact (N/mm)", "K h = 1 mm", "B exact (kg/s)"]
            .map(str::to_owned)
            .to_vec(),
    ];
    let mut slopes = Vec::new();
    for mass in SHOWN_MASSES_G {
        let at = ForceInput {
            displacement_mm: 0.0,
            velocity_mm_s: 0.0,
            mass_flexor_g: mass,
            mass_extensor_g: mass,
        };
        let line = linearise(&dual, &at);
        let smoothed =
            stiffness_by_difference_n_mm(&saved.model.force, &at, &FourPointSmoothed::default());
        let masses = SealedMasses { flexor_g: mass, extensor_g: mass };
        let pressure = saved.model.gas_law_pressures_kpa(0.0, masses)[0];
        rows.push(vec![
            format!("{mass:.7}"),
            format!("{pressure:.1}"),
            format!("{:.2}", line.stiffness_n_mm),
            format!("{smoothed:.2}"),
            format!("{:.1}", line.damping_kg_s),
        ]);
        slopes.push(json!({
            "mass_flexor_g": mass,
            "mass_extensor_g": mass,
            "pressure_kpa": pressure,
            "stiffness_exact_n_mm": line.stiffness_n_mm,
            "stiffness_four_point_n_mm": smoothed,
            "damping_exact_kg_s": line.damping_kg_s,
            "force_mn": line.force_mn,
        }));
    }
    let text = format!(
        "  {}\n  {}\n  muscles {} mm x {} mm (radius x length); auxiliary damping {} kg/s; {}\n  at x = 0, v = 0:\n{}",
        describe_model(saved),
        saved.info.provenance,
        saved.model.geometry.radius_mm,
        saved.model.geometry.length_mm,
        saved.model.auxiliary_damping_kg_s,
        if saved.info.trained { "trained" } else { "not trained" },
        table(&rows)
    );
    let mut value = json!({
        "name": saved.info.name,
        "provenance": saved.info.provenance,
        "trained": saved.info.trained,
        "force": saved.model.force.kind(),
        "mass_kg": p.mass_kg,
        "gas_coefficient_kpa_mm3_per_g": p.gas_coefficient,
        "deformation": p.deformation,
        "radius_mm": saved.model.geometry.radius_mm,
        "length_mm": saved.model.geometry.length_mm,
        "auxiliary_damping_kg_s": saved.model.auxiliary_damping_kg_s,
        "slopes": slopes,
    });
    if !saved.info.effects.is_empty() {
        value["effects"] = json!(saved.info.effects);
    }
    if let AnyForce::Network(n) = &saved.model.force {
        let widths: Vec<usize> = n.mlp().layers().iter().map(|l| l.outputs()).collect();
        value["activation"] = json!(n.mlp().activation().name());
        value["layer_outputs"] = json!(widths);
        value["parameters"] = json!(n.mlp().parameter_count() + 3);
    }
    (text, value)
}
