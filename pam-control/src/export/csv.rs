use super::row;
use crate::synthesis::{Outcome, Plan};
use pam_embedded::table::COLUMNS;
use std::fmt::Write;

/// A plan as CSV: `time_s`, the columns of the binary table with all their digits, the residual of the
/// dynamics, and in the last two columns whether stiffness and training range are kept.
#[must_use]
pub fn table_csv(plan: &Plan) -> String {
    let mut text =
        format!("time_s,{},residual_mn,stiffness_reached,extrapolated\n", COLUMNS.join(","));
    for (sample, (target, solution)) in plan.targets.iter().zip(&plan.solutions).enumerate() {
        let _ = write!(text, "{}", target.time_s);
        for value in row(plan, sample) {
            let _ = write!(text, ",{value}");
        }
        let reached = u8::from(solution.outcome == Outcome::Reached);
        let extrapolated = u8::from(plan.extrapolates(sample));
        let _ = writeln!(text, ",{:e},{reached},{extrapolated}", solution.residual_mn);
    }
    text
}
