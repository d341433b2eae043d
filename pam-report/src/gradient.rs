//! The report of a gradient.

use crate::figure::{LineFigure, Role, envelope};
use crate::page::{card, figure, number, page};
use maud::html;
use pam_data::Recording;

/// Pixel columns of a time series.
const BUCKETS: usize = 700;
/// Recordings whose trajectory is drawn.
const MOST_DRAWN: usize = 6;

/// The gradient with respect to one group of parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct GradientBlock {
    /// Name of the group.
    pub name: String,
    /// The numbers.
    pub values: Vec<f64>,
}

impl GradientBlock {
    /// Euclidean norm.
    #[must_use]
    pub fn norm(&self) -> f64 {
        self.values.iter().map(|v| v * v).sum::<f64>().sqrt()
    }

    /// Largest magnitude.
    #[must_use]
    pub fn largest(&self) -> f64 {
        self.values.iter().fold(0.0, |m, v| m.max(v.abs()))
    }
}

/// Content of the report.
#[derive(Debug, Clone)]
pub struct GradientReport {
    /// Title of the page.
    pub title: String,
    /// One sentence on model, loss and method.
    pub lead: String,
    /// The loss.
    pub loss: f64,
    /// Time for value and gradient, s.
    pub seconds: f64,
    /// Largest error of x against a reference, mm.
    pub x_error_mm: Option<f64>,
    /// Each recording with its loss and its predicted states `[x, ẋ, P_f, P_e]`.
    pub recordings: Vec<(Recording, f64, Vec<[f64; 4]>)>,
    /// The gradient.
    pub blocks: Vec<GradientBlock>,
    /// Program and version.
    pub made_by: String,
}

/// Loss, gradient and trajectories as HTML text.
#[must_use]
pub fn gradient_report(report: &GradientReport) -> String {
    let magnitudes = |block: &GradientBlock| {
        let mut sorted: Vec<f64> =
            block.values.iter().map(|v| v.abs()).filter(|v| *v > 0.0).collect();
        sorted.sort_by(|a, b| b.total_cmp(a));
        let share = 100.0 / sorted.len().max(1) as f64;
        let points =
            sorted.iter().enumerate().map(|(i, v)| (share * (i as f64 + 1.0), v.log10())).collect();
        LineFigure::new("", "share of the parameters (%)", "log10 |gradient|", 370, 260)
            .with("", Role::Predicted, points)
            .to_svg()
    };
    let drawn = || report.recordings.iter().filter(|(_, _, states)| !states.is_empty());
    let body = html! {
        div class="cards" {
            (card(&number(report.loss, 4), "loss"))
            (card(&format!("{} s", number(report.seconds, 4)), "value and gradient"))
            @if let Some(error) = report.x_error_mm {
                (card(&format!("{error:.2e} mm"), "largest error of x"))
            }
        }
        h2 { "Gradient" }
        table {
            tr { th { "with respect to" } th { "numbers" } th { "norm" } th { "largest" } }
            @for block in &report.blocks {
                tr {
                    td { (block.name) } td { (block.values.len()) }
                    td { (format!("{:.4e}", block.norm())) }
                    td { (format!("{:.4e}", block.largest())) }
                }
            }
        }
        div class="grid three" {
            @for block in report.blocks.iter().filter(|b| b.values.len() > 8) {
                (figure(magnitudes(block), &format!("Magnitudes, sorted: {}", block.name)))
            }
        }
        h2 { "Recordings" }
        table {
            tr { th { "recording" } th { "samples" } th { "loss" } }
            @for (recording, loss, _) in &report.recordings {
                tr {
                    td { (recording.name) } td { (recording.len()) }
                    td { (if loss.is_nan() { "stopped early".into() } else { format!("{loss:.6e}") }) }
                }
            }
        }
        @for (recording, _, states) in drawn().take(MOST_DRAWN) {
            @let time = &recording.time_s;
            @let x: Vec<f64> = states.iter().map(|s| s[0]).collect();
            (figure(
                LineFigure::new(&recording.name, "time (s)", "x (mm)", 1040, 210)
                    .with("measured", Role::Measured, envelope(time, &recording.displacement_mm, BUCKETS))
                    .with("predicted", Role::Predicted, envelope(time, &x, BUCKETS))
                    .to_svg(),
                "",
            ))
        }
        @if drawn().count() > MOST_DRAWN {
            p { (drawn().count() - MOST_DRAWN) " more recordings are not drawn." }
        }
    };
    page(&report.title, &report.lead, &body, &report.made_by)
}
