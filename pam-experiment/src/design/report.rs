//! A design as a page.

use super::search::Design;
use maud::{Markup, html};
use pam_core::units::significant;
use pam_report::figure::{LineFigure, Role};
use pam_report::page::{card, figure, page};
use pam_rig::protocol::CurrentSegment;

/// Points of the figure of the current.
const POINTS: usize = 1500;

/// The design as a page; `model_line` describes the model.
#[must_use]
pub fn design_report(d: &Design, model_line: &str, made_by: &str) -> String {
    let number = |v: Option<f64>| v.map_or_else(|| "–".to_owned(), |v| significant(v, 3));
    let body = html! {
        div.cards {
            (card(&format!("{:.1}", d.median_factor), "median factor of the detection limits"))
            (card(&format!("{:.0} s", d.protocol.duration_s()), "length of a recording"))
            (card(&d.evaluations.to_string(), "protocols simulated"))
        }
        p { (d.sentence()) }
        h2 { "Protocol" }
        (figure(current(d), "The current of every recording."))
        (segments(d))
        @if !d.separations.is_empty() {
            h2 { "Separation of live causes" }
            p { "How far a cause is from the other one fitted in its place, over what a diagnosis needs: from 1 on it distinguishes them." }
            table {
                thead { tr { th { "cause" } th { "other" } th { "published" } th { "designed" } } }
                tbody {
                    @for s in &d.separations {
                        tr { td { (s.cause) } td { (s.other) } td { (format!("{:.2}", s.standard)) } td { (format!("{:.2}", s.designed)) } }
                    }
                }
            }
        }
        h2 { "Detection limits" }
        table {
            thead { tr { th { "effect" } th { "parameter" } th { "published" } th { "designed" } th { "factor" } } }
            tbody {
                @for g in &d.gains {
                    tr { td { (g.label) } td { code { (g.parameter) } } td { (number(g.standard)) } td { (number(g.designed)) } td { (number(g.factor)) } }
                }
            }
        }
    };
    page("Designed protocol", model_line, &body, made_by)
}

fn current(d: &Design) -> String {
    let length = d.protocol.duration_s();
    let points = (0..POINTS).map(|k| {
        let t = length * k as f64 / POINTS as f64;
        (t, d.protocol.current_a(t, 1))
    });
    LineFigure::new("Motor current", "time (s)", "current (A)", 760, 240)
        .with("current", Role::Measured, points.collect())
        .to_svg()
}

fn segments(d: &Design) -> Markup {
    let n = |v: &f64| significant(*v, 3);
    let words = |s: &CurrentSegment| match s {
        CurrentSegment::Rest { .. } => "rest".to_owned(),
        CurrentSegment::Sine { amplitude_a, frequency_hz, .. } => {
            format!("sine of {} A at {} Hz", n(amplitude_a), n(frequency_hz))
        }
        CurrentSegment::Multisine { components, .. } => {
            let each = components.iter().map(|[a, hz, _]| format!("{} A at {} Hz", n(a), n(hz)));
            format!("sum of sines: {}", each.collect::<Vec<_>>().join(", "))
        }
        CurrentSegment::Triangle { amplitude_a, frequency_hz, .. } => {
            format!("triangle of {} A at {} Hz", n(amplitude_a), n(frequency_hz))
        }
        CurrentSegment::Chirp { amplitude_a, from_hz, to_hz, .. } => {
            format!("chirp of {} A from {} to {} Hz", n(amplitude_a), n(from_hz), n(to_hz))
        }
        CurrentSegment::Pulses { amplitude_a, period_s, .. } => {
            format!("steps of {} A every {} s", n(amplitude_a), n(period_s))
        }
        CurrentSegment::Constant { amplitude_a, .. } => format!("hold at {} A", n(amplitude_a)),
        other => format!("{other:?}"),
    };
    let psi = d.protocol.conditions.as_ref().map(pam_rig::Conditions::psi).unwrap_or_default();
    html! {
        p { "Sealed pressures (psi gauge, flexor/extensor): " (psi.iter().map(|[f, e]| format!("{f}/{e}")).collect::<Vec<_>>().join(", ")) "." }
        table {
            thead { tr { th { "length (s)" } th { "current" } } }
            tbody { @for s in &d.protocol.current { tr { td { (format!("{:.2}", s.duration_s())) } td { (words(s)) } } } }
        }
    }
}
