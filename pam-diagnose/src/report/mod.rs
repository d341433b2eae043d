//! The report of a diagnosis: what is wrong, why, what changes, what it gains.

mod gain;
mod what;
mod why;

use crate::diagnosis::{Diagnosis, Verdict};
use maud::{Markup, html};
use pam_report::page::{card, number, page};

/// What stands around the diagnosis.
#[derive(Debug, Clone, Default)]
pub struct ReportContext {
    /// Name of the model.
    pub model: String,
    /// One line on the model.
    pub model_line: String,
    /// Program and version.
    pub made_by: String,
}

/// The report as HTML text that needs nothing else.
#[must_use]
pub fn diagnosis_report(d: &Diagnosis, context: &ReportContext) -> String {
    let body = html! {
        (summary(d))
        h2 { "1. What is wrong" }
        (what::section(d))
        h2 { "2. Why" }
        (why::section(d))
        h2 { "3. What changes" }
        (changes(d))
        h2 { "4. What it gains" }
        (gain::section(d))
    };
    let title = match d.verdict {
        Verdict::NothingFound => "Diagnosis: nothing found".to_owned(),
        Verdict::Unexplained => "Diagnosis: an error that no listed cause explains".to_owned(),
        Verdict::Explained | Verdict::PartlyExplained => {
            format!("Diagnosis: {}", d.named().join(", "))
        }
    };
    page(
        &title,
        &format!("Model {}. {}", context.model, context.model_line),
        &body,
        &context.made_by,
    )
}

/// The outcome in one paragraph.
#[must_use]
pub fn verdict_sentence(d: &Diagnosis) -> String {
    let percent = |v: f64| format!("{:.0} %", 100.0 * v);
    let causes: Vec<String> = d
        .causes
        .iter()
        .map(|c| {
            let values: Vec<String> = c
                .parameters
                .iter()
                .map(|(name, i)| {
                    let n = |v| pam_effects::model::significant(v, 3);
                    format!("{name} = {} [{}, {}]", n(i.value), n(i.ci95[0]), n(i.ci95[1]))
                })
                .collect();
            format!("{} ({})", c.effect, values.join(", "))
        })
        .collect();
    match d.verdict {
        Verdict::NothingFound => {
            "The model predicts these recordings as well as noise and what is \
            ordinary for it allow; nothing is wrong that these data could show."
                .into()
        }
        Verdict::Unexplained => format!(
            "There is an error, and no listed cause explains it: the best candidate alone, {}, removes {} \
             of what could be removed. A flexible correction without names removes {}.",
            d.ranking.first().map_or("none", |r| r.effect),
            percent(d.ranking.first().map_or(0.0, |r| r.score)),
            percent(d.ceiling)
        ),
        Verdict::Explained => format!(
            "{}: removes {} of the squared error above the noise on recordings that took no part in \
             naming (a flexible correction without names: {}).",
            causes.join(" and "),
            percent(d.removed),
            percent(d.ceiling)
        ),
        Verdict::PartlyExplained => format!(
            "{}: removes {} of the squared error above the noise on recordings that took no part in \
             naming; the rest has no listed cause (a flexible correction without names removes {}).",
            causes.join(" and "),
            percent(d.removed),
            percent(d.ceiling)
        ),
    }
}

fn summary(d: &Diagnosis) -> Markup {
    let g = &d.gain;
    html! {
        div.note { (verdict_sentence(d)) }
        div.cards {
            (card(&d.verdict.to_string(), "verdict"))
            (card(&format!("{} → {} mm", number(g.x.rmse_before, 4), number(g.x.rmse_after, 4)), "displacement RMSE, kept aside"))
            (card(&format!("{:.0} %", 100.0 * g.overall.error_reduction),
                &format!("less error [{:.0}, {:.0}] %", 100.0 * g.overall.ci95[0], 100.0 * g.overall.ci95[1])))
        }
        p { "Fitted: " (d.fitted.join(", ")) ". " (d.judged_by.sentence()) " " (d.held_out.sentence()) }
        p {
            "The force acts " (number(d.force_lead_samples, 2)) " samples earlier than if each value held until the \
             next (0 held, ½ smooth)."
            @if d.force_lead_samples > 0.25 {
                " It is better read with " code { "--input linear" } " in commands that predict."
            }
        }
        @if let Some(o) = &d.ordinary {
            p {
                "Ordinary for this model, from healthy recordings (" (o.recordings.join(", ")) "): RMS "
                (number(o.rms[0], 4)) " mm, " (number(o.rms[1], 3)) " and " (number(o.rms[2], 3)) " kPa"
                @if !o.effects.is_empty() {
                    " beside " (o.effects.iter().map(|e| e.effect.info().id).collect::<Vec<_>>().join(", "))
                }
                ". That much counts as no fault."
            }
        }
    }
}

fn changes(d: &Diagnosis) -> Markup {
    if d.causes.is_empty() {
        return html! { p { "Nothing: the model stays as it is." } };
    }
    html! {
        p { "The model is extended by these terms; the network stays as it is. "
            code { "model.safetensors" } " holds the result and works in every command that predicts." }
        div.scroll { table {
            tr { th { "effect" } th { "parameter" } th { "value" } th { "95 % interval" } th.text { "what it is" } }
            @for c in &d.causes { @for (k, (name, i)) in c.parameters.iter().enumerate() {
                tr {
                    td { @if k == 0 { (c.effect) } }
                    td { (name) }
                    td { (pam_effects::model::significant(i.value, 4)) }
                    td { (pam_effects::model::significant(i.ci95[0], 4)) " to " (pam_effects::model::significant(i.ci95[1], 4)) }
                    td.text { @if k == 0 { (c.what) } }
                }
            } }
        } }
    }
}
