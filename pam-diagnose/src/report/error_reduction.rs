//! Errors before and after on the test set.

use crate::diagnosis::Diagnosis;
use crate::search::OutputInfo;
use crate::test_set::{GroupReduction, Trace};
use maud::{Markup, html};
use pam_report::figure::{envelope, thin};
use pam_report::page::{figure, number};
use pam_report::{LineFigure, Role};

/// Recordings that are shown.
const SHOWN: usize = 3;
/// Seconds of a time series that are shown.
const SHOWN_S: f64 = 12.0;
/// Points of a curve.
const POINTS: usize = 3000;

pub(super) fn section<M>(d: &Diagnosis<M>) -> Markup {
    let named = d.is_extended();
    let label = |o: &OutputInfo| format!("{} ({})", o.name, o.unit);
    // The first output, and the second fitted one.
    let shown: Vec<(usize, String)> = d
        .outputs
        .iter()
        .enumerate()
        .filter(|(_, o)| o.fitted)
        .map(|(c, o)| (c, label(o)))
        .take(2)
        .collect();
    html! {
        p { (d.test.sentence()) " Intervals by block bootstrap, drawn frequency by frequency." }
        div.scroll { table {
            tr { th { "channel" } th { "RMSE before" } th { "after" } th { "reduction, 95 % interval" } th { "R² before" } th { "after" } }
            @for c in &d.error_reduction.channels {
                tr {
                    td { (c.label) } td { (number(c.rmse_before, 4)) } td { (number(c.rmse_after, 4)) }
                    td { (number(c.ci95[0], 4)) " to " (number(c.ci95[1], 4)) }
                    td { (number(c.r2_before, 4)) } td { (number(c.r2_after, 4)) }
                }
            }
        } }
        (groups("frequency of excitation", &d.outputs, &d.error_reduction.by_frequency))
        (groups("recording", &d.outputs, &d.error_reduction.by_recording))
        @for t in d.traces.iter().take(SHOWN) {
            h3 { (t.name) }
            @if !t.excitation.is_empty() {
                div.grid { @for (c, label) in &shown {
                    (figure(loop_of(t, *c, label, &d.excitation_label, named),
                        &format!("{label} against {}, the last seconds.", d.excitation_label)))
                } }
            }
            @if let Some((c, label)) = shown.first() {
                (figure(series(t, *c, label, named), "The last seconds, measured and predicted."))
                (figure(errors(t, *c, &format!("error of {label}"), named), "The error over the whole recording."))
            }
        }
    }
}

fn groups(name: &str, outputs: &[OutputInfo], groups: &[GroupReduction]) -> Markup {
    html! {
        @if !groups.is_empty() {
            div.scroll { table {
                tr { th { (name) } @for o in outputs { th { (o.key) " before (" (o.unit) ")" } th { "after" } } }
                @for g in groups { tr {
                    td { (g.name) }
                    @for (before, after) in g.rmse_before.iter().zip(&g.rmse_after) {
                        td { (number(*before, 4)) } td { (number(*after, 4)) }
                    }
                } }
            } }
        }
    }
}

/// Measured, before and after, each drawn by `line`.
fn curves(
    mut plot: LineFigure,
    t: &Trace,
    c: usize,
    named: bool,
    line: impl Fn(&[f64]) -> Vec<(f64, f64)>,
) -> String {
    plot = plot.with("measured", Role::Measured, line(&t.measured[c])).with(
        "before",
        Role::Category(0),
        line(&t.before[c]),
    );
    if named {
        plot = plot.with("after", Role::Predicted, line(&t.after[c]));
    }
    plot.to_svg()
}

fn last(t: &Trace) -> usize {
    let end = t.time_s.last().copied().unwrap_or(0.0);
    t.time_s.partition_point(|&s| s < end - SHOWN_S)
}

/// The loop of a channel over the excitation. The first channel is drawn to the right, as a force–displacement loop.
fn loop_of(t: &Trace, c: usize, label: &str, excitation: &str, named: bool) -> String {
    let from = last(t);
    let u = &t.excitation[from..];
    if c == 0 {
        let plot = LineFigure::new("", label, excitation, 480, 330);
        curves(plot, t, c, named, |y| thin(&y[from..], u, POINTS))
    } else {
        let plot = LineFigure::new("", excitation, label, 480, 330);
        curves(plot, t, c, named, |y| thin(u, &y[from..], POINTS))
    }
}

fn series(t: &Trace, c: usize, label: &str, named: bool) -> String {
    let from = last(t);
    let plot = LineFigure::new("", "time (s)", label, 1040, 240);
    curves(plot, t, c, named, |y| thin(&t.time_s[from..], &y[from..], POINTS))
}

fn errors(t: &Trace, c: usize, label: &str, named: bool) -> String {
    let line = |y: &[f64]| {
        let e: Vec<f64> = t.measured[c].iter().zip(y).map(|(m, p)| m - p).collect();
        envelope(&t.time_s, &e, 700)
    };
    let mut plot = LineFigure::new("", "time (s)", label, 1040, 220);
    plot = plot.with("before", Role::Category(0), line(&t.before[c]));
    if named {
        plot = plot.with("after", Role::Predicted, line(&t.after[c]));
    }
    plot.to_svg()
}
