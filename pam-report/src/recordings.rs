//! The report of recordings, before any model.

use crate::figure::{ColourMap, LineFigure, MapPoint, Role, ValuePlane, envelope, thin};
use crate::page::{figure, number, page};
use maud::{Markup, html};
use pam_core::units::MN_PER_N;
use pam_data::{Channel, Recording};

/// Pixel columns of a time series.
const BUCKETS: usize = 700;
/// Points of a loop.
const LOOP_POINTS: usize = 4000;
/// Fewest recordings that make a map.
const FEWEST_MAPPED: usize = 6;

/// A recording in numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedRun {
    /// Its name.
    pub name: String,
    /// Pressures when the excitation began, psi gauge.
    pub sealed_psi: [f64; 2],
    /// Smallest and largest displacement, mm.
    pub displacement_mm: [f64; 2],
    /// Frames of the log.
    pub frames: usize,
}

/// All recordings in a table and on a map, some of them drawn, as HTML text. `lead` stands under the
/// title, `made_by` at the foot.
#[must_use]
pub fn recordings_report(
    title: &str,
    lead: &str,
    runs: &[RecordedRun],
    drawn: &[Recording],
    made_by: &str,
) -> String {
    let body = html! {
        @if runs.len() >= FEWEST_MAPPED { (maps(runs)) }
        @for recording in drawn { (time_series(recording)) }
        h2 { "All recordings" }
        (table(runs))
    };
    page(title, lead, &body, made_by)
}

fn maps(runs: &[RecordedRun]) -> Markup {
    let middle = |r: &RecordedRun| 0.5 * (r.displacement_mm[0] + r.displacement_mm[1]);
    let reach = |r: &RecordedRun| 0.5 * (r.displacement_mm[1] - r.displacement_mm[0]);
    html! {
        h2 { "Over the pressures" }
        div.grid {
            (map(runs, "middle of the motion (mm)", middle))
            (map(runs, "half of its range (mm)", reach))
        }
    }
}

fn map(runs: &[RecordedRun], label: &str, value: impl Fn(&RecordedRun) -> f64) -> Markup {
    let points: Vec<MapPoint> = runs
        .iter()
        .map(|r| MapPoint {
            x: r.sealed_psi[0],
            y: r.sealed_psi[1],
            value: value(r),
            ringed: false,
        })
        .collect();
    let values = || points.iter().map(|p| p.value).filter(|v| v.is_finite());
    let limits = (values().fold(f64::MAX, f64::min), values().fold(f64::MIN, f64::max));
    let limits = if limits.0 < limits.1 { limits } else { (limits.0 - 0.5, limits.0 + 0.5) };
    let map = ColourMap {
        plane: ValuePlane {
            title: label.into(),
            x_label: "flexor (psi gauge)".into(),
            y_label: "extensor (psi gauge)".into(),
            value_label: label.into(),
            limits,
            size: (520, 400),
        },
        points,
        ring_label: String::new(),
    };
    figure(map.to_svg(), "")
}

fn time_series(recording: &Recording) -> Markup {
    let force_n: Vec<f64> = recording.force_mn.iter().map(|f| f / MN_PER_N).collect();
    let series = |label: &str, values: &[f64]| {
        let plot = LineFigure::new("", "time (s)", label, 1040, 200);
        let points = envelope(&recording.time_s, values, BUCKETS);
        figure(plot.with("", Role::Measured, points).to_svg(), "")
    };
    let loop_over = |x: &[f64], x_label: &str, y: &[f64], y_label: &str, caption: &str| {
        let plot = LineFigure::new("", x_label, y_label, 370, 310);
        figure(plot.with("", Role::Measured, thin(x, y, LOOP_POINTS)).to_svg(), caption)
    };
    let (force, x) = ("force of the motor (N)", &recording.displacement_mm);
    html! {
        h2 { (recording.name) }
        @if !recording.preprocessing.is_empty() { p.sub { "As the loader reads it: " (recording.preprocessing) "." } }
        @for note in &recording.notes { p.note { (note) } }
        (series(force, &force_n))
        @for c in Channel::ALL { (series(c.label(), recording.channel(c))) }
        div class="grid three" {
            (loop_over(x, Channel::X.label(), &force_n, force, "x–F: its area is the work that is lost."))
            @for c in [Channel::Pf, Channel::Pe] {
                (loop_over(x, Channel::X.label(), recording.channel(c), c.label(), "x–P: open by heat and the sensor's lag."))
            }
        }
    }
}

fn table(runs: &[RecordedRun]) -> Markup {
    html! {
        div.scroll { table {
            thead { tr {
                @for name in ["recording", "flexor (psi)", "extensor (psi)", "x from (mm)", "to (mm)", "frames"] {
                    th { (name) }
                }
            } }
            tbody { @for r in runs { tr {
                td { (r.name) }
                @for p in r.sealed_psi { td { (number(p, 2)) } }
                @for x in r.displacement_mm { td { (number(x, 3)) } }
                td { (r.frames) }
            } } }
        } }
    }
}
