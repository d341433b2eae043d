//! The report of an evaluation: how well recordings are predicted, where and how they are missed.

mod maps;
mod recording;
mod story;

use crate::page::{card, number, page};
use maud::{Markup, html};
use pam_data::{Channel, ModelInfo};
use pam_train::{Evaluation, RecordingEvaluation};

/// Recordings that get figures of their own; of a larger set the worst, middle and best third of
/// this many.
const MOST_DETAILED: usize = 12;

/// What a report says besides the results.
#[derive(Debug, Clone)]
pub struct EvaluationContext {
    /// The model.
    pub model: ModelInfo,
    /// One line on its force and parameters.
    pub model_line: String,
    /// The solver settings in one line.
    pub solver_line: String,
    /// Program and version for the footer.
    pub made_by: String,
}

/// The report as HTML text.
#[must_use]
pub fn evaluation_report(evaluation: &Evaluation, context: &EvaluationContext) -> String {
    let mean = &evaluation.mean;
    let detailed = choose_detailed(&evaluation.recordings);
    let body = html! {
        div.cards {
            (card(&number(mean.r2.x, 3), "mean R² displacement"))
            (card(&number(mean.r2.v, 3), "mean R² velocity"))
            (card(&number(mean.r2.pf, 3), "mean R² flexor pressure"))
            (card(&number(mean.r2.pe, 3), "mean R² extensor pressure"))
            (card(&number(mean.rmse.x, 3), "mean RMSE displacement (mm)"))
            (card(&evaluation.recordings.len().to_string(), "recording(s) predicted"))
        }
        p { "Every prediction starts from the first sample of its recording and is driven by the "
            "measured force alone. " (context.model_line) " Solved with " (context.solver_line) "." }
        @if !evaluation.failed.is_empty() { (failures(evaluation)) }
        h2 { "What the model misses" }
        (story::sentences(evaluation))
        h2 { "Error over the operating points" }
        @if evaluation.recordings.len() > 1 {
            (maps::maps(&evaluation.recordings))
        } @else {
            details {
                summary { "One recording is one point of each plane; a data set fills them" }
                (maps::maps(&evaluation.recordings))
            }
        }
        h2 { "Recordings" }
        (table(&evaluation.recordings))
        @for (i, r) in detailed.iter().enumerate() {
            h2 { "Recording " (r.recording.name) }
            (recording::section(r, i))
        }
        @if detailed.len() < evaluation.recordings.len() {
            p { "Figures are shown for the worst, the middle and the best recordings by R² of the "
                "displacement; the table lists all." }
        }
    };
    page(
        &format!("Prediction by {}", context.model.name),
        &context.model.provenance,
        &body,
        &context.made_by,
    )
}

fn failures(evaluation: &Evaluation) -> Markup {
    html! {
        div class="note warn" {
            b { (evaluation.failed.len()) " recording(s) could not be predicted:" }
            ul {
                @for f in &evaluation.failed { li { (f.name) ": " (f.why) } }
            }
        }
    }
}

fn table(recordings: &[RecordingEvaluation]) -> Markup {
    html! {
        div.scroll { table {
            tr {
                th { "recording" } th { "m_f (g)" } th { "m_e (g)" } th { "masses" }
                @for c in Channel::ALL { th { "R² " (c.key()) } }
                @for c in Channel::ALL { th { "RMSE " (c.key()) " (" (c.unit()) ")" } }
            }
            @for r in recordings {
                tr {
                    td { (r.recording.name) }
                    td { (number(r.masses.flexor_g, 5)) }
                    td { (number(r.masses.extensor_g, 5)) }
                    td.text { (r.origin.label()) }
                    @for c in Channel::ALL { td { (number(r.scores.r2.get(c), 4)) } }
                    @for c in Channel::ALL { td { (number(r.scores.rmse.get(c), 4)) } }
                }
            }
        } }
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
