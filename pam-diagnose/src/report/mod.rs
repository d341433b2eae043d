//! The report of a diagnosis: residual, causes, changes, error reduction.

mod causes;
mod error_reduction;
mod residual;

use crate::diagnosis::Diagnosis;
use crate::verdict::Verdict;
use maud::{Markup, html};
use pam_core::units::significant;
use pam_report::page::{card, number, page};

/// Model and program, as the report names them.
#[derive(Debug, Clone, Default)]
pub struct ReportContext {
    /// Name of the model.
    pub model: String,
    /// One line on the model.
    pub model_line: String,
    /// Program and version.
    pub made_by: String,
}

/// The part of a report that only the system knows.
pub trait ReportModel {
    /// Paragraphs below the summary.
    fn notes(&self) -> Markup;
    /// How the causes become part of the model.
    fn extension(&self) -> Markup;
}

/// The report as HTML text that needs no other file.
#[must_use]
pub fn diagnosis_report<M: ReportModel>(d: &Diagnosis<M>, context: &ReportContext) -> String {
    let body = html! {
        (summary(d))
        h2 { "1. What is wrong" }
        (residual::section(d))
        h2 { "2. Why" }
        (causes::section(d))
        h2 { "3. What changes" }
        (changes(d))
        h2 { "4. What it gains" }
        (error_reduction::section(d))
    };
    let title = match d.verdict {
        Verdict::NothingFound => "Diagnosis: nothing found".to_owned(),
        Verdict::Unexplained => "Diagnosis: an error that no listed cause explains".to_owned(),
        Verdict::Unconfirmed => "Diagnosis: a cause that the test data do not confirm".to_owned(),
        Verdict::ModelInadequate => "Diagnosis: the model is too inaccurate to tell".to_owned(),
        Verdict::Explained | Verdict::PartlyExplained => {
            format!("Diagnosis: {}", d.named().join(", "))
        }
    };
    let line = format!("Model {}. {}", context.model, context.model_line);
    page(&title, &line, &body, &context.made_by)
}

/// A share in per cent.
fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

/// The outcome in one paragraph.
#[must_use]
pub fn verdict_sentence<M>(d: &Diagnosis<M>) -> String {
    let causes: Vec<String> = d
        .causes
        .iter()
        .map(|c| {
            let values: Vec<String> = c
                .parameters
                .iter()
                .map(|(name, i)| {
                    let n = |v| significant(v, 3);
                    format!("{name} = {} [{}, {}]", n(i.value), n(i.ci95[0]), n(i.ci95[1]))
                })
                .collect();
            format!("{} ({})", c.effect, values.join(", "))
        })
        .collect();
    let (named, any) = (percent(d.explainable.named), percent(d.explainable.any_correction));
    let removes = format!(
        "{}: removes {named} of the squared error above the noise on the test set",
        causes.join(" and ")
    );
    let because = if d.reasons.is_empty() {
        String::new()
    } else {
        format!(" In detail: {}.", d.reasons.join("; "))
    };
    match d.verdict {
        Verdict::NothingFound => {
            "The model predicts these recordings as well as noise and its baseline discrepancy allow; \
             these data show no fault."
                .into()
        }
        Verdict::Unexplained => format!(
            "There is an error, and no listed cause explains it: the best candidate alone, {}, removes {} \
             of the squared error. A flexible correction without names removes {any} of what is above the noise.{because}",
            d.ranking.first().map_or("none", |r| &r.effect),
            percent(d.ranking.first().map_or(0.0, |r| r.score)),
        ),
        Verdict::Unconfirmed => format!(
            "Something seems to be at work, most likely {}, but the test data do not confirm it. Record more data.{because}",
            d.refused.first().map_or("none of the candidates", |r| &r.effect),
        ),
        Verdict::ModelInadequate => format!(
            "The model's own errors on the baseline recordings are as large as the errors in these data, so a fault cannot be \
             told from them. Train the model further, or record where it is accurate.{because}"
        ),
        Verdict::Explained => {
            format!("{removes} (a flexible correction without names: {any}). What is left is noise.")
        }
        Verdict::PartlyExplained => format!(
            "{removes} (a flexible correction without names: {any}), but it is not all.{because}"
        ),
    }
}

fn summary<M: ReportModel>(d: &Diagnosis<M>) -> Markup {
    let overall = &d.error_reduction.overall;
    html! {
        div.note { (verdict_sentence(d)) }
        div.cards {
            (card(&d.verdict.to_string(), "verdict"))
            @if let (Some(c), Some(o)) = (d.error_reduction.channels.first(), d.outputs.first()) {
                (card(&format!("{} → {} {}", number(c.rmse_before, 4), number(c.rmse_after, 4), o.unit),
                    &format!("{} RMSE, test set", o.name)))
            }
            (card(&percent(overall.error_reduction),
                &format!("less error [{:.0}, {:.0}] %", 100.0 * overall.ci95[0], 100.0 * overall.ci95[1])))
        }
        p { "Fitted: " (d.fitted.join(", ")) ". " (d.validation.sentence()) " " (d.test.sentence()) }
        (d.model.notes())
    }
}

fn changes<M: ReportModel>(d: &Diagnosis<M>) -> Markup {
    if d.causes.is_empty() {
        return html! { p { "Nothing: the model stays as it is." } };
    }
    let n = |v: f64| significant(v, 4);
    html! {
        p { (d.model.extension()) }
        div.scroll { table {
            tr { th { "cause" } th { "parameter" } th { "value" } th { "95 % interval" } th.text { "meaning" } }
            @for c in &d.causes { @for (k, (name, i)) in c.parameters.iter().enumerate() {
                tr {
                    td { @if k == 0 { (c.effect) } }
                    td { (name) }
                    td { (n(i.value)) }
                    td { (n(i.ci95[0])) " to " (n(i.ci95[1])) }
                    td.text { @if k == 0 { (c.description) } }
                }
            } }
        } }
    }
}
