use super::over_time;
use crate::synthesis::Plan;
use maud::html;
use pam_report::figure::Role;
use pam_report::page::{card, figure, number, page};

/// A plan: motion, stiffness wanted and had, air, pressures, residuals.
#[must_use]
pub fn plan_report(plan: &Plan, title: &str, lead: &str, made_by: &str) -> String {
    let s = plan.summary();
    let time: Vec<f64> = plan.targets.iter().map(|t| t.time_s).collect();
    let target = |f: fn(&crate::synthesis::Target) -> f64| plan.targets.iter().map(f).collect();
    let solution =
        |f: fn(&crate::synthesis::Solution) -> f64| plan.solutions.iter().map(f).collect();
    let pressure = |i: usize| plan.pressures_kpa.iter().map(|p| p[i]).collect();
    let (flexor, extensor) = (Role::Category(0), Role::Category(1));
    let body = html! {
        div.cards {
            (card(&format!("{} of {}", s.reached, s.samples), "samples reach their stiffness"))
            (card(&format!("{:.1e} mN", s.largest_residual_mn), "largest residual of the dynamics"))
            (card(&format!("{} N/mm", number(s.largest_stiffness_error_n_mm, 2)), "largest stiffness error"))
            (card(&s.extrapolated.to_string(), "samples outside the trained masses"))
        }
        @if s.nearest_stiffness > 0 {
            div class="note warn" {
                (s.nearest_stiffness) " samples cannot reach the target stiffness with this motion; they hold "
                "the nearest one that can be had."
            }
        }
        (figure(over_time("x (mm)", &time, &[("target", Role::Measured, target(|t| t.displacement_mm))]), ""))
        (figure(over_time("stiffness (N/mm)", &time, &[
            ("target", Role::Measured, target(|t| t.stiffness_n_mm)),
            ("planned", Role::Predicted, solution(|s| s.stiffness_n_mm)),
        ]), ""))
        (figure(over_time("air (g)", &time, &[
            ("flexor", flexor, solution(|s| s.masses.flexor_g)),
            ("extensor", extensor, solution(|s| s.masses.extensor_g)),
        ]), ""))
        (figure(over_time("pressure (kPa absolute)", &time, &[("flexor", flexor, pressure(0)), ("extensor", extensor, pressure(1))]), ""))
    };
    page(title, lead, &body, made_by)
}
