//! Fitted parameters of the joint and their known values.

use crate::page::number;
use maud::{Markup, html};
use pam_core::{JointModel, PhysicalParameters};

/// The trained parameters that Wang and Realmuto (2026) publish.
const PUBLISHED: PhysicalParameters<f64> =
    PhysicalParameters { mass_kg: 304.648, gas_coefficient: 8.47e7, deformation: 3.690_974 };

/// A table of m, C, ν and the auxiliary damping: the model's, the datasheet's, the published ones.
#[must_use]
pub fn parameter_table<F>(model: &JointModel<f64, F>) -> Markup {
    let [own, datasheet, published] =
        [model.physical(), PhysicalParameters::datasheet(), PUBLISHED].map(|p| {
            [number(p.mass_kg, 2), format!("{:.4e}", p.gas_coefficient), number(p.deformation, 4)]
        });
    let names = [
        ("reflected mass m", "kg"),
        ("gas coefficient C", "kPa·mm³/g"),
        ("deformation coefficient ν", "–"),
    ];
    html! {
        div.scroll { table {
            tr {
                th { "parameter" } th.text { "unit" } th { "this model" }
                th { "datasheet" } th { "published, trained" }
            }
            @for (k, (name, unit)) in names.into_iter().enumerate() {
                tr {
                    td { (name) } td.text { (unit) }
                    td { (own[k]) } td { (datasheet[k]) } td { (published[k]) }
                }
            }
            tr {
                td { "auxiliary damping B" } td.text { "kg/s" }
                td { (number(model.auxiliary_damping_kg_s, 0)) } td { "–" } td { "0" }
            }
        } }
    }
}
