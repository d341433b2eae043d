//! The figures of a study, as SVG text with captions.

use super::conditions;
use super::parts;
use super::problems::{joint, quartic, stiff};
use super::result::{Row, StudyResult};
use super::table::longest;
use pam_report::{LineFigure, Role, Scale};

/// SVG text and caption.
pub type Captioned = (String, String);

const SIZE: (u32, u32) = (520, 340);

/// Methods with a line of their own, in the order of their colours.
const METHODS: [&str; 10] = [
    "adjoint",
    "interpolating",
    "quadrature",
    "backsolve-free",
    "backsolve",
    "forward",
    "tape",
    "dual",
    "fd",
    BY_HAND,
];
/// The adjoint with the field differentiated by hand; all others are drawn by tape.
const BY_HAND: &str = "adjoint / hand";

/// The colour of a method, the same in all figures.
fn role(method: &str) -> Role {
    METHODS.iter().position(|m| *m == method).map_or(Role::Measured, Role::Category)
}

fn log_log(title: &str, x: &str, y: &str) -> LineFigure {
    LineFigure::new(title, x, y, SIZE.0, SIZE.1)
        .with_scales(Scale::Logarithmic, Scale::Logarithmic)
        .with_marks()
}

/// One line a method of the points that rows make, sorted by x.
fn by_method<'a>(
    mut figure: LineFigure,
    rows: impl Iterator<Item = &'a Row> + Clone,
    point: impl Fn(&Row) -> Option<(f64, f64)>,
) -> LineFigure {
    for method in METHODS {
        let is_method = |row: &Row| match row.differentiation.as_str() {
            "hand" => row.method_text() == method,
            "dual" => false,
            _ => row.method == method,
        };
        let rows = rows.clone().filter(|row| is_method(row) && row.failure.is_none());
        let mut points: Vec<(f64, f64)> = rows.filter_map(&point).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        if !points.is_empty() {
            figure = figure.with(method, role(method), points);
        }
    }
    figure
}

/// An error, how its axis is labelled and what it is called.
type Quantity = (fn(&Row) -> Option<f64>, &'static str, &'static str);

/// Error against work at constant steps.
#[must_use]
pub fn steps(result: &StudyResult) -> Vec<Captioned> {
    let of_x: Quantity = (|row| row.state_error, "largest error of x (mm)", "error of x");
    let of_gradient: Quantity =
        (|row| row.gradient_error, "relative error", "error of the gradient");
    let mut activations: Vec<&str> =
        result.part(parts::STEPS).filter_map(|row| row.activation.as_deref()).collect();
    activations.sort_unstable();
    activations.dedup();
    [(joint::NAME, of_x), (joint::NAME, of_gradient), (conditions::NAME, of_x)]
        .into_iter()
        .flat_map(|(problem, quantity)| activations.iter().map(move |a| (problem, *a, quantity)))
        .filter_map(|(problem, activation, quantity)| {
            let rows = result.part(parts::STEPS).filter(|row| {
                row.problem == problem && row.activation.as_deref() == Some(activation)
            });
            work_precision(&format!("{problem}, {activation}"), rows, quantity)
        })
        .collect()
}

/// One line a Runge–Kutta method; nothing if there are no rows.
fn work_precision<'a>(
    title: &str,
    rows: impl Iterator<Item = &'a Row> + Clone,
    (error, label, what): Quantity,
) -> Option<Captioned> {
    rows.clone().next()?;
    let mut figure = log_log(title, "evaluations of the field, forward solve", label);
    for (solver, colour) in [("rk4", 0), ("tsit5", 5), ("bs3", 2), ("dp5", 3)] {
        let of_solver = rows.clone().filter(|row| row.solver == solver);
        let points = of_solver.filter_map(|row| Some((row.evaluations as f64, error(row)?)));
        figure = figure.with(solver, Role::Category(colour), points.collect());
    }
    let caption = format!(
        "{title}: {what} against work, constant steps from {} to {} ms.",
        range(rows.clone(), f64::max),
        range(rows, f64::min)
    );
    Some((figure.to_svg(), caption))
}

/// The largest or smallest step of rows, ms.
fn range<'a>(rows: impl Iterator<Item = &'a Row>, choose: fn(f64, f64) -> f64) -> f64 {
    let step = rows.filter_map(|row| row.step_s).reduce(choose).unwrap_or(f64::NAN);
    (step * 1e6).round() / 1e3
}

/// Error of the gradient against time, tolerance by tolerance.
#[must_use]
pub fn precision(result: &StudyResult) -> Vec<Captioned> {
    let mut out = Vec::new();
    for (problem, activation) in [
        ("van-der-pol", None),
        (joint::NAME, Some("tanh")),
        (joint::NAME, Some("leaky_relu")),
        (stiff::NAME, None),
    ] {
        let horizon_s = longest(result, problem);
        let rows = result.part(parts::GRID).filter(|row| {
            row.problem == problem
                && row.activation.as_deref() == activation
                && row.horizon_s == horizon_s
                && row.rtol.is_some()
        });
        if rows.clone().next().is_none() {
            continue;
        }
        let title = activation.map_or(problem.to_owned(), |a| format!("{problem}, {a}"));
        let figure = log_log(&title, "time (s)", "error of the gradient");
        let figure = by_method(figure, rows, |row| Some((row.seconds?, row.gradient_error?)));
        let caption = format!(
            "{title}: error of the gradient against the truth and time, one point a tolerance, {horizon_s} s."
        );
        out.push((figure.to_svg(), caption));
    }
    out
}

/// Error against tolerance where gradients go wrong.
#[must_use]
pub fn traps(result: &StudyResult) -> Vec<Captioned> {
    let mut out = Vec::new();
    let rows = |problem: &'static str| {
        let horizon_s = longest(result, problem);
        result
            .part(parts::GRID)
            .filter(move |row| row.problem == problem && row.horizon_s == horizon_s)
    };
    let adjoint = || rows(quartic::NAME).filter(|row| row.method_text() == "adjoint / tape");
    if adjoint().next().is_some() {
        let points = |error: fn(&Row) -> Option<f64>| {
            adjoint().filter_map(|row| Some((row.rtol?, error(row)?))).collect::<Vec<_>>()
        };
        let figure = log_log("u̇ = (t − θ)⁴", "tolerance", "relative error")
            .with("state", Role::Category(0), points(|row| row.value_error))
            .with("gradient", Role::Category(5), points(|row| row.gradient_error));
        out.push((figure.to_svg(), "Error control on the state leaves the gradient worse.".into()));
    }
    let stiff: Vec<&Row> = rows(stiff::NAME).collect();
    if !stiff.is_empty() {
        let figure = log_log("stiff", "tolerance", "error of the gradient");
        let figure =
            by_method(figure, stiff.iter().copied(), |row| Some((row.rtol?, row.gradient_error?)));
        let failed: Vec<String> = stiff
            .iter()
            .filter(|row| row.failure.is_some() && row.differentiation == "tape")
            .map(|row| format!("{} at {}", row.method, row.steps_text()))
            .collect();
        let failed = if failed.is_empty() { "none".to_owned() } else { failed.join(", ") };
        out.push((figure.to_svg(), format!("Stiff problem. Failed, and not drawn: {failed}.")));
    }
    out
}

/// Errors, times and memory against the horizon.
#[must_use]
pub fn horizon(result: &StudyResult) -> Vec<Captioned> {
    let rows = result.part(parts::HORIZON);
    let errors = log_log("Error against the truth", "horizon (s)", "error of the gradient");
    let continuous = rows.clone().filter(|row| {
        ["adjoint", "interpolating", "quadrature", "backsolve", "backsolve-free"]
            .contains(&row.method.as_str())
    });
    let errors = by_method(errors, continuous, |row| Some((row.horizon_s, row.gradient_error?)));
    let failed: Vec<String> = rows
        .clone()
        .filter(|row| row.failure.is_some() && row.differentiation == "tape")
        .map(|row| format!("{} at {} s", row.method, row.horizon_s))
        .collect();
    let mut caption = "Error growth at a fixed tolerance.".to_owned();
    if !failed.is_empty() {
        caption += &format!(" Failed, and not drawn: {}.", failed.join(", "));
    }
    let (times, memory) = costs(rows, "horizon (s)", |row| row.horizon_s);
    vec![
        (errors.to_svg(), caption),
        (times, "Time for value and gradient.".into()),
        (memory, "Largest memory allocated at a time.".into()),
    ]
}

/// Times and memory against the number of parameters.
#[must_use]
pub fn parameters(result: &StudyResult) -> Vec<Captioned> {
    let (times, memory) =
        costs(result.part(parts::PARAMETERS), "parameters", |row| row.parameters as f64);
    vec![
        (times, "Time for value and gradient.".into()),
        (memory, "Largest memory allocated at a time.".into()),
    ]
}

fn costs<'a>(
    rows: impl Iterator<Item = &'a Row> + Clone,
    label: &str,
    x: impl Fn(&Row) -> f64,
) -> (String, String) {
    let times = by_method(log_log("Time", label, "time (s)"), rows.clone(), |row| {
        Some((x(row), row.seconds?))
    });
    let memory = by_method(log_log("Memory", label, "memory (MB)"), rows, |row| {
        Some((x(row), row.memory_bytes() as f64 / 1e6))
    });
    (times.to_svg(), memory.to_svg())
}
