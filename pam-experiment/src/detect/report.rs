//! Limits and confusions as a page.

use super::result::{Detection, Limit, Limits, Pair};
use super::trials::TriedLimit;
use maud::{Markup, html};
use pam_core::units::significant;
use pam_report::figure::HeatTable;
use pam_report::page::{card, count, page};
use pam_vocabulary::plain_name;

/// Cosines from which a pair is listed as confusable.
const NEAR: f64 = 0.95;

/// The result of [`detect`](super::detect()) as a page; `model_line` describes the model.
#[must_use]
pub fn detection_report(d: &Detection, model_line: &str, made_by: &str) -> String {
    let length: f64 = d.recordings.iter().map(|r| r.1).sum();
    let found = d.limits.iter().filter(|l| l.named.is_some()).count();
    let confused = d.confused(2.0).len();
    let tried = d.limits.iter().any(|l| l.tried.is_some());
    let body = html! {
        div.cards {
            (card(&format!("{found} of {}", d.limits.len()), "effects with a limit inside their range"))
            (card(&format!("{length:.0} s"), &count(d.recordings.len(), "recording")))
            (card(&confused.to_string(), "pairs not distinguished at twice the limit"))
        }
        h2 { "Detection limits" }
        p {
            "The smallest magnitude that is found with " (format!("{:.0}", 100.0 * d.power)) " % power. "
            "Named: a diagnosis names the effect as a cause"
            @if tried { ", by diagnoses of simulated recordings (95 % interval; how many of the trials named it)" }
            ". Foretold: what its rules require. Listed: it lists the effect, perhaps as a minor cause. Any test: "
            "no test with " (format!("{:.0}", 100.0 * d.level)) " % false alarms over all candidates sees less."
        }
        (table(d))
        h2 { "Confusions" }
        p {
            "The cosine between the whitened signature of an effect (row) and the span of another one (column), after the "
            "nuisances are projected out. At 1 no magnitude distinguishes them. Pairs above " (NEAR) " are listed below"
            @if tried { ", and those that trials at the limit did not distinguish" } "."
        }
        (heat_table(d))
        (near(d))
    };
    page("Detection limits", model_line, &body, made_by)
}

fn cell(limit: Option<Limit>) -> String {
    limit.map_or_else(|| "–".to_owned(), |l| significant(l.value, 3))
}

fn interval(l: &Limits) -> String {
    let of = |[low, high]: [f64; 2]| format!("{}–{}", significant(low, 2), significant(high, 2));
    l.tried.as_ref().map_or_else(String::new, |t| of(t.interval))
}

fn trials(l: &Limits) -> String {
    let of = |t: &TriedLimit| {
        format!("{} of {}", t.trials.iter().filter(|t| t.named).count(), t.trials.len())
    };
    l.tried.as_ref().map_or_else(String::new, of)
}

fn table(d: &Detection) -> Markup {
    let tried = d.limits.iter().any(|l| l.tried.is_some());
    html! {
        table {
            thead { tr { th { "effect" } th { "parameter" } th { "named from" } @if tried { th { "interval" } th { "trials" } } th { "foretold" } th { "listed from" } th { "any test" } th { "kept" } } }
            tbody {
                @for l in &d.limits {
                    tr {
                        td { (plain_name(&l.effect)) @if l.label != l.effect { " " (l.label[l.effect.len()..]) } }
                        td { code { (l.parameter) } }
                        td { (cell(l.named)) }
                        @if tried {
                            td { (interval(l)) } td { (trials(l)) }
                        }
                        td { (cell(l.foretold)) } td { (cell(l.listed)) } td { (cell(l.familywise)) }
                        td { (l.kept.iter().map(|(n, v)| format!("{n} = {}", significant(*v, 3))).collect::<Vec<_>>().join(", ")) }
                    }
                }
            }
        }
    }
}

/// Ids of the columns.
fn columns(d: &Detection) -> Vec<&str> {
    let mut all: Vec<&str> = Vec::new();
    for l in &d.limits {
        if !all.contains(&l.effect.as_str()) {
            all.push(&l.effect);
        }
    }
    all
}

fn heat_table(d: &Detection) -> Markup {
    let columns = columns(d);
    let cosine = |effect: &str, other: &str| {
        d.pairs.iter().find(|p| p.effect == effect && p.other == other).map(|p| p.cosine)
    };
    let row = |l: &Limits| columns.iter().map(|other| cosine(&l.label, other)).collect();
    HeatTable {
        corner: "effect at work".into(),
        rows: d.limits.iter().map(|l| l.label.clone()).collect(),
        values: d.limits.iter().map(row).collect(),
        columns: columns.iter().map(|c| (*c).to_owned()).collect(),
        limits: (0.0, 1.0),
    }
    .to_html()
}

/// Trials in which a pair was not distinguished.
fn seen(p: &Pair) -> usize {
    p.tried.map_or(0, |t| t[0])
}

fn near(d: &Detection) -> Markup {
    let mut pairs: Vec<_> = d.pairs.iter().filter(|p| p.cosine > NEAR || seen(p) > 0).collect();
    let tried = d.limits.iter().any(|l| l.tried.is_some());
    pairs.sort_by(|a, b| b.cosine.total_cmp(&a.cosine));
    html! {
        @if pairs.is_empty() { p { "No pair is that near." } } @else {
            table {
                thead { tr { th { "effect at work" } th { "taken for" } th { "cosine" } th { "distinguished from (limits)" } @if tried { th { "not distinguished in" } } } }
                tbody {
                    @for p in pairs {
                        tr {
                            td { (p.effect) } td { (p.other) } td { (format!("{:.4}", p.cosine)) }
                            td { (p.distinguished_from.map_or_else(|| "never".to_owned(), |m| format!("{m:.1}"))) }
                            @if tried { td { (p.tried.map_or_else(String::new, |[k, n]| format!("{k} of {n} trials"))) } }
                        }
                    }
                }
            }
        }
    }
}
