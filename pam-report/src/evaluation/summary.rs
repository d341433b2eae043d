//! Sentences filled from numbers: how and where a model misses its data.

use maud::{Markup, html};
use pam_train::{Evaluation, RecordingEvaluation};

/// A direction-dependent force counts as a finding above this share of the missing force.
const NOTABLE_SHARE: f64 = 0.3;

/// A steady force counts as a finding above this share of the missing force.
const NOTABLE_OFFSET: f64 = 0.1;

pub(super) fn sentences(evaluation: &Evaluation) -> Markup {
    let all = &evaluation.recordings;
    if all.is_empty() {
        return html! { p { "Nothing was predicted." } };
    }
    html! {
        @for line in overall(all) { p { (minus(&line)) } }
        @if all.len() <= 4 {
            @for r in all { div.note { b { (r.recording.name) ": " } (minus(&of_recording(r))) } }
        } @else {
            @let worst = all.iter().min_by(|a, b| a.scores.r2.x.total_cmp(&b.scores.r2.x));
            @if let Some(r) = worst {
                div.note { b { "Worst displacement, " (r.recording.name) ": " } (minus(&of_recording(r))) }
            }
        }
    }
}

/// The minus sign in place of a hyphen before numbers.
fn minus(sentence: &str) -> String {
    sentence.replace(" -", " −")
}

fn mean(all: &[RecordingEvaluation], value: impl Fn(&RecordingEvaluation) -> f64) -> f64 {
    all.iter().map(value).sum::<f64>() / all.len() as f64
}

fn overall(all: &[RecordingEvaluation]) -> Vec<String> {
    let mut lines = Vec::new();
    let direction = mean(all, |r| r.balance.direction_n);
    let share = mean(all, |r| r.balance.direction_share);
    let missing = mean(all, |r| r.balance.rms_n);
    lines.push(format!(
        "On the measured motion the model's equation of motion leaves a force of {missing:.1} N (RMS) \
         unexplained."
    ));
    if share > NOTABLE_SHARE && direction > 0.0 {
        lines.push(format!(
            "{:.0} % of its variance while the joint moves is a part of ±{direction:.0} N that flips \
             sign with the direction of motion and opposes it. This is the signature of dry friction, which \
             no smooth force f(x, v) reproduces: the free-run prediction moves where the real joint \
             sticks.",
            100.0 * share
        ));
    } else {
        lines.push(format!(
            "A part that flips sign with the direction of motion explains {:.0} % of its variance \
             ({direction:+.1} N): dry friction is not what dominates the error.",
            100.0 * share
        ));
    }
    let offset = mean(all, |r| r.balance.offset_n);
    if offset.abs() > NOTABLE_OFFSET * missing {
        lines.push(format!(
            "A part of {offset:+.1} N does not depend on the direction: an unmodelled load, or an \
             error of the restoring force."
        ));
    }
    lines
}

fn of_recording(r: &RecordingEvaluation) -> String {
    let b = &r.balance;
    let mut text = format!(
        "displacement R² {:.3}, RMSE {:.3} mm. The missing force averages {:+.1} N while x rises and \
         {:+.1} N while it falls; the joint is near standstill {:.0} % of the time.",
        r.scores.r2.x,
        r.scores.rmse.x,
        b.rising_n,
        b.falling_n,
        100.0 * b.standstill_share
    );
    for s in &r.segments {
        if let (Some(measured), Some(predicted)) =
            (s.loop_work_measured_mj, s.loop_work_predicted_mj)
        {
            text += &format!(
                " At {} the real joint dissipates {measured:.0} mJ a cycle, the model \
                 {predicted:.0} mJ.",
                s.segment.label()
            );
        }
    }
    text
}
