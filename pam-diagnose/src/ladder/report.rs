//! A ladder on a page.

use super::table::{Ladder, Rung};
use maud::{Markup, html};
use pam_core::units::significant;
use pam_report::page::number;

/// The table of a ladder.
pub(crate) fn section(ladder: &Ladder) -> Markup {
    let outputs: Vec<(&str, &str)> = ladder
        .rungs
        .first()
        .map(|r| r.test.iter().map(|e| (e.channel.as_str(), e.unit.as_str())).collect())
        .unwrap_or_default();
    html! {
        p { (ladder.sentence()) }
        div.scroll { table {
            tr {
                th { "model" } th { "bits more than the shortest" } th { "χ², open rows" } th { "χ², test set" }
                @for (channel, unit) in &outputs { th { "RMSE " (channel) " (" (unit) "), test set" } }
                th.text { "parameters with 95 % intervals" }
            }
            @for (k, r) in ladder.rungs.iter().enumerate() { tr {
                td { @if k == ladder.shortest { strong { code { (r.id) } } } @else { code { (r.id) } } " " (r.description) }
                td { (number(r.description_length_bits, 1)) }
                td { (number(r.chi_square, 3)) }
                td { @if let Some(chi) = r.test_chi_square { (number(chi, 3)) } @else { "–" } }
                @for e in &r.test { td { (number(e.rmse, 4)) } }
                td.text.wrap { (parameters(r)) }
            } }
        } }
    }
}

fn parameters(rung: &Rung) -> String {
    let one = |(name, i): &(&'static str, crate::fit::Interval)| {
        let n = |v: f64| significant(v, 3);
        let limit = if rung.at_limit.contains(name) { ", at a limit" } else { "" };
        format!("{name} {} [{}, {}]{limit}", n(i.value), n(i.ci95[0]), n(i.ci95[1]))
    };
    rung.parameters.iter().map(one).collect::<Vec<_>>().join("; ")
}
