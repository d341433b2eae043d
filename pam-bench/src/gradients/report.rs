//! The report of a study: one HTML file with sentences, figures and tables.

use super::figures;
use super::findings;
use super::output::about;
use super::parts;
use super::result::StudyResult;
use super::table::{Table, shown_tolerance, tables};
use maud::{Markup, html};
use pam_report::page::{figure, page};

/// The report as HTML text; `made_by` names program and version.
#[must_use]
pub fn report(result: &StudyResult, made_by: &str) -> String {
    let tables = tables(result);
    let of = |part: &str| tables.iter().filter(|t| t.part == part).collect::<Vec<_>>();
    let has = |part: &str| result.part(part).next().is_some();
    let body = html! {
        (paragraphs(&findings::exactness(result)))
        div class="note" {
            p {
                "Two errors are shown. “Frozen steps”: against the gradient of the steps that the solve took, \
                 by dual numbers through the solver; methods that differentiate the solver have none but \
                 rounding there. (The row “dual” is that same arithmetic.) “Truth”: against the gradient of \
                 the exact solution, in closed form, from kink to kink where there are kinks, or at a tolerance of 1e-12; steps that are too long show \
                 there, whatever the method. Both are relative, and the largest over the network's weights, \
                 the other parameters, and the initial state."
            }
        }
        @if has(parts::STEPS) {
            h2 { "Order of the solver, kinked and smooth" }
            (paragraphs(&findings::order(result)))
            div class="grid" { @for (svg, caption) in figures::steps(result) { (figure(svg, &caption)) } }
            (folded("All steps", &of(parts::STEPS)))
        }
        @if has(parts::GRID) {
            h2 { "Every method on every problem" }
            @if let Some(tolerance) = shown_tolerance(result) {
                p {
                    "Tables show the longest horizon at a tolerance of " (format!("{tolerance:.0e}"))
                    "; gradients.csv and gradients.json have every row."
                }
            }
            div class="grid" { @for (svg, caption) in figures::precision(result) { (figure(svg, &caption)) } }
            (paragraphs(&findings::kinks(result)))
            (paragraphs(&findings::stiffness(result)))
            (paragraphs(&findings::trap(result)))
            div class="grid" { @for (svg, caption) in figures::traps(result) { (figure(svg, &caption)) } }
            @for table in of(parts::GRID) { (folded_one(table)) }
        }
        @if has(parts::HORIZON) {
            h2 { "Growth with the horizon" }
            (paragraphs(&findings::horizon(result)))
            div class="grid" { @for (svg, caption) in figures::horizon(result) { (figure(svg, &caption)) } }
            (folded("All horizons", &of(parts::HORIZON)))
        }
        @if has(parts::PARAMETERS) {
            h2 { "Growth with the number of parameters" }
            (paragraphs(&findings::parameters(result)))
            div class="grid" { @for (svg, caption) in figures::parameters(result) { (figure(svg, &caption)) } }
            (folded("All sizes", &of(parts::PARAMETERS)))
        }
        @if has(parts::BATCHED) {
            h2 { "Batched trajectories" }
            (paragraphs(&findings::batched(result)))
            @for table in of(parts::BATCHED) { (markup(table)) }
        }
        @if has(parts::CHECKPOINTS) {
            h2 { "Time for memory" }
            (paragraphs(&findings::checkpoints(result)))
            @for table in of(parts::CHECKPOINTS) { (markup(table)) }
        }
        @for table in tables.iter().filter(|t| !PARTS.contains(&t.part.as_str())) {
            h2 { (table.title) }
            (cells(table))
        }
    };
    page("Gradient methods, compared", &about(result), &body, made_by)
}

const PARTS: [&str; 6] = [
    parts::STEPS,
    parts::GRID,
    parts::HORIZON,
    parts::PARAMETERS,
    parts::BATCHED,
    parts::CHECKPOINTS,
];

fn paragraphs(findings: &[String]) -> Markup {
    html! { @for finding in findings { p { (finding) } } }
}

fn folded_one(table: &Table) -> Markup {
    html! { details { summary { (table.title) } (cells(table)) } }
}

fn folded(summary: &str, tables: &[&Table]) -> Markup {
    html! {
        @if !tables.is_empty() {
            details { summary { (summary) } @for table in tables { (markup(table)) } }
        }
    }
}

fn markup(table: &Table) -> Markup {
    html! { h3 { (table.title) } (cells(table)) }
}

fn cells(table: &Table) -> Markup {
    html! {
        div class="scroll" {
            table {
                tr { @for column in &table.columns { th { (column) } } }
                @for row in &table.cells {
                    tr { @for cell in row { td { (cell.trim_matches('*')) } } }
                }
            }
        }
    }
}
