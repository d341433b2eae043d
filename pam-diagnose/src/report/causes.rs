//! The named causes, and the ranking of the candidates.

use super::headline::{capitalised, joined_by, quantity};
use super::percent;
use crate::diagnosis::Diagnosis;
use maud::{Markup, html};
use pam_report::page::figure;
use pam_report::{LineFigure, Role};
use pam_vocabulary::course::RAMP;
use pam_vocabulary::plain_name;

pub(super) fn section<M>(d: &Diagnosis<M>) -> Markup {
    html! {
        p {
            "Candidates were fitted through the simulation, alone and together with others, with the uncertain values \
             of model and recordings free within their priors. A flexible model without names removes "
            (percent(d.explainable.any_correction)) " of the error above the noise on the test set; the named causes \
             remove " (percent(d.explainable.named)) "."
        }
        @if let Some(n) = &d.null_test {
            p {
                "Max-statistic null test: with the signs of its blocks drawn at random, the same residual lets the best \
                 single candidate explain up to " (percent(n.share_q95)) " of it (95 % of " (n.draws)
                " draws); in the recordings the best one explains " (percent(n.largest_share))
                " to first order (p = " (format!("{:.3}", n.p_value)) ")"
                @if d.causes.is_empty() { "." } @else {
                    ", and the named causes " (percent(n.named_share)) "."
                }
            }
        }
        @for c in &d.causes {
            h3 { (capitalised(&plain_name(&c.effect))) }
            @if let Some(acts) = &c.acts {
                p { (capitalised(&acts.sentence(&plain_name(&c.effect)))) "." }
            }
            p {
                @if !c.description.is_empty() { (capitalised(&c.description)) " (id " code { (c.effect) } "). " }
                @else { "Its id is " code { (c.effect) } ". " }
                (percent(c.share_of_error_removed)) " of the removable error is removed by this cause alone: no other named cause replaces it. "
                @if !c.excited_by.is_empty() { "It is excited by " (c.excited_by) ". " }
                @if c.confusable_with.is_empty() {
                    "No other candidate explains nearly as much in its place."
                } @else {
                    "These recordings do not distinguish it well from "
                    (joined_by(&c.confusable_with.iter().map(|id| plain_name(id)).collect::<Vec<_>>(), "or"))
                    ", which would explain nearly as much in its place."
                }
            }
            @if let Some(k) = &c.stability {
                @if k.parts.len() > 2 {
                    p { "Fitted to parts of each recording, its " (quantity(k.parameter).0) " spreads by "
                        (format!("{:.1} %", 100.0 * k.relative_spread)) " (half the interquartile range)." }
                    (figure(parts(k), "The value in each part of each recording. A real cause has the same value in all of them."))
                }
            }
        }
        @if let Some(t) = &d.onset_test {
            p {
                "Beginnings and ends: with the signs of its blocks drawn at random, the same residual lets the best of "
                (t.tried) " explain up to " (share_text(t.share_by_chance)) " of it beyond the same candidate at all times ("
                (t.draws) " draws); in the recordings the best one explains " (share_text(t.largest_share)) " (p = "
                (format!("{:.3}", t.p_value)) ")."
            }
        }
        @if d.onset_curves.iter().any(|c| !c.1.is_empty()) {
            (figure(onset(d), "What a beginning or end at each time would explain, to first order. The fitted time is marked."))
        }
        h3 { "All candidates alone" }
        div.scroll { table {
            tr { th { "candidate" } th { "share of the error it removes alone" } th { "fitted values" } th.text { "ends at a limit" } }
            @for r in &d.ranking {
                tr {
                    td { (plain_name(&r.effect)) " " code { (r.effect) } } td { (format!("{:.1} %", 100.0 * r.score)) }
                    td { (r.values.iter().map(|v| pam_core::units::significant(*v, 4)).collect::<Vec<_>>().join(", ")) }
                    td.text { (r.at_limit.join(", ")) }
                }
            }
        } }
    }
}

/// A share in per cent, with a digit where it is small.
fn share_text(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

/// The drop of the squared residual over the time of a beginning or an end.
fn onset<M>(d: &Diagnosis<M>) -> String {
    let mut plot =
        LineFigure::new("", "time (s)", "drop of the weighted squared residual", 1040, 220);
    for (i, (name, curve)) in d.onset_curves.iter().take(9).enumerate() {
        plot = plot.with(name, Role::Category(i), curve.clone());
        let recordings =
            d.causes.iter().filter_map(|c| c.acts.as_ref()).flat_map(|a| &a.recordings);
        for time in recordings.filter(|r| r.recording == *name).flat_map(|r| &r.times) {
            if *time.0 != RAMP.name {
                plot = plot.with_vertical(time.1.value, Role::Category(i));
            }
        }
    }
    plot.to_svg()
}

/// A value in the parts of each recording.
pub(super) fn parts(k: &crate::rejection::ParameterStability) -> String {
    let (name, unit) = quantity(k.parameter);
    let label = if unit.is_empty() { name } else { format!("{name} ({unit})") };
    let mut plot = LineFigure::new("", "start of the part (s)", &label, 1040, 220)
        .with_marks()
        .covering([0.0]);
    let mut names: Vec<&str> = k.parts.iter().map(|p| p.0.as_str()).collect();
    names.dedup();
    for (i, name) in names.iter().take(9).enumerate() {
        let points = k.parts.iter().filter(|p| p.0 == *name).map(|p| (p.1, p.2)).collect();
        plot = plot.with(name, Role::Category(i), points);
    }
    plot.to_svg()
}
