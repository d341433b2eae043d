//! The report of a simulated trajectory.

use crate::figure::{LineFigure, Role, envelope, thin};
use crate::page::{figure, page};
use maud::html;
use pam_core::units::MN_PER_N;
use pam_data::{Channel, Recording};

/// Pixel columns of a time series.
const BUCKETS: usize = 700;
/// Points of a loop.
const LOOP_POINTS: usize = 4000;

/// Time series of force and states, and the x–F and P–F loops, as HTML text. `lead` stands under the
/// title, `made_by` at the foot.
#[must_use]
pub fn simulation_report(trajectory: &Recording, title: &str, lead: &str, made_by: &str) -> String {
    let force_n: Vec<f64> = trajectory.force_mn.iter().map(|f| f / MN_PER_N).collect();
    let series = |label: &str, values: &[f64]| {
        let points = envelope(&trajectory.time_s, values, BUCKETS);
        let plot = LineFigure::new("", "time (s)", label, 1040, 210);
        figure(plot.with("", Role::Predicted, points).to_svg(), "")
    };
    let x = &trajectory.displacement_mm;
    let x_loop = LineFigure::new("", Channel::X.label(), "external force (N)", 370, 310).with(
        "",
        Role::Predicted,
        thin(x, &force_n, LOOP_POINTS),
    );
    let pressure_loop = |c: Channel| {
        LineFigure::new("", "external force (N)", c.label(), 370, 310)
            .with("", Role::Predicted, thin(&force_n, trajectory.channel(c), LOOP_POINTS))
            .to_svg()
    };
    let body = html! {
        h2 { "Time series" }
        (series("external force (N)", &force_n))
        @for c in Channel::ALL { (series(c.label(), trajectory.channel(c))) }
        h2 { "Loops" }
        div class="grid three" {
            (figure(x_loop.to_svg(), "x–F: the area of the loop is the work that the model dissipates."))
            (figure(pressure_loop(Channel::Pf), "P–F, flexor"))
            (figure(pressure_loop(Channel::Pe), "P–F, extensor"))
        }
    };
    page(title, lead, &body, made_by)
}
