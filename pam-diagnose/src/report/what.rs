//! What is wrong: the residual, where and when it lives.

use crate::diagnosis::Diagnosis;
use crate::residual::ChannelStory;
use maud::{Markup, html};
use pam_report::page::{figure, number, wide_figure};
use pam_report::{LineFigure, Role};

pub(super) fn section(d: &Diagnosis) -> Markup {
    html! {
        @for c in &d.residual.channels { p { (c.sentence()) } }
        div.scroll { table {
            tr {
                th { "channel" } th { "RMS error" } th { "noise and ordinary" } th { "ratio" }
                th { "mean" } th { "correlation 20 ms on" } th.text { "goes with (share of variance)" }
            }
            @for c in &d.residual.channels {
                tr {
                    td { (c.channel) " (" (c.unit) ")" }
                    td { (number(c.rms, 4)) } td { (number(c.floor, 4)) } td { (number(c.ratio(), 1)) }
                    td { (number(c.mean, 4)) } td { (number(c.next_correlation, 3)) }
                    td.text.wrap {
                        @for dep in c.dependence.iter().take(4) {
                            (dep.factor) " " (format!("{:.0} %", 100.0 * dep.share)) "; "
                        }
                    }
                }
            }
        } }
        @if let Some(c) = worst(d) {
            div.grid {
                @for dep in c.dependence.iter().filter(|g| g.groups.len() > 2).take(4) {
                    (figure(
                        LineFigure::new("", &axis(dep.factor).0, &format!("mean residual {} ({})", c.channel, c.unit), 480, 270)
                            .with_marks()
                            .with("", Role::Residual, dep.groups.iter().map(|g| (g[0] * axis(dep.factor).1, g[1])).collect())
                            .to_svg(),
                        &format!("Residual of {} against {}: {:.0} % of its variance.", c.channel, dep.factor, 100.0 * dep.share),
                    ))
                }
            }
            (wide_figure(spectrum(c), "Power of the residual and of the force; a line that the force does not have is driven by something else."))
            (wide_figure(profile(c), "Error over time, in blocks of a second."))
        }
    }
}

/// The channel that is furthest above its floor.
fn worst(d: &Diagnosis) -> Option<&ChannelStory> {
    d.residual.channels.iter().max_by(|a, b| a.ratio().total_cmp(&b.ratio()))
}

/// Label of a factor's axis with its unit, and what its values are multiplied by for that unit.
fn axis(factor: &str) -> (String, f64) {
    let (unit, scale) = match factor {
        "position" | "amplitude of the motion" => ("mm", 1.0),
        "velocity" => ("mm/s", 1.0),
        "force" => ("N", 1e-3),
        "phase in the cycle" => ("rad", 1.0),
        "time since sealing" => ("s", 1.0),
        _ => ("–", 1.0),
    };
    (format!("{factor} ({unit})"), scale)
}

fn spectrum(c: &ChannelStory) -> String {
    let line = |power: &[f64]| {
        c.spectrum.frequency_hz.iter().copied().zip(power.iter().copied()).collect::<Vec<_>>()
    };
    LineFigure::new("", "frequency (Hz)", "share of power", 1040, 240)
        .with("residual", Role::Residual, line(&c.spectrum.residual))
        .with("force", Role::Neutral, line(&c.spectrum.force))
        .to_svg()
}

fn profile(c: &ChannelStory) -> String {
    let label = format!("RMS of {} ({})", c.channel, c.unit);
    let mut plot = LineFigure::new("", "time (s)", &label, 1040, 240);
    for (k, (name, p)) in c.profiles.iter().take(8).enumerate() {
        let points = p.time_s.iter().copied().zip(p.rms.iter().copied()).collect();
        plot = plot.with(name, Role::Category(k), points);
        if let Some(jump) = p.jump {
            plot = plot.with_vertical(jump.time_s, Role::Category(k));
        }
    }
    plot.to_svg()
}
