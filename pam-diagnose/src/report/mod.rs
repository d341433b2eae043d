//! The report of a diagnosis: residual, causes, changes, error reduction.

mod causes;
mod error_reduction;
mod headline;
mod location;
mod remainder;
mod residual;

use crate::diagnosis::Diagnosis;
use crate::law::Law;
use crate::remainder::Remainder;
use crate::verdict::Verdict;
use headline::Headline;
use maud::{Markup, html};
use pam_core::units::significant;
use pam_report::page::{card, number, page};
pub use pam_vocabulary::plain_name;

/// Model and program, as the report names them.
#[derive(Debug, Clone, Default)]
pub struct ReportContext {
    /// Name of the model.
    pub model: String,
    /// One line on the model.
    pub model_line: String,
    /// Program and version.
    pub made_by: String,
    /// Further sections with their headings, behind the summary.
    pub sections: Vec<(String, Markup)>,
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
        @for (heading, section) in &context.sections { h2 { (heading) } (section) }
        h2 { "1. What is wrong" }
        (residual::section(d))
        h2 { "2. Why" }
        (causes::section(d))
        @if let Some(ladder) = &d.ladder {
            h3 { (format!("The ladder {}", ladder.name)) }
            (crate::ladder::section(ladder))
        }
        @if let Some(r) = &d.remainder {
            h2 { "What no listed cause explains" }
            (remainder::section(r))
        }
        h2 { "3. What changes" }
        (changes(d))
        h2 { "4. What it gains" }
        (error_reduction::section(d))
    };
    let title = match d.verdict {
        _ if learned(d).is_some() => {
            let (subjects, is_one) = subjects(d);
            match Headline::of(d) {
                Some(h) => format!("{subjects} {}", changed(&h, is_one)),
                None => format!("Diagnosis: {subjects}"),
            }
        }
        Verdict::NothingFound => "Diagnosis: no fault found".to_owned(),
        Verdict::Unexplained if d.late_fault.is_some() => {
            "Diagnosis: an error begins in the test data".to_owned()
        }
        Verdict::Unexplained => "Diagnosis: no listed cause explains the error".to_owned(),
        Verdict::Unconfirmed => "Diagnosis: the test data confirm no cause".to_owned(),
        Verdict::ModelInadequate => {
            "Diagnosis: the model is too inaccurate for a diagnosis".to_owned()
        }
        Verdict::Explained | Verdict::PartlyExplained => {
            let leading = headline::leading(d).0;
            let names = headline::capitalised(&headline::names(&leading));
            match Headline::of(d) {
                _ if d.untested_change.is_some() => format!("{names}, not tested by the test data"),
                Some(h) => format!("{names} {}", changed(&h, leading.len() == 1)),
                None => format!("Diagnosis: {names}"),
            }
        }
    };
    let line = format!("Model {}. {}", context.model, context.model_line);
    page(&title, &line, &body, &context.made_by)
}

/// What was learned and became part of the model.
fn learned<M>(d: &Diagnosis<M>) -> Option<&Remainder> {
    d.remainder.as_ref().filter(|r| r.is_part_of_model())
}

/// "reduces the error of the displacement by 60 %".
fn changed(h: &Headline, is_one: bool) -> String {
    let (verb, share) = h.change(is_one);
    format!("{verb} the error of the {} by {}", h.output, percent(share))
}

/// The named causes and the learned law or correction as the subject of a sentence, and whether the subject is singular.
fn subjects<M>(d: &Diagnosis<M>) -> (String, bool) {
    let leading = if d.causes.is_empty() { Vec::new() } else { headline::leading(d).0 };
    let mut all: Vec<String> = leading.iter().map(|c| plain_name(&c.effect)).collect();
    all.extend(
        learned(d).map(|r| {
            r.law.as_ref().map_or_else(|| "a learned correction".to_owned(), Law::subject)
        }),
    );
    (headline::capitalised(&headline::joined_by(&all, "and")), all.len() == 1)
}

/// A share in per cent.
fn percent(share: f64) -> String {
    format!("{} %", number(100.0 * share, 0))
}

/// The outcome in one paragraph.
#[must_use]
pub fn verdict_sentence<M>(d: &Diagnosis<M>) -> String {
    let (named, any) = (percent(d.explainable.named), percent(d.explainable.any_correction));
    let leading = headline::leading(d).0;
    let causes = headline::capitalised(&headline::with_values(&leading));
    let reduction = |is_one: bool| {
        Headline::of(d).map_or_else(String::new, |h| {
            let n = |v| significant(v, 3);
            let (verb, share) = h.change(is_one);
            format!(
                " {verb} the RMSE of the {} on the test set from {} to {} {}, by {}",
                h.output,
                n(h.before),
                n(h.after),
                h.unit,
                percent(share)
            )
        })
    };
    let shares = format!(
        " Of the squared error above the noise in all channels, {named} is removed; a flexible model without names removes {any}."
    );
    let times = headline::times(&d.causes);
    let more = format!("{times}{}{}", headline::worse(d), headline::lesser(d));
    let because = in_detail(d.reasons.iter());
    if let Some(r) = learned(d) {
        let (subjects, is_one) = subjects(d);
        let reduction = reduction(is_one);
        return format!("{subjects}{reduction}. {}{more}{because}", r.sentence);
    }
    match d.verdict {
        Verdict::NothingFound => {
            "The model predicts these recordings as well as noise and its baseline discrepancy allow; \
             these data show no fault."
                .into()
        }
        Verdict::Unexplained if let Some(late) = &d.late_fault => {
            let late = late.sentence();
            let others = in_detail(d.reasons.iter().filter(|reason| **reason != late));
            let begin = headline::capitalised(&late);
            format!("{begin}. Record more data to see whether it persists.{others}")
        }
        Verdict::Unexplained => format!(
            "There is an error, and no listed cause explains it: the best candidate alone, {}, removes {} \
             of the squared error. A flexible model without names removes {any} of the squared error above the noise.{because}",
            d.ranking.first().map_or_else(|| "none".into(), |r| plain_name(&r.effect)),
            percent(d.ranking.first().map_or(0.0, |r| r.score)),
        ),
        Verdict::Unconfirmed => format!(
            "The recordings suggest a cause, most likely {}, but the test data do not confirm it. Record more data.{because}",
            d.refused.first().map_or_else(|| "none of the candidates".into(), |r| plain_name(&r.effect)),
        ),
        Verdict::ModelInadequate => format!(
            "The model's own errors on the baseline recordings are as large as the errors in these data, so a fault cannot be \
             distinguished from them. Train the model further, or record where it is accurate.{because}"
        ),
        Verdict::Explained => {
            let reduction = reduction(leading.len() == 1);
            format!("{causes}{reduction}. The remaining error is noise.{more}{shares}")
        }
        Verdict::PartlyExplained if d.untested_change.is_some() => {
            let (verb, object) =
                if leading.len() == 1 { ("explains", "it") } else { ("explain", "them") };
            format!(
                "{causes} {verb} the error of the fitted recordings, but the test data do not test {object}, so the error reduction is not \
                 measured. Record test data that excite {object}.{more}{because}"
            )
        }
        Verdict::PartlyExplained => {
            let reduction = reduction(leading.len() == 1);
            format!("{causes}{reduction}, but a part of the error remains.{more}{shares}{because}")
        }
    }
}

/// The reasons in a sentence with a space before it; empty without any.
fn in_detail<'r>(reasons: impl Iterator<Item = &'r String>) -> String {
    let all: Vec<&str> = reasons.map(String::as_str).collect();
    if all.is_empty() { String::new() } else { format!(" In detail: {}.", all.join("; ")) }
}

fn summary<M: ReportModel>(d: &Diagnosis<M>) -> Markup {
    let overall = &d.error_reduction.overall;
    html! {
        div.note { (verdict_sentence(d)) }
        div.cards {
            (card(&d.verdict.to_string().replace('_', " "), "verdict"))
            @if let (Some(c), Some(o)) = (d.error_reduction.channels.first(), d.outputs.first()) {
                (card(&format!("{} → {} {}", number(c.rmse_before, 4), number(c.rmse_after, 4), o.unit),
                    &format!("{} RMSE, test set", o.name)))
            }
            (card(&percent(overall.error_reduction),
                &format!("less error in all fitted channels together [{}, {}]", percent(overall.ci95[0]), percent(overall.ci95[1]))))
        }
        (location::figure(&d.causes))
        @if d.is_extended() { (measures(d)) }
        p { "Fitted recordings: " (d.fitted.join(", ")) ". " (d.validation.sentence()) " " (d.test.sentence()) }
        (d.model.notes())
    }
}

/// The measures of improvement, each with its definition.
fn measures<M>(d: &Diagnosis<M>) -> Markup {
    let overall = &d.error_reduction.overall;
    let rows = [
        Headline::of(d).map(|h| {
            (
                format!("RMSE of the {} (headline)", h.output),
                percent(h.reduction()),
                "1 − RMSE after / RMSE before, test set",
            )
        }),
        Some((
            "all fitted channels together".to_owned(),
            percent(overall.error_reduction),
            "1 − E after / E before with E² = Σ MSE / variance over the fitted channels, test set",
        )),
        Some((
            "squared error above the noise".to_owned(),
            percent(d.explainable.named),
            "1 − excess after / excess before in all channels; the excess is the squared error beyond the noise",
        )),
    ];
    html! {
        div.scroll { table {
            tr { th { "measure of improvement" } th { "reduction" } th.text { "definition" } }
            @for (measure, value, definition) in rows.into_iter().flatten() {
                tr { td { (measure) } td { (value) } td.text.wrap { (definition) } }
            }
        } }
    }
}

fn changes<M: ReportModel>(d: &Diagnosis<M>) -> Markup {
    if let Some(r) = learned(d) {
        return html! {
            p { "The model is extended by "
                @match &r.law {
                    Some(law) => { "the law"
                        @if !law.beside.is_empty() { " beside " (law.beside.join(" and ")) } },
                    None => { "the smooth correction beside the named causes" },
                }
                "; " code { "model.safetensors" } " holds it with its definition." }
        };
    }
    if d.causes.is_empty() {
        return html! { p { "Nothing: the model stays unchanged." } };
    }
    let n = |v: f64| significant(v, 4);
    html! {
        p { (d.model.extension()) }
        div.scroll { table {
            tr { th { "cause" } th { "parameter" } th { "value" } th { "95 % interval" } th.text { "meaning" } }
            @for c in &d.causes { @for (k, (name, i)) in c.parameters.iter().enumerate() {
                tr {
                    td { @if k == 0 { (plain_name(&c.effect)) } }
                    td { (name) }
                    td { (n(i.value)) }
                    td { (n(i.ci95[0])) " to " (n(i.ci95[1])) }
                    td.text { @if k == 0 { (c.description) } }
                }
            } }
        } }
    }
}
