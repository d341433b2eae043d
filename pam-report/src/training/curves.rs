//! The course of a training run over its epochs.

use super::{EpochRow, TrainingReport};
use crate::figure::{Band, LineFigure, Role, Scale, envelope};
use crate::page::{count, figure};
use maud::{Markup, html};

/// Pixel columns of a curve.
const BUCKETS: usize = 700;
/// Most points that have marks.
const MOST_MARKED: usize = 80;
/// Smallest R² that is drawn: below it a model is of no use, and the rest would be squeezed.
const LOWEST_R2: f64 = -1.0;

/// Loss, held-out R², gradient norm and learning rate.
pub(super) fn curves(report: &TrainingReport) -> Markup {
    let history = &report.history;
    let held: Vec<(f64, f64)> = history
        .iter()
        .filter_map(|row| Some((row.epoch as f64, row.held_r2?)))
        .filter(|(_, r2)| r2.is_finite())
        .collect();
    let shown: Vec<(f64, f64)> = held.iter().copied().filter(|p| p.1 >= LOWEST_R2).collect();
    let curve = |title: &str, role: Role, height: u32, value: fn(&EpochRow) -> f64| {
        let mut plot = LineFigure::new(title, "epoch", title, 1040, height)
            .with_scales(Scale::Linear, scale(history.iter().map(value)))
            .with_bands(bands(history));
        for stage in history.chunk_by(|a, b| a.stage == b.stage) {
            plot = plot.with("", role, points(stage, history.len(), value));
        }
        plot.to_svg()
    };
    html! {
        (figure(curve("loss", Role::Predicted, 320, |row| row.loss),
            "Stripes, with numbers at the top, are the stages. The loss may jump between stages, \
             whose recordings and damping differ."))
        @if !shown.is_empty() {
            @let left_out = held.len() - shown.len();
            (figure(held_figure(report, &shown), &if left_out == 0 {
                String::new()
            } else {
                format!("{} below {LOWEST_R2}, not shown.", count(left_out, "value")).replace('-', "−")
            }))
        } @else if !held.is_empty() {
            p { "R² on held-out recordings stayed below " (LOWEST_R2.to_string().replace('-', "−")) "." }
        }
        (figure(curve("learning rate", Role::Category(2), 190, |row| row.rate), ""))
        (figure(curve("gradient norm", Role::Residual, 230, |row| row.gradient_norm), ""))
    }
}

/// Logarithmic for numbers of different sizes; a narrow band would have too few marks.
fn scale(values: impl Iterator<Item = f64>) -> Scale {
    let (low, high) = values
        .filter(|v| v.is_finite() && *v > 0.0)
        .fold((f64::MAX, 0.0_f64), |(low, high), v| (low.min(v), high.max(v)));
    if high > 5.0 * low { Scale::Logarithmic } else { Scale::Linear }
}

fn held_figure(report: &TrainingReport, shown: &[(f64, f64)]) -> String {
    let label = "held-out R² of x";
    let mut plot =
        LineFigure::new(label, "epoch", label, 1040, 260).with_bands(bands(&report.history));
    if shown.len() <= MOST_MARKED {
        plot = plot.with_marks();
    }
    let (x, y): (Vec<f64>, Vec<f64>) = shown.iter().copied().unzip();
    plot.with("", Role::Category(0), envelope(&x, &y, BUCKETS)).to_svg()
}

/// One band a stretch of one stage, from its first epoch to the next stretch's.
fn bands(history: &[EpochRow]) -> Vec<Band> {
    let starts: Vec<EpochRow> =
        history.chunk_by(|a, b| a.stage == b.stage).map(|stretch| stretch[0]).collect();
    let end = history.last().map_or(0, |row| row.epoch);
    let ends = starts.iter().skip(1).map(|row| row.epoch).chain([end]);
    let band = |(start, end): (&EpochRow, usize)| Band {
        from: start.epoch as f64,
        to: end as f64,
        label: (start.stage + 1).to_string(),
    };
    starts.iter().zip(ends).map(band).collect()
}

/// The curve of one stage, with its share of the columns.
fn points(stage: &[EpochRow], all: usize, value: fn(&EpochRow) -> f64) -> Vec<(f64, f64)> {
    let (x, y): (Vec<f64>, Vec<f64>) =
        stage.iter().map(|row| (row.epoch as f64, value(row))).filter(|p| p.1.is_finite()).unzip();
    envelope(&x, &y, (BUCKETS * stage.len() / all.max(1)).max(4))
}

#[cfg(test)]
mod tests {
    use super::super::tests::example;
    use super::*;

    #[test]
    fn bands_follow_the_stages() {
        let bands = bands(&example().history);
        let edges: Vec<_> = bands.iter().map(|b| (b.from, b.to, b.label.as_str())).collect();
        assert_eq!(edges, [(0.0, 20.0, "1"), (20.0, 39.0, "2")]);
    }

    #[test]
    fn only_numbers_of_different_sizes_get_a_logarithmic_axis() {
        assert_eq!(scale([1e-2, f64::NAN, 9e-3].into_iter()), Scale::Linear);
        assert_eq!(scale([1e-2, 1e-4].into_iter()), Scale::Logarithmic);
        assert_eq!(scale([0.0].into_iter()), Scale::Linear);
    }

    #[test]
    fn undefined_losses_are_left_out_and_hopeless_r2_is_counted() {
        let mut report = example();
        report.history[3].loss = f64::NAN;
        assert_eq!(points(&report.history[..20], 40, |row| row.loss).len(), 19);
        let html = curves(&report).into_string();
        assert!(html.contains("1 value below −1, not shown."));
        // Three of the four held-out values are drawn, each with a mark.
        assert_eq!(html.matches("<circle").count(), 3);
        assert_eq!(html.matches("class=\"figure\"").count(), 4);
    }
}
