//! The report of a training run.

mod curves;
mod effects;

pub use effects::effect_curves;

use crate::page::{card, number, page};
use maud::{Markup, html};
use pam_data::Channel;

/// A stage of a training run.
#[derive(Debug, Clone, PartialEq)]
pub struct StageRow {
    /// Its name.
    pub name: String,
    /// Epochs that it took.
    pub epochs: usize,
    /// Time that it took, s.
    pub seconds: f64,
    /// Loss of its first epoch.
    pub loss_first: f64,
    /// Its smallest loss.
    pub loss_best: f64,
    /// Mean R² of x, ẋ, P_f and P_e over the recordings trained on, at its end.
    pub r2_train: [f64; 4],
    /// The same over held-out recordings, if there are any.
    pub r2_held: Option<[f64; 4]>,
}

/// An epoch of a training run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EpochRow {
    /// The stage, by its place in [`TrainingReport::stages`].
    pub stage: usize,
    /// Number of the epoch, counted over all stages.
    pub epoch: usize,
    /// The loss.
    pub loss: f64,
    /// The learning rate.
    pub rate: f64,
    /// Norm of the gradient before it was clipped.
    pub gradient_norm: f64,
    /// Mean R² of the displacement over held-out recordings, if they were predicted in this epoch.
    pub held_r2: Option<f64>,
}

/// Content of the report of a training run.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TrainingReport {
    /// Title of the page.
    pub title: String,
    /// One sentence on model and data.
    pub lead: String,
    /// Program and version for the footer.
    pub made_by: String,
    /// The stages in their order.
    pub stages: Vec<StageRow>,
    /// The epochs in their order.
    pub history: Vec<EpochRow>,
    /// Other events, in sentences: rollbacks and the like.
    pub events: Vec<String>,
    /// Parameters after training.
    pub parameters: Vec<ParameterRow>,
}

/// A physical parameter after training.
#[derive(Debug, Clone, PartialEq)]
pub struct ParameterRow {
    /// Name and symbol.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Value; none if the data do not determine it.
    pub value: Option<f64>,
    /// Standard error, if there is one.
    pub standard_error: Option<f64>,
    /// A note, for example that the data do not determine the parameter.
    pub note: String,
}

/// The report as HTML text. `sections` are further parts with their headings, made by this crate.
#[must_use]
pub fn training_report(report: &TrainingReport, sections: &[(&str, Markup)]) -> String {
    let body = html! {
        (cards(report))
        h2 { "Loss and scores over the epochs" }
        @if report.history.is_empty() {
            p { "No epoch was recorded." }
        } @else {
            (curves::curves(report))
        }
        h2 { "Stages" }
        (stage_table(&report.stages))
        @if !report.parameters.is_empty() {
            h2 { "Parameters" }
            (parameters(&report.parameters))
        }
        h2 { "Events" }
        @if report.events.is_empty() {
            p { "None: no epoch was rolled back." }
        } @else {
            ul { @for event in &report.events { li { (event) } } }
        }
        @for (heading, section) in sections {
            h2 { (heading) }
            (section)
        }
    };
    page(&report.title, &report.lead, &body, &report.made_by)
}

fn cards(report: &TrainingReport) -> Markup {
    let epochs: usize = report.stages.iter().map(|s| s.epochs).sum();
    let seconds: f64 = report.stages.iter().map(|s| s.seconds).sum();
    html! {
        div.cards {
            (card(&report.stages.len().to_string(), "stages"))
            (card(&epochs.to_string(), "epochs"))
            (card(&duration(seconds), "time in the stages"))
            @if let Some(last) = report.stages.last() {
                (card(&significant(last.loss_best, 4), "best loss of the last stage"))
                (card(&number(last.r2_train[0], 3), "R² displacement, trained on"))
                @if let Some(held) = last.r2_held {
                    (card(&number(held[0], 3), "R² displacement, held out"))
                }
            }
        }
    }
}

fn stage_table(stages: &[StageRow]) -> Markup {
    let held = stages.iter().any(|s| s.r2_held.is_some());
    html! {
        div.scroll { table {
            tr {
                th.empty colspan="6" {}
                th.group colspan="4" { "R² trained on" }
                @if held { th.group colspan="4" { "R² held out" } }
            }
            tr {
                th {} th.text { "stage" } th { "epochs" } th { "time" }
                th { "first loss" } th { "best loss" }
                @for c in Channel::ALL { th { (c.key()) } }
                @if held { @for c in Channel::ALL { th { (c.key()) } } }
            }
            @for (k, s) in stages.iter().enumerate() {
                tr {
                    td { (k + 1) }
                    td class="text wrap" { (s.name) }
                    td { (s.epochs) }
                    td { (duration(s.seconds)) }
                    td { (significant(s.loss_first, 4)) }
                    td { (significant(s.loss_best, 4)) }
                    @for r2 in s.r2_train { td { (number(r2, 3)) } }
                    @if held { @for r2 in s.r2_held.unwrap_or([f64::NAN; 4]) { td { (number(r2, 3)) } } }
                }
            }
        } }
    }
}

fn parameters(rows: &[ParameterRow]) -> Markup {
    html! {
        div.scroll { table {
            tr { th { "parameter" } th.text { "unit" } th { "value" } th { "standard error" } th.text {} }
            @for row in rows {
                tr {
                    td { (row.name) } td.text { (row.unit) }
                    td {
                        @if let Some(value) = row.value { (significant(value, 6)) }
                        @else { "withheld" }
                    }
                    td {
                        @if let Some(error) = row.standard_error { "± " (significant(error, 2)) }
                        @else { "–" }
                    }
                    td class="text wrap" { (row.note) }
                }
            }
        } }
    }
}

/// A number to some significant digits, or a dash if it is undefined.
fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() || value == 0.0 {
        return number(value, 0);
    }
    let exponent = value.abs().log10().floor() as i32;
    if !(-3..=5).contains(&exponent) {
        return format!("{value:.*e}", digits - 1);
    }
    number(value, usize::try_from(digits as i32 - 1 - exponent).unwrap_or(0))
}

fn duration(seconds: f64) -> String {
    if !seconds.is_finite() {
        return "–".into();
    }
    let whole = seconds.round() as u64;
    match whole {
        0..100 => format!("{seconds:.1} s"),
        100..6000 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole / 60 % 60),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(super) fn example() -> TrainingReport {
        let stage = |name: &str, held| StageRow {
            name: name.into(),
            epochs: 20,
            seconds: 75.0,
            loss_first: 12.5,
            loss_best: 0.068_25,
            r2_train: [0.971, 0.95, 0.92, 0.91],
            r2_held: held,
        };
        let epoch = |k: usize| EpochRow {
            stage: k / 20,
            epoch: k,
            loss: 10.0 * (-0.1 * k as f64).exp(),
            rate: if k < 30 { 1e-2 } else { 9.5e-3 },
            gradient_norm: 3.0,
            held_r2: k.is_multiple_of(10).then(|| 0.9 - 5.0 / (1.0 + k as f64)),
        };
        TrainingReport {
            title: "Training".into(),
            lead: "Two stages.".into(),
            made_by: "test".into(),
            stages: vec![
                stage("damping 6500 kg/s", None),
                stage("no damping", Some([0.88, 0.8, 0.7, 0.6])),
            ],
            history: (0..40).map(epoch).collect(),
            events: vec!["Epoch 7 was <rolled back>.".into()],
            parameters: vec![
                ParameterRow {
                    name: "m".into(),
                    unit: "kg".into(),
                    value: Some(304.648_28),
                    standard_error: Some(0.213),
                    note: String::new(),
                },
                ParameterRow {
                    name: "C".into(),
                    unit: "kPa·mm³/g".into(),
                    value: Some(8.47e7),
                    standard_error: None,
                    note: "not <identified>".into(),
                },
            ],
        }
    }

    #[test]
    fn a_report_holds_every_part() {
        let section = html! { p { "trusted " b { "markup" } } };
        let html = training_report(&example(), &[("Learned force", section)]);
        for part in [
            "damping 6500 kg/s",
            "2 min 30 s",
            "0.06825",
            "<td>0.880</td>",
            "304.648",
            "± 0.21",
            "not &lt;identified&gt;",
            "8.47000e7",
            "Epoch 7 was &lt;rolled back&gt;.",
            "trusted <b>markup</b>",
            "Learned force",
        ] {
            assert!(html.contains(part), "{part}");
        }
    }

    #[test]
    fn an_empty_run_makes_a_page() {
        let html = training_report(&TrainingReport::default(), &[]);
        assert!(html.contains("No epoch was recorded.") && !html.contains("<svg"));
    }

    #[test]
    fn numbers_keep_their_digits() {
        assert_eq!(significant(304.648_28, 6), "304.648");
        assert_eq!(significant(0.000_012_345, 3), "1.23e-5");
        assert_eq!(significant(0.0, 3), "0");
        assert_eq!(significant(f64::NAN, 3), "–");
        assert_eq!(significant(123_456.0, 3), "123456");
        assert_eq!(["1.5 s", "2 min 00 s", "2 h 01 min"], [1.5, 120.0, 7265.0].map(duration));
    }
}
