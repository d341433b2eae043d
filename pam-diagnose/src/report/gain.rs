//! What it gains: errors before and after on what was kept aside.

use crate::diagnosis::{Diagnosis, GroupGain, Trace};
use maud::{Markup, html};
use pam_data::Channel;
use pam_report::figure::{envelope, thin};
use pam_report::page::{figure, number, wide_figure};
use pam_report::{LineFigure, Role};

/// Recordings that are shown.
const SHOWN: usize = 3;
/// Seconds of a time series that are shown.
const SHOWN_S: f64 = 12.0;

pub(super) fn section(d: &Diagnosis) -> Markup {
    let named = !d.causes.is_empty();
    html! {
        p { (d.held_out.sentence()) " Intervals by block bootstrap: blocks of two seconds, drawn frequency by frequency." }
        div.scroll { table {
            tr { th { "channel" } th { "RMSE before" } th { "after" } th { "reduction, 95 % interval" } th { "R² before" } th { "after" } }
            @for c in Channel::ALL { @let g = d.gain.channel(c);
                tr {
                    td { (c.label()) } td { (number(g.rmse_before, 4)) } td { (number(g.rmse_after, 4)) }
                    td { (number(g.ci95[0], 4)) " to " (number(g.ci95[1], 4)) }
                    td { (number(g.r2_before, 4)) } td { (number(g.r2_after, 4)) }
                }
            }
        } }
        (groups("frequency of excitation", &d.gain.by_frequency))
        (groups("recording", &d.gain.by_recording))
        @for t in d.traces.iter().take(SHOWN) {
            h3 { (t.name) }
            div.grid {
                (figure(x_loop(t, named), "x–F loop"))
                (figure(p_loop(t, named), "P–F loop of the flexor"))
            }
            (wide_figure(series(t, 0, "displacement (mm)", named), "The last seconds, measured and predicted."))
            (wide_figure(errors(t, 0, "error of x (mm)", named), "Error of the displacement over the whole recording."))
        }
    }
}

fn groups(what: &str, groups: &[GroupGain]) -> Markup {
    html! {
        @if !groups.is_empty() {
            div.scroll { table {
                tr { th { (what) } @for c in Channel::ALL { th { (c.key()) " before (" (c.unit()) ")" } th { "after" } } }
                @for g in groups { tr {
                    td { (g.name) }
                    @for c in 0..4 { td { (number(g.rmse_before[c], 4)) } td { (number(g.rmse_after[c], 4)) } }
                } }
            } }
        }
    }
}

fn last(t: &Trace) -> usize {
    let end = t.time_s.last().copied().unwrap_or(0.0);
    t.time_s.partition_point(|&s| s < end - SHOWN_S)
}

fn x_loop(t: &Trace, named: bool) -> String {
    let from = last(t);
    let f = &t.force_n[from..];
    let line = |x: &[f64]| thin(&x[from..], f, 3000);
    let mut plot = LineFigure::new("", "displacement (mm)", "force (N)", 480, 330)
        .with("measured", Role::Measured, line(&t.measured[0]))
        .with("before", Role::Category(4), line(&t.before[0]));
    if named {
        plot = plot.with("after", Role::Predicted, line(&t.after[0]));
    }
    plot.to_svg()
}

fn p_loop(t: &Trace, named: bool) -> String {
    let from = last(t);
    let f = &t.force_n[from..];
    let line = |p: &[f64]| thin(f, &p[from..], 3000);
    let mut plot = LineFigure::new("", "force (N)", "flexor pressure (kPa abs)", 480, 330)
        .with("measured", Role::Measured, line(&t.measured[2]))
        .with("before", Role::Category(4), line(&t.before[2]));
    if named {
        plot = plot.with("after", Role::Predicted, line(&t.after[2]));
    }
    plot.to_svg()
}

fn series(t: &Trace, c: usize, label: &str, named: bool) -> String {
    let from = last(t);
    let line = |y: &[f64]| thin(&t.time_s[from..], &y[from..], 3000);
    let mut plot = LineFigure::new("", "time (s)", label, 1040, 240)
        .with("measured", Role::Measured, line(&t.measured[c]))
        .with("before", Role::Category(4), line(&t.before[c]));
    if named {
        plot = plot.with("after", Role::Predicted, line(&t.after[c]));
    }
    plot.to_svg()
}

fn errors(t: &Trace, c: usize, label: &str, named: bool) -> String {
    let line = |y: &[f64]| {
        let e: Vec<f64> = t.measured[c].iter().zip(y).map(|(m, p)| m - p).collect();
        envelope(&t.time_s, &e, 700)
    };
    let mut plot = LineFigure::new("", "time (s)", label, 1040, 220).with(
        "before",
        Role::Category(4),
        line(&t.before[c]),
    );
    if named {
        plot = plot.with("after", Role::Predicted, line(&t.after[c]));
    }
    plot.to_svg()
}
