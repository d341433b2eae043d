//! Findings of a study, in sentences. A study without the rows in question says nothing.

use super::conditions;
use super::method::Kind;
use super::parts::{self, FIVE_MS};
use super::problems::{joint, quartic, stiff};
use super::result::{Row, StudyResult};
use super::table::{bytes_text, error_text, longest, seconds_text, shown};

/// All findings, in the order of the report.
#[must_use]
pub fn findings(result: &StudyResult) -> Vec<String> {
    [exactness, order, kinks, stiffness, trap, horizon, parameters, batched, checkpoints]
        .into_iter()
        .flat_map(|of| of(result))
        .collect()
}

fn largest<'a>(
    rows: impl Iterator<Item = &'a Row>,
    error: fn(&Row) -> Option<f64>,
) -> Option<(f64, &'a Row)> {
    rows.filter_map(|row| Some((error(row)?, row))).max_by(|a, b| a.0.total_cmp(&b.0))
}

/// How well the exact methods agree on the frozen steps.
#[must_use]
pub fn exactness(result: &StudyResult) -> Vec<String> {
    let exact =
        || result.rows.iter().filter(|row| row.kind == Kind::Exact && row.replay_error.is_some());
    let replay: fn(&Row) -> Option<f64> = |row| row.replay_error;
    let Some((error, row)) = largest(exact(), replay) else { return Vec::new() };
    let mut out = vec![format!(
        "All {} gradients of exact methods agree with dual numbers through the frozen steps to \
         {error:.0e} or better (worst: {} on {}).",
        exact().count(),
        row.method_text(),
        row.problem_text()
    )];
    let differences = result.rows.iter().filter(|row| row.kind == Kind::Difference);
    if let Some((error, row)) = largest(differences, replay) {
        out[0] +=
            &format!(" Central differences reach {error:.0e} at worst, on {}.", row.problem_text());
    }
    out
}

/// The rows of constant steps of a problem and an activation.
fn of_steps<'a>(
    result: &'a StudyResult,
    (problem, activation): (&'a str, &'a str),
    solver: &'a str,
) -> impl Iterator<Item = &'a Row> {
    result.part(parts::STEPS).filter(move |row| {
        row.problem == problem
            && row.activation.as_deref() == Some(activation)
            && row.solver == solver
    })
}

/// Exponent of the step in the error of x between the largest and the smallest step above rounding.
#[must_use]
pub fn observed_order(result: &StudyResult, case: (&str, &str), solver: &str) -> Option<f64> {
    let points: Vec<(f64, f64)> = of_steps(result, case, solver)
        .filter_map(|row| Some((row.step_s?, row.state_error?)))
        .filter(|(_, error)| *error > 1e-11)
        .collect();
    let (first, last) = (points.first()?, points.last()?);
    (points.len() > 1).then(|| (first.1 / last.1).ln() / (first.0 / last.0).ln())
}

/// Runge–Kutta methods at 5 ms, kinked and smooth.
#[must_use]
pub fn order(result: &StudyResult) -> Vec<String> {
    let mut trained: Vec<&str> = result
        .part(parts::STEPS)
        .filter(|row| row.problem == conditions::NAME)
        .filter_map(|row| row.activation.as_deref())
        .collect();
    trained.dedup();
    let made_up =
        ["leaky_relu", "tanh"].map(|a| (joint::NAME, a, format!("With {a} (made-up network)")));
    let trained = trained.into_iter().map(|a| {
        (conditions::NAME, a, format!("With the given network ({a}), over all training conditions"))
    });
    made_up
        .into_iter()
        .chain(trained)
        .filter_map(|(problem, activation, with)| {
            of_two_solvers(result, (problem, activation)).map(|text| format!("{with}, {text}"))
        })
        .collect()
}

/// RK4 and Tsit5 at 5 ms.
fn of_two_solvers(result: &StudyResult, case: (&str, &str)) -> Option<String> {
    let [rk4, tsit5] = ["rk4", "tsit5"].map(|solver| {
        of_steps(result, case, solver)
            .find(|row| row.step_s.is_some_and(|h| (h / FIVE_MS - 1.0).abs() < 1e-9))
    });
    let (rk4, tsit5) = (rk4?, tsit5?);
    let (a, b) = (rk4.state_error?, tsit5.state_error?);
    let (better, ratio) = if a < b { ("RK4", b / a) } else { ("Tsit5", a / b) };
    let verdict = if ratio < 1.2 {
        "the two are alike".to_owned()
    } else {
        format!("{better} is {} times more accurate", significant(ratio))
    };
    let mut text = format!(
        "RK4 at 5 ms errs by {a:.1e} mm in x with {} evaluations, Tsit5 at 5 ms by {b:.1e} mm with {}: \
         {verdict}",
        rk4.evaluations, tsit5.evaluations
    );
    if let (Some(a), Some(b)) = (rk4.gradient_error, tsit5.gradient_error) {
        text += &format!("; their gradients are off by {a:.0e} and {b:.0e}");
    }
    let orders = ["rk4", "tsit5"].map(|solver| observed_order(result, case, solver));
    if let [Some(rk4), Some(tsit5)] = orders {
        text += &format!(
            ". Over all steps the error of x falls with the power {rk4:.1} of the step for RK4 and \
             {tsit5:.1} for Tsit5"
        );
    }
    Some(text + ".")
}

/// The gradient of steps over kinks, against adjoints that choose steps of their own.
#[must_use]
pub fn kinks(result: &StudyResult) -> Vec<String> {
    let error = |activation: &str, method: &str| {
        shown(result)
            .find(|row| {
                row.activation.as_deref() == Some(activation) && row.method_text() == method
            })
            .and_then(|row| Some((row.gradient_error?, row)))
    };
    let texts: Vec<String> = ["leaky_relu", "tanh"]
        .into_iter()
        .filter_map(|activation| {
            let (exact, row) = error(activation, "adjoint / tape")?;
            let (continuous, _) = error(activation, "interpolating / tape")?;
            Some(format!("{activation} at {}: {exact:.0e} and {continuous:.0e}", row.steps_text()))
        })
        .collect();
    if texts.is_empty() {
        return Vec::new();
    }
    vec![format!(
        "Where a step crosses a kink the derivative of the step is off by its length, though the state is \
         as accurate as asked: the exact gradient of the steps taken is then far from the truth, and an \
         adjoint that chooses its own steps is closer. Distances from the truth, discrete and interpolating \
         adjoint of the joint: {}.",
        texts.join("; ")
    )]
}

/// Error of the state that is integrated backwards.
#[must_use]
pub fn stiffness(result: &StudyResult) -> Vec<String> {
    let rows = |method: &'static str| {
        let problem = longest(result, stiff::NAME);
        result.part(parts::GRID).filter(move |row| {
            row.problem == stiff::NAME && row.method == method && row.horizon_s == problem
        })
    };
    let (of, wrong, failed) = ["backsolve", "backsolve-free"].into_iter().flat_map(rows).fold(
        (0, 0, 0),
        |(of, wrong, failed), row| {
            let lost = row.gradient_error.is_some_and(|e| e > 0.1);
            (of + 1, wrong + usize::from(lost), failed + usize::from(row.failure.is_some()))
        },
    );
    let right = largest(rows("adjoint"), |row| row.gradient_error);
    match right {
        Some((error, _)) if of > 0 => vec![format!(
            "On the stiff problem the backsolve adjoint fails in {failed} of {of} runs{}; the discrete \
             adjoint is off by {error:.0e} at most.",
            if wrong > 0 {
                format!(" and is wrong by more than 10 % in {wrong}")
            } else {
                String::new()
            }
        )],
        _ => Vec::new(),
    }
}

/// `u̇ = (t − θ)⁴`.
#[must_use]
pub fn trap(result: &StudyResult) -> Vec<String> {
    let rows = result.part(parts::GRID).filter(|row| {
        row.problem == quartic::NAME
            && row.method_text() == "adjoint / tape"
            && row.horizon_s == longest(result, quartic::NAME)
    });
    let texts: Vec<String> = rows
        .filter_map(|row| {
            let (value, gradient) = (row.value_error?, row.gradient_error?);
            Some(format!(
                "{:.0} times at {} ({value:.0e} and {gradient:.0e})",
                gradient / value,
                row.steps_text()
            ))
        })
        .collect();
    if texts.is_empty() {
        return Vec::new();
    }
    vec![format!(
        "On u̇ = (t − θ)⁴ the exact gradient of the steps taken has a larger relative error than the state \
         whose error chose the steps: {}.",
        texts.join(", ")
    )]
}

/// Growth of the errors of continuous adjoints.
#[must_use]
pub fn horizon(result: &StudyResult) -> Vec<String> {
    let end = |method: &str, last: bool| {
        let mut rows =
            result.part(parts::HORIZON).filter(move |row| row.method == method).collect::<Vec<_>>();
        rows.sort_by(|a, b| a.horizon_s.total_cmp(&b.horizon_s));
        if last { rows.last().copied() } else { rows.first().copied() }
    };
    let text = |row: &Row| match &row.failure {
        Some(_) => "fails".to_owned(),
        None => error_text(row.gradient_error),
    };
    let mut parts = Vec::new();
    for method in ["adjoint", "interpolating", "quadrature", "backsolve", "backsolve-free"] {
        if let (Some(first), Some(last)) = (end(method, false), end(method, true))
            && first.horizon_s < last.horizon_s
        {
            let name = match method {
                "backsolve" => "backsolve with the state set at observations",
                "backsolve-free" => "backsolve without",
                other => other,
            };
            parts.push((first, last, format!("{name} {} → {}", text(first), text(last))));
        }
    }
    let Some((first, last, _)) = parts.first() else { return Vec::new() };
    vec![format!(
        "At a fixed tolerance of {}, from {} s to {} s, the error of the gradient against the truth goes: {}.",
        first.steps_text(),
        first.horizon_s,
        last.horizon_s,
        parts.iter().map(|p| p.2.as_str()).collect::<Vec<_>>().join(", ")
    )]
}

/// Cost at the largest network.
#[must_use]
pub fn parameters(result: &StudyResult) -> Vec<String> {
    let most = result.part(parts::PARAMETERS).map(|row| row.parameters).max().unwrap_or(0);
    let at = |method: &str| {
        result
            .part(parts::PARAMETERS)
            .find(|row| row.parameters == most && row.method_text() == method)
            .and_then(|row| Some((row.seconds?, row.memory_bytes())))
    };
    let reference = ["adjoint / hand", "adjoint / tape"]
        .into_iter()
        .find_map(|method| Some((method, at(method)?)));
    let Some((name, (adjoint, bytes))) = reference else { return Vec::new() };
    let others: Vec<String> =
        ["adjoint / tape", "interpolating / hand", "tape", "dual", "fd", "forward / hand"]
            .into_iter()
            .filter(|method| *method != name)
            .filter_map(|method| {
                let (seconds, _) = at(method)?;
                Some(format!("{method} {}", significant(seconds / adjoint)))
            })
            .collect();
    if others.is_empty() {
        return Vec::new();
    }
    let tape = at("tape").map_or(String::new(), |(_, tape)| {
        format!(
            " The tape through the solver needs {} of memory, this adjoint {}.",
            bytes_text(tape),
            bytes_text(bytes)
        )
    });
    vec![format!(
        "With {most} parameters {name} takes {}. As multiples of it: {}.{tape}",
        seconds_text(Some(adjoint)),
        others.join(", ")
    )]
}

/// Batched trajectories against one adjoint after the other.
#[must_use]
pub fn batched(result: &StudyResult) -> Vec<String> {
    let rows = || result.part(parts::BATCHED);
    let width = rows().filter_map(|row| row.width).max();
    let most = rows().map(|row| row.trajectories).max().unwrap_or(0);
    let at = |differentiation: &str| {
        rows()
            .find(|row| {
                row.width == width
                    && row.trajectories == most
                    && row.differentiation == differentiation
            })
            .and_then(|row| Some((row.seconds?, row.replay_error?)))
    };
    match (at("tape"), at("f64"), at("f32")) {
        (Some((one, _)), Some((double, _)), Some((single, error))) => vec![format!(
            "A batch takes the gradient of {most} trajectories of a network of width {} {} times faster than \
             one adjoint after the other in double precision, {} times in single precision with an error \
             of {error:.0e}, on one thread.",
            width.unwrap_or(0),
            significant(one / double),
            significant(one / single)
        )],
        _ => Vec::new(),
    }
}

/// Time for memory.
#[must_use]
pub fn checkpoints(result: &StudyResult) -> Vec<String> {
    let rows: Vec<&Row> = result.part(parts::CHECKPOINTS).filter(|r| r.failure.is_none()).collect();
    let all = rows.iter().find(|row| row.method.contains("all-save"));
    let least = rows.iter().min_by_key(|row| row.checkpoint_bytes);
    let (Some(all), Some(least)) = (all, least) else { return Vec::new() };
    let (Some(a), Some(b)) = (all.seconds, least.seconds) else { return Vec::new() };
    if all.method == least.method {
        return Vec::new();
    }
    vec![format!(
        "Over {} steps, {} stores {} in place of {} and takes {:.1} times as long.",
        all.steps,
        least.method.trim_start_matches("adjoint, "),
        bytes_text(least.checkpoint_bytes),
        bytes_text(all.checkpoint_bytes),
        b / a
    )]
}

/// A ratio with two digits.
fn significant(ratio: f64) -> String {
    if ratio < 10.0 { format!("{ratio:.1}") } else { format!("{ratio:.0}") }
}
