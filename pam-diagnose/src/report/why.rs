//! Why: the candidates against each other.

use crate::diagnosis::Diagnosis;
use maud::{Markup, html};
use pam_report::page::wide_figure;
use pam_report::{LineFigure, Role};

pub(super) fn section(d: &Diagnosis) -> Markup {
    html! {
        p {
            "Every candidate was fitted through the simulation, alone and beside others, with the network as \
             it is and with initial states, sealed masses and the model's own mass and coefficient free within \
             their tolerances. A flexible correction without names removes "
            (format!("{:.0} %", 100.0 * d.ceiling))
            " of the error above the noise on the recordings kept aside; the named causes remove "
            (format!("{:.0} %", 100.0 * d.removed)) "."
        }
        @if let Some(c) = &d.chance {
            p {
                "With the signs of its blocks drawn at random, the same residual lets the luckiest single candidate \
                 explain up to " (format!("{:.0} %", 100.0 * c.share_q95)) " of it (95 % of " (c.draws)
                " draws); in the recordings the best one explains " (format!("{:.0} %", 100.0 * c.largest_share))
                " to first order (p = " (format!("{:.3}", c.p_value)) ")"
                @if d.causes.is_empty() { "." } @else {
                    ", and the named causes " (format!("{:.0} %", 100.0 * d.explained)) "."
                }
            }
        }
        @for c in &d.causes {
            h3 { (c.effect) }
            p {
                (c.what) ": " (format!("{:.0} %", 100.0 * c.share_of_error_removed))
                " of the removable error goes with it. It is brought out by " (c.excited_by) ". "
                @if c.confusable_with.is_empty() {
                    "No other candidate explains nearly as much in its place."
                } @else {
                    "This experiment does not tell it well from " (c.confusable_with.join(", "))
                    ", which would explain nearly as much in its place."
                }
            }
            @if let Some(k) = &c.constancy {
                @if k.parts.len() > 2 {
                    p { "Fitted to thirds of each recording, " code { (k.parameter) } " spreads by "
                        (format!("{:.1} %", 100.0 * k.relative_spread)) " (half the distance of the quartiles)." }
                    (wide_figure(parts(k), "The value in each third of each recording; a cause that is real has one value."))
                }
            }
        }
        h3 { "All candidates alone" }
        div.scroll { table {
            tr { th { "candidate" } th { "share of the error it removes alone" } th { "fitted values" } th.text { "ends at a limit" } }
            @for r in &d.ranking {
                tr {
                    td { (r.effect) } td { (format!("{:.1} %", 100.0 * r.score)) }
                    td { (r.values.iter().map(|v| pam_effects::model::significant(*v, 4)).collect::<Vec<_>>().join(", ")) }
                    td.text { (r.at_limit.join(", ")) }
                }
            }
        } }
    }
}

fn parts(k: &crate::search::Constancy) -> String {
    let mut plot =
        LineFigure::new("", "start of the part (s)", k.parameter, 1040, 220).with_marks();
    let mut names: Vec<&str> = k.parts.iter().map(|p| p.0.as_str()).collect();
    names.dedup();
    for (i, name) in names.iter().take(9).enumerate() {
        let points = k.parts.iter().filter(|p| p.0 == *name).map(|p| (p.1, p.2)).collect();
        plot = plot.with(name, Role::Category(i), points);
    }
    plot.to_svg()
}
