//! The study as markdown tables.

use super::parts;
use super::result::{Row, StudyResult};
use std::fmt::Write;

/// A table: a title, what is in the columns, and the cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Part of the study.
    pub part: String,
    /// Columns of the table.
    pub title: String,
    /// Names of the columns.
    pub columns: Vec<String>,
    /// The cells, row by row.
    pub cells: Vec<Vec<String>>,
}

impl Table {
    fn new(part: &str, title: impl Into<String>, columns: &[&str]) -> Self {
        let columns = columns.iter().map(|&c| c.to_owned()).collect();
        Self { part: part.into(), title: title.into(), columns, cells: Vec::new() }
    }

    /// The table in markdown.
    #[must_use]
    pub fn to_markdown(&self) -> String {
        let mut text = format!("### {}\n\n| {} |\n|", self.title, self.columns.join(" | "));
        text += &"---|".repeat(self.columns.len());
        for row in &self.cells {
            let _ = write!(text, "\n| {} |", row.join(" | "));
        }
        text + "\n"
    }
}

/// Errors with two digits; a dash if there is none.
#[must_use]
pub fn error_text(error: Option<f64>) -> String {
    match error {
        None => "–".into(),
        Some(0.0) => "0".into(),
        Some(error) => format!("{error:.1e}"),
    }
}

/// A time in a unit that suits it.
#[must_use]
pub fn seconds_text(seconds: Option<f64>) -> String {
    match seconds {
        None => "–".into(),
        Some(s) if s < 1e-3 => format!("{:.0} µs", s * 1e6),
        Some(s) if s < 0.1 => format!("{:.2} ms", s * 1e3),
        Some(s) if s < 1.0 => format!("{:.0} ms", s * 1e3),
        Some(s) => format!("{s:.2} s"),
    }
}

/// Memory in a unit that suits it.
#[must_use]
pub fn bytes_text(bytes: usize) -> String {
    match bytes as f64 {
        b if b < 1e3 => format!("{b} B"),
        b if b < 1e5 => format!("{:.1} kB", b / 1e3),
        b if b < 1e6 => format!("{:.0} kB", b / 1e3),
        b if b < 1e8 => format!("{:.1} MB", b / 1e6),
        b => format!("{:.0} MB", b / 1e6),
    }
}

/// All tables of the study. Of the grid one tolerance and one horizon a problem; the files have the rest.
#[must_use]
pub fn tables(result: &StudyResult) -> Vec<Table> {
    let mut tables = of_grid(result);
    tables.extend(of_activations(result));
    type Content = fn(&Row) -> String;
    let parts: [(&str, &str, Content); 5] = [
        (parts::STEPS, "Runge–Kutta methods at constant steps", Row::problem_text),
        (parts::HORIZON, "Against the horizon", |row| format!("{} s", row.horizon_s)),
        (parts::PARAMETERS, "Against the number of parameters", |row| row.parameters.to_string()),
        (parts::BATCHED, "Batched trajectories", |row| {
            format!("{} × width {}", row.trajectories, row.width.unwrap_or(0))
        }),
        (parts::CHECKPOINTS, "Checkpointing", |row| format!("{} s", row.horizon_s)),
    ];
    let known = |part: &str| part == parts::GRID || parts.iter().any(|(known, ..)| *known == part);
    for (part, title, first) in parts {
        let rows: Vec<&Row> = result.part(part).collect();
        if let Some(row) = rows.first() {
            let title = match part {
                parts::STEPS => title.to_owned(),
                parts::PARAMETERS => {
                    format!("{title}: {} s, {}, {}", row.horizon_s, row.solver, row.steps_text())
                }
                parts::BATCHED => format!("{title}: {} s, {}", row.horizon_s, row.steps_text()),
                _ => format!("{title}: {}, {}", row.solver, row.steps_text()),
            };
            tables.push(costs(&title, part, first, &rows));
        }
    }
    let mut others: Vec<&str> = result.rows.iter().map(|row| row.part.as_str()).collect();
    others.dedup();
    for part in others.into_iter().filter(|part| !known(part)) {
        let rows: Vec<&Row> = result.part(part).collect();
        tables.push(costs(part, part, Row::problem_text, &rows));
    }
    tables
}

/// Errors, cost and counts, with `first` in the first column.
fn costs(title: &str, part: &str, first: fn(&Row) -> String, rows: &[&Row]) -> Table {
    let name = match part {
        parts::PARAMETERS => "parameters",
        parts::HORIZON | parts::CHECKPOINTS => "horizon",
        parts::BATCHED => "trajectories",
        _ => "problem",
    };
    let with_solver = part == parts::STEPS;
    let mut columns = vec![name];
    columns.extend(if with_solver { ["solver", "step"] } else { ["method", "steps"] });
    if with_solver {
        columns.push("error of x, mm");
    }
    columns.extend([
        "error, frozen steps",
        "error, truth",
        "time",
        "peak memory",
        "stored",
        "f",
        "vjp",
        "jvp",
    ]);
    let mut table = Table::new(part, title, &columns);
    for row in rows {
        let mut cells = vec![first(row)];
        if with_solver {
            cells.extend([row.solver.clone(), row.steps_text(), error_text(row.state_error)]);
        } else {
            cells.extend([row.method_text(), row.steps.to_string()]);
        }
        cells.extend(errors_and_costs(row));
        table.cells.push(cells);
    }
    table
}

fn errors_and_costs(row: &Row) -> Vec<String> {
    if let Some(failure) = &row.failure {
        let short = failure.split(';').next().unwrap_or(failure);
        let mut cells = vec!["**failed**".into(), format!("**{short}**")];
        cells.extend(vec![String::new(); 6]);
        return cells;
    }
    vec![
        error_text(row.replay_error),
        error_text(row.gradient_error),
        seconds_text(row.seconds),
        row.peak_bytes.map_or("–".into(), bytes_text),
        bytes_text(row.checkpoint_bytes),
        row.evaluations.to_string(),
        row.vjps.to_string(),
        row.jvps.to_string(),
    ]
}

/// The tolerance that tables of the grid show: the middle one.
#[must_use]
pub fn shown_tolerance(result: &StudyResult) -> Option<f64> {
    let mut all: Vec<f64> = result.part(parts::GRID).filter_map(|row| row.rtol).collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all.get(all.len() / 2).copied()
}

/// The longest horizon of a problem of the grid.
#[must_use]
pub fn longest(result: &StudyResult, problem: &str) -> f64 {
    let rows = result.part(parts::GRID).filter(|row| row.problem == problem);
    rows.map(|row| row.horizon_s).fold(0.0, f64::max)
}

/// The rows of the grid that tables show: of each problem the longest horizon at the middle tolerance.
pub fn shown(result: &StudyResult) -> impl Iterator<Item = &Row> {
    let tolerance = shown_tolerance(result);
    result
        .part(parts::GRID)
        .filter(move |row| row.rtol.is_some() && row.rtol == tolerance)
        .filter(|row| row.horizon_s == longest(result, &row.problem))
}

/// One table a problem; of the joint one activation.
fn of_grid(result: &StudyResult) -> Vec<Table> {
    let mut tables: Vec<(String, Table)> = Vec::new();
    for row in shown(result) {
        let problem = row.problem_text();
        if row.activation.as_deref().is_some_and(|a| a != "leaky_relu" && a != "tanh") {
            continue;
        }
        if tables.last().is_none_or(|(name, _)| *name != problem) {
            let title = format!(
                "{problem}: {} parameter(s), {} s, {} at {}",
                row.parameters,
                row.horizon_s,
                row.solver,
                row.steps_text()
            );
            let table = costs(&title, parts::GRID, Row::problem_text, &[]);
            let columns = table.columns[1..].to_vec();
            tables.push((problem, Table { columns, ..table }));
        }
        if let Some((_, table)) = tables.last_mut() {
            let mut cells = vec![row.method_text(), row.steps.to_string()];
            cells.extend(errors_and_costs(row));
            table.cells.push(cells);
        }
    }
    tables.into_iter().map(|(_, table)| table).collect()
}

/// Errors of every method for every activation.
fn of_activations(result: &StudyResult) -> Vec<Table> {
    let rows: Vec<&Row> = shown(result).filter(|row| row.activation.is_some()).collect();
    let mut activations: Vec<&str> = Vec::new();
    let mut methods: Vec<String> = Vec::new();
    for row in &rows {
        let name = row.activation.as_deref().unwrap_or_default();
        if !activations.contains(&name) {
            activations.push(name);
        }
        if !methods.contains(&row.method_text()) {
            methods.push(row.method_text());
        }
    }
    if activations.len() < 2 {
        return Vec::new();
    }
    type Content = fn(&Row) -> String;
    let contents: [(&str, Content); 2] = [
        ("error against the truth", |row| error_text(row.gradient_error)),
        ("time", |row| seconds_text(row.seconds)),
    ];
    contents
        .into_iter()
        .map(|(what, content)| {
            let mut columns = vec!["method"];
            columns.extend(&activations);
            let solver = rows.first().map_or(String::new(), |row| {
                format!("{} s, {} at {}", row.horizon_s, row.solver, row.steps_text())
            });
            let mut table =
                Table::new(parts::GRID, format!("Activations, {what}: {solver}"), &columns);
            for method in &methods {
                let mut cells = vec![method.clone()];
                for activation in &activations {
                    let row = rows.iter().find(|row| {
                        row.activation.as_deref() == Some(activation)
                            && row.method_text() == *method
                    });
                    cells.push(row.map_or("–".into(), |row| match row.failure {
                        Some(_) => "failed".into(),
                        None => content(row),
                    }));
                }
                table.cells.push(cells);
            }
            table
        })
        .collect()
}
