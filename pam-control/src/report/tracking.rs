use super::over_time;
use crate::experiments::tracking::{SERIES, SHAPES, TrackingResult};
use maud::{Markup, html};
use pam_report::figure::{LineFigure, Role, Stroke};
use pam_report::page::{figure, number, page};

/// Errors of all tests with the published ones, and the motion in some of them.
#[must_use]
pub fn tracking_report(results: &[TrackingResult], lead: &str, made_by: &str) -> String {
    let curve = |shape: &str, series: &str| {
        let of = |r: &&TrackingResult| r.case.shape == shape && r.case.series == series;
        let x = |r: &TrackingResult| match series {
            "amplitude" => r.case.amplitude_mm,
            "frequency" => r.case.frequency_hz,
            _ => r.case.stiffness_n_mm,
        };
        let label = match series {
            "amplitude" => "amplitude (mm)",
            "frequency" => "frequency (Hz)",
            _ => "stiffness (N/mm)",
        };
        let points = |y: fn(&TrackingResult) -> f64| {
            results.iter().filter(of).map(|r| (x(r), y(r))).collect::<Vec<_>>()
        };
        if results.iter().filter(of).count() == 0 {
            return None;
        }
        Some(
            LineFigure::new(shape, label, "RMSE (mm)", 340, 260)
                .with_marks()
                .with("rig", Role::Predicted, points(|r| r.rmse_mm))
                .with_stroke(
                    "published",
                    Role::Measured,
                    Stroke::Dashed,
                    points(|r| r.case.published_mm),
                )
                .to_svg(),
        )
    };
    let body = html! {
        div class="grid three" {
            @for shape in SHAPES {
                @for series in SERIES {
                    @if let Some(svg) = curve(shape, series) { (figure(svg, "")) }
                }
            }
        }
        div.scroll { table {
            tr {
                th { "motion" } th { "varied" } th { "A (mm)" } th { "f (Hz)" } th { "K (N/mm)" }
                th { "RMSE (mm)" } th { "published (mm)" } th { "pressure RMSE (kPa)" }
                th { "stiffness not reached (samples)" }
            }
            @for r in results {
                tr {
                    td { (r.case.shape) } td { (r.case.series) } td { (r.case.amplitude_mm) }
                    td { (r.case.frequency_hz) } td { (r.case.stiffness_n_mm) }
                    td { (number(r.rmse_mm, 3)) } td { (number(r.case.published_mm, 3)) }
                    td { (number(r.pressure_rmse_kpa, 1)) } td { (r.plan.nearest_stiffness) }
                }
            }
        } }
        (differences(results))
        @for r in results.iter().filter(|r| r.case.series == "frequency") {
            h3 { (r.case.shape) ", " (r.case.frequency_hz) " Hz" }
            (figure(over_time("x (mm)", &r.followed.time_s, &[
                ("target", Role::Measured, r.followed.wanted_mm.clone()),
                ("measured", Role::Predicted, r.followed.measured_mm.clone()),
            ]), ""))
        }
    };
    page("Tracking on the virtual rig", lead, &body, made_by)
}

/// Why errors differ from the published ones, with the numbers of these tests.
fn differences(results: &[TrackingResult]) -> Markup {
    let of = |shape: &'static str| {
        let mut all: Vec<&TrackingResult> = results
            .iter()
            .filter(|r| r.case.shape == shape && r.case.series == "frequency")
            .collect();
        all.sort_by(|a, b| a.case.frequency_hz.total_cmp(&b.case.frequency_hz));
        Some((shape, *all.first()?, *all.last()?))
    };
    let spans: Vec<_> = SHAPES.into_iter().filter_map(of).collect();
    let held: usize = results.iter().filter(|r| r.plan.nearest_stiffness > 0).count();
    html! {
        @if !spans.is_empty() {
            h3 { "Why these differ from the published errors" }
            p {
                "The error is a matter of the servo: "
                @for (k, (shape, slow, fast)) in spans.iter().enumerate() {
                    @if k > 0 { "; " }
                    "of the " (shape) ", the pressures miss the commanded ones by "
                    (number(slow.pressure_rmse_kpa, 1)) " kPa (RMS) at " (slow.case.frequency_hz) " Hz and by "
                    (number(fast.pressure_rmse_kpa, 1)) " kPa at " (fast.case.frequency_hz) " Hz, and the motion by "
                    (number(slow.rmse_mm, 3)) " and " (number(fast.rmse_mm, 3)) " mm (published "
                    (number(slow.case.published_mm, 3)) " and " (number(fast.case.published_mm, 3)) ")"
                }
                ". Pulses with pauses between them pass a share of the valve's flow only, so the error grows with \
                 frequency, as published; how early is set by the valves' conductance. At low frequency what is \
                 left is dry friction: the joint stops short of the peaks (figures below)."
            }
        }
        @if held > 0 {
            p {
                "In " (held) " of " (results.len()) " tests the stiffness cannot be had everywhere in the motion; the \
                 nearest is held there, which the published tests do not report."
            }
        }
    }
}
