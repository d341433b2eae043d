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
    let of = |prefix: &str| -> Vec<&Table> {
        tables.iter().filter(|t| t.title.starts_with(prefix)).collect()
    };
    let has = |part: &str| result.part(part).next().is_some();
    let all = findings::findings(result);
    let body = html! {
        @if !all.is_empty() {
            h2 { "What the numbers say" }
            ul { @for finding in &all { li { (finding) } } }
        }
        div class="note" {
            p {
                "Two errors are shown. “Frozen steps”: against the gradient of the steps that the solve took, \
                 by dual numbers through the solver; methods that differentiate the solver have none but \
                 rounding there. (The row “dual” is that same arithmetic.) “Truth”: against the gradient of \
                 the exact solution, in closed form or at a tolerance of 1e-12; steps that are too long show \
                 there, whatever the method. Both are relative, and the largest over the network's weights, \
                 the other parameters, and the initial state."
            }
        }
        @if has(parts::STEPS) {
            h2 { "Order of the solver, kinked and smooth" }
            (paragraphs(&findings::order(result)))
            div class="grid" { @for (svg, caption) in figures::steps(result) { (figure(svg, &caption)) } }
            (folded("All steps", &of("Runge–Kutta")))
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
            (paragraphs(&findings::stiffness(result)))
            (paragraphs(&findings::trap(result)))
            div class="grid" { @for (svg, caption) in figures::traps(result) { (figure(svg, &caption)) } }
            (folded("Activations", &of("Activations")))
            @for table in grid_tables(&tables) { (folded_one(table)) }
        }
        @if has(parts::HORIZON) {
            h2 { "Growth with the horizon" }
            (paragraphs(&findings::horizon(result)))
            div class="grid" { @for (svg, caption) in figures::horizon(result) { (figure(svg, &caption)) } }
            (folded("All horizons", &of("Against the horizon")))
        }
        @if has(parts::PARAMETERS) {
            h2 { "Growth with the number of parameters" }
            (paragraphs(&findings::parameters(result)))
            div class="grid" { @for (svg, caption) in figures::parameters(result) { (figure(svg, &caption)) } }
            (folded("All sizes", &of("Against the number")))
        }
        @if has(parts::LANES) {
            h2 { "Lanes" }
            (paragraphs(&findings::lanes(result)))
            @for table in of("Lanes") { (markup(table)) }
        }
        @if has(parts::CHECKPOINTS) {
            h2 { "Time for memory" }
            (paragraphs(&findings::checkpoints(result)))
            @for table in of("Checkpointing") { (markup(table)) }
        }
    };
    page("Gradient methods, compared", &about(result), &body, made_by)
}

/// The tables of single problems of the grid, and those of parts that others added.
fn grid_tables(tables: &[Table]) -> impl Iterator<Item = &Table> {
    const OTHER: [&str; 6] =
        ["Runge–Kutta", "Activations", "Against", "Lanes", "Checkpointing", "\u{0}"];
    tables.iter().filter(|t| !OTHER.iter().any(|prefix| t.title.starts_with(prefix)))
}

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
