use super::over_time;
use crate::mpc::MpcRun;
use maud::html;
use pam_report::figure::Role;
use pam_report::page::{figure, number, page};

/// Time between decisions, µs.
const PERIOD_US: f64 = 1000.0;

/// Content of the report.
#[derive(Debug, Clone)]
pub struct MpcReport {
    /// One sentence on the experiment.
    pub lead: String,
    /// Program and version.
    pub made_by: String,
    /// Stretches of time with both errors (mm): lookup table, MPC.
    pub rows: Vec<(String, f64, f64)>,
    /// The joint under the lookup table.
    pub table: MpcRun,
    /// The joint under MPC.
    pub mpc: MpcRun,
}

/// Both motions, errors, and the estimates of the controller.
#[must_use]
pub fn mpc_report(report: &MpcReport) -> String {
    let (t, r) = (&report.table, &report.mpc);
    let error =
        |m: &MpcRun| m.wanted_mm.iter().zip(&m.measured_mm).map(|(w, x)| x - w).collect::<Vec<_>>();
    let (flexor, extensor) = (Role::Category(0), Role::Category(1));
    let decisions: Vec<f64> = r.decision_s.iter().map(|s| (1e6 * s).min(PERIOD_US)).collect();
    let late = r.decision_s.iter().filter(|s| 1e6 * **s > PERIOD_US).count();
    let body = html! {
        div.scroll { table {
            tr { th { "RMSE (mm)" } th { "lookup table" } th { "MPC" } th { "ratio" } }
            @for (name, a, b) in &report.rows {
                tr { td { (name) } td { (number(*a, 4)) } td { (number(*b, 4)) } td { (number(a / b, 1)) } }
            }
        } }
        (figure(over_time("x (mm)", &r.time_s, &[
            ("target", Role::Measured, r.wanted_mm.clone()),
            ("lookup table", Role::Category(0), t.measured_mm.clone()),
            ("MPC", Role::Predicted, r.measured_mm.clone()),
        ]), ""))
        (figure(over_time("error (mm)", &r.time_s, &[
            ("lookup table", Role::Category(0), error(t)),
            ("MPC", Role::Predicted, error(r)),
        ]), ""))
        (figure(over_time("unexplained force (N)", &r.time_s, &[("", Role::Predicted, r.unexplained_n.clone())]),
            "Estimated force that the model does not contain: load, dry friction, warm air."))
        (figure(over_time("air (g)", &r.time_s, &[
            ("flexor", flexor, r.masses_g.iter().map(|m| m[0]).collect()),
            ("extensor", extensor, r.masses_g.iter().map(|m| m[1]).collect()),
        ]), ""))
        (figure(
            over_time("decision (µs)", &r.time_s, &[("", Role::Neutral, decisions)]),
            &format!(
                "Longer ones are drawn at 1000 µs, the time between decisions: {late} of {}. On a machine that does \
                 other work these are decisions during which the program did not run.",
                r.decision_s.len()
            ),
        ))
    };
    page("Receding-horizon MPC against the lookup table", &report.lead, &body, &report.made_by)
}
