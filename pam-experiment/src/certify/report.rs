//! The certificate as a page.

use super::summary::{Coverage, Summary};
use maud::{Markup, html};
use pam_report::page::{card, page};

/// A share with its exact limits, in per cent.
fn share(count: u64, all: u64, [low, high]: [f64; 2]) -> String {
    if all == 0 {
        return "–".into();
    }
    let value = 100.0 * count as f64 / all as f64;
    format!("{value:.0} % [{:.0}, {:.0}]", 100.0 * low, 100.0 * high)
}

/// The summary as a page; `model_line` describes the model.
#[must_use]
pub fn certificate_report(s: &Summary, model_line: &str, made_by: &str) -> String {
    let c = &s.certificate;
    let (before, nulls, limits) = s.false_alarms;
    let right: u64 = c.trust.iter().map(|t| t.right).sum();
    let trials: u64 = c.trust.iter().map(|t| t.trials).sum();
    let body = html! {
        div.cards {
            (card(&share(c.false_alarms, c.nulls, c.false_alarm_limits), "false alarms with the certified settings"))
            (card(&share(right, trials, super::clopper_pearson(right, trials, 0.95)), "of the names right"))
            (card(&share(s.coverage_of_all.covered, s.coverage_of_all.trials, s.coverage_of_all.limits), "of the 95 % intervals hold the truth"))
        }
        p {
            (s.cases[0]) " of " (s.cases[1]) " cases are over, " (s.refused) " of them without a diagnosis. With the settings of the "
            "cases something was named in " (before) " of " (nulls) " null sets (" (share(before, nulls, limits)) "). With the certified "
            "settings the odds of a cause must reach " (format!("{:.0}", s.log_odds.exp())) "."
            @if nulls < s.nulls_needed {
                " The exact limit of the level needs at least " (s.nulls_needed) " null sets without an alarm; with fewer the settings hold "
                "it by the share alone."
            }
        }
        p {
            "Verdicts of the null sets: "
            (s.null_verdicts.iter().map(|(v, n)| format!("{} {n}", v.replace('_', " "))).collect::<Vec<_>>().join(", ")) "."
        }
        @if !s.left_out.is_empty() { p { "Not seen within their range: " (s.left_out.join(", ")) "." } }
        h2 { "Trust in names" }
        table {
            thead { tr { th { "odds from (logarithm)" } th { "trials" } th { "right" } } }
            tbody { @for t in &c.trust { tr { td { (format!("{:.1}", t.log_odds)) } td { (t.trials) } td { (share(t.right, t.trials, t.limits)) } } } }
        }
        h2 { "Detection" }
        p { "Right: the effect is named, alone or as one that the diagnosis does not distinguish from the name. Exact: it is the only name." }
        table {
            thead { tr { th { "effect" } th { "multiple of the limit" } th { "trials" } th { "right" } th { "exact" } } }
            tbody {
                @for d in &s.detected {
                    tr { td { (d.label) } td { (d.multiple) } td { (d.trials) } td { (share(d.right, d.trials, d.limits)) } td { (d.exact) } }
                }
            }
        }
        h2 { "Confusions" }
        (confusions(s))
        h2 { "Coverage of 95 % intervals" }
        (coverage(&s.coverage))
    };
    page("Certificate of the diagnosis", model_line, &body, made_by)
}

fn confusions(s: &Summary) -> Markup {
    let mut rows: Vec<&str> = Vec::new();
    for c in &s.confusions {
        if !rows.contains(&c.hidden.as_str()) {
            rows.push(&c.hidden);
        }
    }
    let cell = |hidden: &str| {
        let own = s.confusions.iter().filter(|c| c.hidden == hidden);
        own.map(|c| format!("{} × {}", c.trials, c.named)).collect::<Vec<_>>().join(", ")
    };
    html! {
        table {
            thead { tr { th { "hidden" } th { "named" } } }
            tbody { @for row in rows { tr { td { (row) } td { (cell(row)) } } } }
        }
    }
}

fn coverage(all: &[Coverage]) -> Markup {
    html! {
        table {
            thead { tr { th { "parameter" } th { "intervals" } th { "hold the truth" } } }
            tbody { @for c in all { tr { td { code { (c.parameter) } } td { (c.trials) } td { (share(c.covered, c.trials, c.limits)) } } } }
        }
    }
}
