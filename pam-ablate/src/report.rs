//! The results as files and as a page.

use crate::error::AblateError;
use crate::folder::{CellRecord, Planned, Quantity, Status, SweepFolder};
use crate::summary::{Mean, Summary, mean_text, short};
use crate::sweep::{Sweep, Values};
use crate::table::Table;
use maud::{Markup, html};
use pam_data::atomic::write_atomic;
use pam_numerics::statistics::mean_half_width_95;
use pam_report::figure::{LineFigure, Role, Scale, Stroke};
use pam_report::page::{card, figure, page};

/// Metrics that are shown with figures if the sweep names none.
const SHOWN: usize = 4;
/// Draws that are listed.
const LISTED: usize = 30;

/// Writes the result files of a sweep from the cells in its folder, and returns the summary.
///
/// The files are `results.csv`, `times.csv`, `summary.csv`, `summary.json`, `summary.md`, `report.html` and, with the
/// feature `parquet`, `results.parquet`.
///
/// # Errors
/// [`AblateError`] if a record cannot be read or a file not be written.
pub fn write_results(
    folder: &SweepFolder,
    sweep: &Sweep,
    planned: &[Planned],
    made_by: &str,
) -> Result<Summary, AblateError> {
    let records = folder.records(planned)?;
    let file = |name: &str| folder.path().join(name);
    let results = Table::of(sweep, planned, &records, Quantity::Metrics);
    write_atomic(file("results.csv"), results.to_csv().as_bytes())?;
    #[cfg(feature = "parquet")]
    {
        let parquet = file("results.parquet");
        write_atomic(&parquet, &results.to_parquet(&parquet)?)?;
    }
    let times = Table::of(sweep, planned, &records, Quantity::Times);
    write_atomic(file("times.csv"), times.to_csv().as_bytes())?;
    let summary = Summary::of(sweep, planned, &records, Quantity::Metrics);
    write_atomic(file("summary.csv"), summary.table().to_csv().as_bytes())?;
    let json = serde_json::to_value(&summary).unwrap_or_default();
    write_atomic(file("summary.json"), format!("{json:#}\n").as_bytes())?;
    let tables = summary.to_markdown(&shown(sweep, &summary));
    write_atomic(file("summary.md"), tables.as_bytes())?;
    let page = report(sweep, planned, &records, made_by);
    write_atomic(file("report.html"), page.as_bytes())?;
    Ok(summary)
}

/// The report as one HTML file.
#[must_use]
pub fn report(
    sweep: &Sweep,
    planned: &[Planned],
    records: &[Option<CellRecord>],
    made_by: &str,
) -> String {
    let summary = Summary::of(sweep, planned, records, Quantity::Metrics);
    let times = Summary::of(sweep, planned, records, Quantity::Times);
    let missing = summary.cells - summary.done - summary.failed;
    let shown = shown(sweep, &summary);
    let lead = format!(
        "{}{} cells, {} seed{}.",
        if sweep.question.is_empty() { String::new() } else { format!("{} ", sweep.question) },
        summary.cells,
        sweep.seeds.len(),
        if sweep.seeds.len() == 1 { "" } else { "s" }
    );
    let body = html! {
        div.cards {
            (card(&summary.done.to_string(), "cells done"))
            (card(&summary.failed.to_string(), "failed"))
            @if missing > 0 { (card(&missing.to_string(), "not run yet")) }
        }
        @if missing > 0 {
            p.note.warn { "The sweep is not complete; what follows is of the cells that are done." }
        }
        @for axis in summary.axes() {
            h2 { (axis) }
            @for metric in &shown { (axis_and_metric(&summary, axis, metric)) }
            @for metric in &times.metrics { (axis_and_metric(&times, axis, metric)) }
        }
        @if !summary.axes().is_empty() {
            p {
                "Differences are those from the first value, seed by seed: all else alike, averaged over other \
                 axes. Interval: 95 % of the mean difference by Student's t. p: paired t-test, and \
                 Wilcoxon's signed-rank test, exact, which with n seeds cannot be below 2^(1−n). Neither is \
                 corrected for looking at several values and metrics; summary.csv has Holm's correction over \
                 the values of an axis."
            }
        }
        @if !summary.draws.is_empty() { (search(sweep, &summary)) }
        (failures(sweep, planned, records))
        details { summary { "All cells" }
            (cells(sweep, planned, records, &shown))
        }
    };
    page(&format!("Sweep: {}", sweep.name), &lead, &body, made_by)
}

fn shown(sweep: &Sweep, summary: &Summary) -> Vec<String> {
    let count = if sweep.metrics.is_empty() { SHOWN } else { sweep.metrics.len() };
    summary.metrics.iter().take(count).cloned().collect()
}

/// Table and figure of one axis and metric.
fn axis_and_metric(summary: &Summary, axis: &str, metric: &str) -> Markup {
    let rows: Vec<&Mean> =
        summary.means.iter().filter(|m| m.axis == axis && m.metric == metric).collect();
    html! {
        @if !rows.is_empty() {
            h3 { (metric) }
            div.scroll { table {
                tr {
                    th { (axis) } th { "mean ± SD" } th { "seeds" } th { "difference" }
                    th { "95 % interval" } th { "p, t" } th { "p, Wilcoxon" }
                }
                @for (k, m) in rows.iter().enumerate() {
                    @let [difference, interval, t, w] = summary.difference_texts(m);
                    tr {
                        td { @if m.number.is_none() { (k + 1) ". " } (m.value) }
                        td { (mean_text(m)) } td { (m.by_seed.len()) }
                        td { (difference) } td { (interval) } td { (t) } td { (w) }
                    }
                }
            } }
            @if rows.len() > 1 {
                (figure(means(&rows, axis, metric), "Dashed: one line a seed. Solid: mean over seeds with its 95 % interval."))
            }
        }
    }
}

fn means(rows: &[&Mean], axis: &str, metric: &str) -> String {
    let numbers: Option<Vec<f64>> = rows.iter().map(|m| m.number).collect();
    let label = match numbers {
        Some(_) => axis.to_owned(),
        None => format!("{axis}, by its number in the table"),
    };
    let xs = numbers.unwrap_or_else(|| (1..=rows.len()).map(|k| k as f64).collect());
    let (low, high) = ends(xs.iter().copied());
    let x_scale = if low > 0.0 && high / low >= 8.0 { Scale::Logarithmic } else { Scale::Linear };
    let (least, most) = ends(rows.iter().flat_map(|m| m.by_seed.iter().map(|s| s.1)));
    let y_scale =
        if least > 0.0 && most / least >= 50.0 { Scale::Logarithmic } else { Scale::Linear };
    let mut figure = LineFigure::new("", &label, metric, 1040, 340).with_scales(x_scale, y_scale);
    let mut seeds: Vec<u64> = rows.iter().flat_map(|m| m.by_seed.iter().map(|s| s.0)).collect();
    seeds.sort_unstable();
    seeds.dedup();
    for seed in seeds {
        let at = |(x, m): (&f64, &&Mean)| Some((*x, m.by_seed.iter().find(|s| s.0 == seed)?.1));
        let points = xs.iter().zip(rows).filter_map(at).collect();
        figure = figure.with_stroke("", Role::Neutral, Stroke::Dashed, points);
    }
    figure = figure.with(
        "mean",
        Role::Category(0),
        xs.iter().copied().zip(rows.iter().map(|m| m.mean)).collect(),
    );
    for (x, m) in xs.iter().zip(rows) {
        figure = figure.with("", Role::Category(0), vec![(*x, m.mean)]);
        let values: Vec<f64> = m.by_seed.iter().map(|s| s.1).collect();
        if let Some(half) = mean_half_width_95(&values) {
            let ends = vec![(*x, m.mean - half), (*x, m.mean + half)];
            figure = figure.with("", Role::Category(0), ends);
        }
    }
    figure.to_svg()
}

fn ends(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)))
}

/// Ranking and figures of a random search.
fn search(sweep: &Sweep, summary: &Summary) -> Markup {
    let metric = summary.metrics.first().cloned().unwrap_or_default();
    html! {
        h2 { "Draws by " (metric) }
        div.scroll { table {
            tr { th { "rank" } @for axis in &sweep.axes { th { (axis.name) } } th { "mean" } th { "SD" } }
            @for (k, draw) in summary.draws.iter().take(LISTED).enumerate() {
                tr {
                    td { (k + 1) }
                    @for (value, number) in draw.values.iter().zip(&draw.numbers) {
                        td { (number.map_or_else(|| value.clone(), short)) }
                    }
                    td { (short(draw.mean)) } td { (draw.deviation.map_or_else(|| "–".into(), short)) }
                }
            }
        } }
        @if summary.draws.len() > LISTED { p { "The best " (LISTED) " of " (summary.draws.len()) "." } }
        @for (a, axis) in sweep.axes.iter().enumerate() {
            @if let Values::Range(key, range) = &axis.values {
                @let scale = if matches!(range, crate::sweep::Range::LogUniform(..)) { Scale::Logarithmic } else { Scale::Linear };
                @let draws = summary.draws.iter().fold(
                    LineFigure::new("", key, &metric, 1040, 320).with_scales(scale, Scale::Linear),
                    |figure, draw| match draw.numbers[a] {
                        Some(x) => figure.with("", Role::Category(0), vec![(x, draw.mean)]),
                        None => figure,
                    },
                );
                (figure(draws.to_svg(), "One point a draw, the mean over its seeds."))
            }
        }
    }
}

fn failures(sweep: &Sweep, planned: &[Planned], records: &[Option<CellRecord>]) -> Markup {
    let failed: Vec<(&Planned, &CellRecord)> = planned
        .iter()
        .zip(records)
        .filter_map(|(p, r)| Some((p, r.as_ref().filter(|r| r.status == Status::Failed)?)))
        .collect();
    html! {
        @if !failed.is_empty() {
            h2 { "Failed cells" }
            div.scroll { table {
                tr { th { "cell" } th.text { "settings" } th.text { "why" } }
                @for (p, r) in failed {
                    tr {
                        td { code { (p.id) } } td.text { (p.cell.describe(sweep)) }
                        td.text.wrap { (r.error.as_deref().unwrap_or("–")) }
                    }
                }
            } }
        }
    }
}

fn cells(
    sweep: &Sweep,
    planned: &[Planned],
    records: &[Option<CellRecord>],
    metrics: &[String],
) -> Markup {
    html! {
        div.scroll { table {
            tr {
                th { "cell" } @for axis in &sweep.axes { th { (axis.name) } } th { "seed" } th { "status" }
                @for metric in metrics { th { (metric) } }
            }
            @for (p, r) in planned.iter().zip(records) {
                tr {
                    td { code { (p.id) } }
                    @for choice in &p.cell.choices { td { (choice.number.map_or_else(|| choice.label.clone(), short)) } }
                    td { (p.cell.seed) }
                    td { (match r.as_ref().map(|r| r.status) {
                        None => "not run yet", Some(Status::Done) => "done", Some(Status::Failed) => "failed" }) }
                    @for metric in metrics {
                        td { (r.as_ref().and_then(|r| r.value(Quantity::Metrics, metric)).map_or_else(|| "–".into(), short)) }
                    }
                }
            }
        } }
    }
}
