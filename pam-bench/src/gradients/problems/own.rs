//! A field of your own, from a file of expressions.

use super::small::{Rates, SmallField};
use crate::gradients::case::{Case, evenly};
use pam_data::{DataError, toml_file};
use pam_expression::{Graph, Program, too_long};
use pam_solvers::NoInput;
use pam_vocabulary::expression::{Expression, Scope};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

/// Name of the problem.
pub const NAME: &str = "own";

/// Content of the file.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Definition {
    /// The solve runs from 0 to here, s.
    end_s: f64,
    /// Number of evenly spaced observations, the last one at the end.
    observations: usize,
    /// Initial state.
    start: BTreeMap<String, f64>,
    #[serde(default)]
    parameters: BTreeMap<String, f64>,
    /// The time derivative of each state.
    rates: BTreeMap<String, String>,
}

/// The problem of a TOML file: `end_s`, `observations`, and the tables `start`, `parameters` and `rates`, the last with an
/// expression of states, parameters and `t` for each state. The loss is half the mean square of the states.
///
/// ```
/// use pam_bench::gradients::problems::own;
///
/// let text = "end_s = 1.0\nobservations = 4\nstart = { x = 2.0 }\nparameters = { k = 3.0 }\nrates = { x = '-k * x' }";
/// let case = own::parse(text, "decay.toml")?;
/// assert_eq!(case.observations_s, [0.25, 0.5, 0.75, 1.0]);
/// # Ok::<(), pam_data::DataError>(())
/// ```
///
/// # Errors
/// [`DataError`] with the line, or with the state whose expression cannot be read.
pub fn parse(
    text: &str,
    path: impl AsRef<Path>,
) -> Result<Case<SmallField<f64>, NoInput>, DataError> {
    let path = path.as_ref();
    let definition: Definition = toml_file::parse(text, path)?;
    let wrong = |message: String| DataError::file(path, message);
    let Definition { end_s, observations, start, parameters, rates } = definition;
    if !(end_s > 0.0 && end_s.is_finite()) || observations == 0 {
        return Err(wrong("`end_s` and `observations` must be positive".into()));
    }
    if start.is_empty() || !start.keys().eq(rates.keys()) {
        return Err(wrong("`start` and `rates` must name the same states, one at least".into()));
    }
    let t = "t".to_owned();
    let names: Vec<String> =
        start.keys().chain([&t]).chain(parameters.keys()).map(String::clone).collect();
    if let Some(twice) = names.iter().enumerate().find(|(k, name)| names[..*k].contains(name)) {
        return Err(wrong(format!("`{}` is named twice (`t` is the time)", twice.1)));
    }
    let mut graph = Graph::default();
    let mut outputs = Vec::new();
    for (state, rate) in &rates {
        let tree = Expression::parse(rate, &Scope::of(&names))
            .map_err(|e| wrong(format!("the rate of `{state}`: {e}")))?;
        outputs.push(graph.expression(&tree, &mut |graph, k| graph.input(k)));
    }
    let rates = Program::new(&graph, &outputs).ok_or_else(|| wrong(too_long()))?;
    let states = start.len();
    let parameters: Vec<f64> = parameters.into_values().collect();
    let field = SmallField::new(Rates::Expressions(Arc::new(rates)), states, parameters);
    let y0: Vec<f64> = start.into_values().collect();
    let loss = move |times: &[f64], states: &[f64], cotangents: &mut [f64]| {
        let share = 1.0 / times.len() as f64;
        for (y, w) in states.iter().zip(cotangents) {
            *w = share * y;
        }
        0.5 * share * states.iter().map(|y| y * y).sum::<f64>()
    };
    Ok(Case::new(NAME, (field, NoInput), &y0, evenly(observations, end_s), loss))
}

/// The problem of the TOML file at `path`.
///
/// # Errors
/// As [`parse`], or if the file cannot be read.
pub fn read(path: impl AsRef<Path>) -> Result<Case<SmallField<f64>, NoInput>, DataError> {
    let path = path.as_ref();
    parse(&toml_file::text(path)?, path)
}
