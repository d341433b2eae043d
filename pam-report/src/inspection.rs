//! The report of recordings before any model is fitted: what they are worth, and what is wrong with them.

use crate::figure::{LineFigure, Role, envelope, thin};
use crate::page::{figure, number, page};
use maud::{Markup, html};
use pam_core::units::{MN_PER_N, significant};
use pam_data::plausibility::{Finding, Severity};
use pam_data::preprocess::gradient_at_times;
use pam_data::quality::{Quality, QualitySettings};
use pam_data::{Channel, Recording};

/// Pixel columns of a time series.
const BUCKETS: usize = 700;
/// Points of a loop.
const LOOP_POINTS: usize = 3000;
/// Delays below it are printed as none, ms.
const LEAST_LAG_MS: f64 = 0.05;
/// Most recordings that are drawn.
const MOST_DRAWN: usize = 12;

/// A recording with what was found in it.
#[derive(Debug, Clone)]
pub struct InspectedRun {
    /// The recording.
    pub recording: Recording,
    /// Its quality.
    pub quality: Quality,
}

/// The report as HTML text. `findings` are what contradicts the physics of the joint.
#[must_use]
pub fn inspection_report(
    title: &str,
    lead: &str,
    runs: &[InspectedRun],
    findings: &[Finding],
    made_by: &str,
) -> String {
    let body = html! {
        h2 { "Against the physics of the joint" }
        @if findings.is_empty() {
            p { "Units, signs, order and zero of the columns fit a joint with two sealed muscles." }
        }
        @for f in findings { (sentence(f.severity, &f.to_string())) }
        h2 { "Sampling" }
        (sampling(runs))
        @for run in runs.iter().take(MOST_DRAWN) { (drawn(run)) }
        @if runs.len() > MOST_DRAWN {
            p { (runs.len() - MOST_DRAWN) " more recordings are not drawn." }
            @for run in runs.iter().skip(MOST_DRAWN) { (sentences(run)) }
        }
    };
    page(title, lead, &body, made_by)
}

fn sentence(severity: Severity, text: &str) -> Markup {
    match severity {
        Severity::Error => html! { p class="note warn" { b { "Wrong: " } (text) } },
        Severity::Warning => html! { p.note { (text) } },
    }
}

fn sampling(runs: &[InspectedRun]) -> Markup {
    html! {
        div.scroll { table {
            tr { @for name in ["recording", "rate (Hz)", "duration (s)", "jitter (%)", "longest step (s)", "travel (mm)", "reversals", "acceleration independent of x, v (%)"] { th { (name) } } }
            @for run in runs {
                @let (t, e) = (&run.quality.timing, &run.quality.excitation);
                tr {
                    td { (run.recording.name) }
                    td { (number(t.rate_hz, 2)) } td { (number(t.duration_s, 2)) }
                    td { (number(100.0 * t.jitter_share, 2)) } td { (number(t.longest_step_s, 4)) }
                    td { (number(e.travel_mm, 3)) } td { (e.reversals) }
                    td { (number(100.0 * e.open_acceleration, 1)) }
                }
            }
        } }
    }
}

fn sentences(run: &InspectedRun) -> Markup {
    html! {
        h2 { (run.recording.name) }
        @for note in &run.recording.notes { p.sub { (note) } }
        @if run.quality.findings.is_empty() { p { "Nothing stands out in the channels." } }
        @for f in &run.quality.findings { (sentence(f.severity, &f.message)) }
    }
}

fn drawn(run: &InspectedRun) -> Markup {
    let r = &run.recording;
    let force_n: Vec<f64> = r.force_mn.iter().map(|f| f / MN_PER_N).collect();
    let x = &r.displacement_mm;
    let series = |label: &str, values: &[f64]| {
        let plot = LineFigure::new("", "time (s)", label, 1040, 190);
        figure(plot.with("", Role::Measured, envelope(&r.time_s, values, BUCKETS)).to_svg(), "")
    };
    let steps_ms: Vec<f64> = r.time_s.windows(2).map(|w| 1e3 * (w[1] - w[0])).collect();
    let plot = |x_label: &str, x: &[f64], y_label: &str, y: &[f64], caption: &str| {
        let plot = LineFigure::new("", x_label, y_label, 370, 300);
        figure(plot.with("", Role::Measured, thin(x, y, LOOP_POINTS)).to_svg(), caption)
    };
    let slope = gradient_at_times(x, &r.time_s);
    let x_label = Channel::X.label();
    html! {
        (sentences(run))
        (channels(&run.quality))
        ul { @for s in run.quality.excitation.sentences(&QualitySettings::default()) { li { (s) } } }
        (series("force (N)", &force_n))
        @for c in Channel::ALL { (series(c.label(), r.channel(c))) }
        div class="grid three" {
            (plot("time (s)", &r.time_s[1..], "time step (ms)", &steps_ms, "A level line: equal steps. Spikes are lost samples."))
            (plot("dx/dt (mm/s)", &slope, Channel::V.label(), &r.velocity_mm_s, "A straight line of slope 1: the velocity is the derivative. A loop is a delay."))
            (plot(x_label, x, "force (N)", &force_n, "Rises with x: the joint yields to the force. The area is the work that is lost."))
            (plot(x_label, x, Channel::Pf.label(), &r.pressure_flexor_kpa, "Falls with x: the flexor's air expands. Flat tops are clipped."))
            (plot(x_label, x, Channel::Pe.label(), &r.pressure_extensor_kpa, "Rises with x: the extensor's air is compressed."))
        }
    }
}

/// A delay in words.
fn lag(delay_s: f64) -> String {
    let ms = 1e3 * delay_s;
    if ms.abs() < LEAST_LAG_MS {
        "together with".to_owned()
    } else {
        format!("{} ms {}", number(ms.abs(), 1), if ms > 0.0 { "after" } else { "before" })
    }
}

fn channels(quality: &Quality) -> Markup {
    html! {
        div.scroll { table {
            tr { @for name in ["channel", "unit", "lowest", "highest", "mean", "noise", "resolution", "drift", "clipped (%)"] { th { (name) } } }
            @for c in &quality.channels { tr {
                td { (c.column) } td.text { (c.unit) }
                td { (number(c.lowest, 3)) } td { (number(c.highest, 3)) } td { (number(c.mean, 3)) }
                td { (significant(c.noise, 3)) }
                td { @match c.resolution { Some(step) => (significant(step, 3)), None => "–" } }
                td { (number(c.drift, 3)) }
                td { (number(100.0 * (c.saturation.at_lowest_share + c.saturation.at_highest_share), 1)) }
            } }
        } }
        @if !quality.delays.is_empty() {
            p.sub {
                "Delays: "
                @for (k, d) in quality.delays.iter().enumerate() {
                    @if k > 0 { "; " }
                    (d.column) " " (lag(d.delay_s)) " " (d.behind)
                }
                "."
            }
        }
    }
}
