//! The residual: size, dependence, spectrum, time profile.

use crate::diagnosis::Diagnosis;
use crate::residual::ChannelResidual;
use maud::{Markup, html};
use pam_report::page::{figure, number};
use pam_report::{LineFigure, Role};

/// Share of the variance, beyond that of chance, from which a factor is listed.
const NOTABLE: f64 = 0.005;

pub(super) fn section<M>(d: &Diagnosis<M>) -> Markup {
    html! {
        @for c in &d.residual.channels { p { (c.description) } }
        div.scroll { table {
            tr {
                th { "channel" } th { "RMS error" } th { "noise and baseline" } th { "ratio" }
                th { "mean" } th { "correlation of neighbours" } th.text { "depends on (share of variance)" }
            }
            @for c in &d.residual.channels {
                tr {
                    td { (c.key) " (" (c.unit) ")" }
                    td { (number(c.rms, 4)) } td { (number(c.noise, 4)) } td { (number(c.ratio(), 1)) }
                    td { (number(c.mean, 4)) } td { (number(c.next_correlation, 3)) }
                    td.text.wrap {
                        @let factors: Vec<String> = c.dependence.iter().filter(|dep| dep.share >= NOTABLE).take(4)
                            .map(|dep| format!("{} {:.0} %", dep.factor, 100.0 * dep.share)).collect();
                        @if factors.is_empty() { "no factor significantly" } @else { (factors.join("; ")) }
                    }
                }
            }
        } }
        @if let Some(c) = worst(d) {
            div.grid {
                @for dep in c.dependence.iter().filter(|g| g.groups.len() > 2).take(4) {
                    (figure(
                        LineFigure::new("", &format!("{} ({})", dep.factor, dep.unit), &format!("mean residual {} ({})", c.key, c.unit), 480, 270)
                            .with_marks()
                            .with("", Role::Residual, dep.groups.iter().map(|g| (g[0], g[1])).collect())
                            .to_svg(),
                        &if dep.share >= NOTABLE {
                            format!("Residual of {} against {}, which explains {:.0} % of its variance.", c.key, dep.factor, 100.0 * dep.share)
                        } else {
                            format!("Residual of {} against {}; no more than a correlated residual shows by chance.", c.key, dep.factor)
                        },
                    ))
                }
            }
            (figure(spectrum(c), "Power of the residual and of the excitation; a line that the excitation does not have is driven by something else."))
            (figure(profile(c), "Error over time, in blocks of a second."))
        }
    }
}

/// The channel that is furthest above its noise.
fn worst<M>(d: &Diagnosis<M>) -> Option<&ChannelResidual> {
    d.residual.channels.iter().max_by(|a, b| a.ratio().total_cmp(&b.ratio()))
}

fn spectrum(c: &ChannelResidual) -> String {
    let line = |power: &[f64]| {
        c.spectrum.frequency_hz.iter().copied().zip(power.iter().copied()).collect::<Vec<_>>()
    };
    LineFigure::new("", "frequency (Hz)", "share of power", 1040, 240)
        .with("residual", Role::Residual, line(&c.spectrum.residual))
        .with("excitation", Role::Neutral, line(&c.spectrum.excitation))
        .to_svg()
}

fn profile(c: &ChannelResidual) -> String {
    let label = format!("RMS of {} ({})", c.key, c.unit);
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
