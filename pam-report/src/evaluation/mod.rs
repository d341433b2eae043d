//! The report of an evaluation: how well recordings are predicted, where and how they are missed.

mod maps;
mod recording;
mod split;
mod summary;

use crate::force_curves::force_curves;
use crate::page::{card, count, number, page};
use crate::parameters::parameter_table;
use maud::{Markup, html};
use pam_core::{ForceModel, JointModel};
use pam_data::{Channel, ModelInfo};
use pam_train::{Evaluation, RecordingEvaluation};
use pam_trajectory::Scores;
use split::Split;

/// Recordings that get figures of their own; of a larger set the worst, middle and best third of
/// this many.
const MOST_DETAILED: usize = 12;

/// Text of a report around the results.
#[derive(Debug, Clone)]
pub struct EvaluationContext {
    /// The model.
    pub model: ModelInfo,
    /// One line on its force and parameters.
    pub model_line: String,
    /// The solver settings in one line.
    pub solver_line: String,
    /// Names of the recordings that the model was trained on; empty if that is not known.
    pub trained_on: Vec<String>,
    /// Program and version for the footer.
    pub made_by: String,
}

/// The report of an evaluation of `model` as HTML text.
#[must_use]
pub fn evaluation_report<F: ForceModel<f64>>(
    evaluation: &Evaluation,
    model: &JointModel<f64, F>,
    context: &EvaluationContext,
) -> String {
    let mean = &evaluation.mean;
    let split = Split::new(&evaluation.recordings, &context.trained_on);
    let trained_on = |r: &RecordingEvaluation| split.trained_on(&r.recording.name);
    let detailed = choose_detailed(&evaluation.recordings);
    let body = html! {
        div.cards {
            (card(&number(mean.r2.x, 3), "mean R² displacement"))
            (card(&number(mean.r2.v, 3), "mean R² velocity"))
            (card(&number(mean.r2.pf, 3), "mean R² flexor pressure"))
            (card(&number(mean.r2.pe, 3), "mean R² extensor pressure"))
            (card(&number(mean.rmse.x, 3), "mean RMSE displacement (mm)"))
            (card(&evaluation.recordings.len().to_string(), "recordings predicted"))
        }
        (split.cards())
        p { "Every prediction starts from the first sample of its recording and is driven by the "
            "measured force alone. " (context.model_line) " Solved with " (context.solver_line) "." }
        @if !evaluation.failed.is_empty() { (failures(evaluation)) }
        h2 { "What the model misses" }
        (summary::sentences(evaluation))
        h2 { "Error over the operating points" }
        @if evaluation.recordings.len() > 1 {
            (maps::maps(&evaluation.recordings, trained_on))
        } @else {
            details {
                summary { "One recording is one point of each plane; a data set fills them" }
                (maps::maps(&evaluation.recordings, trained_on))
            }
        }
        h2 { "Learned force" }
        (force_curves(model))
        (parameter_table(model))
        h2 { "Recordings" }
        (table(evaluation, &split))
        @for (i, r) in detailed.iter().enumerate() {
            h2 { "Recording " (r.recording.name) }
            (recording::section(r, i))
        }
        @if detailed.len() < evaluation.recordings.len() {
            p { "Figures are shown for the worst, the middle and the best recordings by R² of the "
                "displacement; the table lists all." }
        }
    };
    let title = match evaluation.recordings.len() {
        0 => "No recording was predicted".to_owned(),
        1 => format!("The displacement is predicted with R² = {}", number(mean.r2.x, 3)),
        n => {
            format!(
                "The displacement of {n} recordings is predicted with a mean R² of {}",
                number(mean.r2.x, 3)
            )
        }
    };
    page(
        &title,
        &format!(
            "Model {}: {}.",
            context.model.name,
            context.model.provenance.trim_end_matches('.')
        ),
        &body,
        &context.made_by,
    )
}

fn failures(evaluation: &Evaluation) -> Markup {
    html! {
        div class="note warn" {
            b { (count(evaluation.failed.len(), "recording")) " could not be predicted:" }
            ul {
                @for f in &evaluation.failed { li { (f.name) ": " (f.why) } }
            }
        }
    }
}

fn table(evaluation: &Evaluation, split: &Split<'_>) -> Markup {
    let scores = |s: &Scores| {
        html! {
            @for c in Channel::ALL { td { (number(s.r2.get(c), 4)) } }
            @for c in Channel::ALL { td { (number(s.rmse.get(c), 4)) } }
        }
    };
    let means = split.means();
    let mean_of_all = ("mean".to_owned(), evaluation.mean);
    html! {
        div.scroll { table {
            tr {
                th { "recording" } th { "m_f (g)" } th { "m_e (g)" } th.text { "masses" }
                @for c in Channel::ALL { th { "R² " (c.key()) } }
                @for c in Channel::ALL { th { "RMSE " (c.key()) " (" (c.unit()) ")" } }
            }
            @for r in &evaluation.recordings {
                tr {
                    td { (r.recording.name) @if split.trained_on(&r.recording.name) { " ○" } }
                    td { (number(r.masses.flexor_g, 5)) }
                    td { (number(r.masses.extensor_g, 5)) }
                    td.text { (r.origin.label()) }
                    (scores(&r.scores))
                }
            }
            @for (name, mean) in std::iter::once(&mean_of_all).chain(&means) {
                tr.mean { td colspan="4" { (name) } (scores(mean)) }
            }
        } }
        @if split.is_known() { p.sub { "○: the model was trained on this recording." } }
    }
}

/// All recordings of a small set; of a large one the worst, the middle and the best.
fn choose_detailed(recordings: &[RecordingEvaluation]) -> Vec<&RecordingEvaluation> {
    if recordings.len() <= MOST_DETAILED {
        return recordings.iter().collect();
    }
    let mut order: Vec<&RecordingEvaluation> = recordings.iter().collect();
    order.sort_by(|a, b| a.scores.r2.x.total_cmp(&b.scores.r2.x));
    let (third, n) = (MOST_DETAILED / 3, order.len());
    let middle = (n - third) / 2;
    [0..third, middle..middle + third, n - third..n]
        .into_iter()
        .flat_map(|range| order[range].to_vec())
        .collect()
}
