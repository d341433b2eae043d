//! Terms and laws as text.

use crate::fit::Interval;
use crate::terms::{Factor, Lag, Term, TermSpace, as_quotient};
use crate::test_set::ErrorReduction;
use pam_core::units::significant;

/// Comments of a law's file: intervals and what it gains.
pub(super) fn header(
    parameters: &[(String, Interval)],
    share: f64,
    gain: &ErrorReduction,
) -> String {
    let n = |v: f64| significant(v, 4);
    let mut out = format!(
        "# It removes {:.0} % of the error of the test set [{:.0}, {:.0}], {:.0} % of what a smooth correction removes.\n",
        100.0 * gain.overall.error_reduction,
        100.0 * gain.overall.ci95[0],
        100.0 * gain.overall.ci95[1],
        100.0 * share
    );
    for (name, i) in parameters {
        let [low, high] = i.ci95;
        out += &format!("# {name} = {} [{}, {}]\n", n(i.value), n(low), n(high));
    }
    out
}

/// Names of the places of terms.
pub(super) fn acts(terms: &[Term], space: &dyn TermSpace) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for t in terms {
        let name = &space.places()[t.place].name;
        if !all.contains(name) {
            all.push(name.clone());
        }
    }
    all
}

/// The terms with the largest coefficients.
pub(super) fn largest(terms: &[Term], space: &dyn TermSpace) -> Vec<(String, f64)> {
    let (variables, places) = (space.variables(), space.places());
    let mut all: Vec<(String, f64)> = terms
        .iter()
        .map(|t| {
            let place = &places[t.place];
            let size = t.coefficient * t.size(variables) / place.size;
            (format!("{}: {}", place.id, product(t, space)), size)
        })
        .collect();
    all.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    all
}

/// The factors of a term as an expression.
fn product(term: &Term, space: &dyn TermSpace) -> String {
    let variables = space.variables();
    let of = |f: &Factor| {
        let text = &variables[f.variable].text;
        let argument = match f.lag {
            None => text.clone(),
            Some(Lag::LowPass { of, time_s }) => {
                format!("low_pass({}, {} s)", of.text(text, ""), significant(time_s, 3))
            }
            Some(Lag::HighPass { time_s }) => {
                format!("high_pass({text}, {} s)", significant(time_s, 3))
            }
            Some(Lag::Slip { width }) => format!("slip({text} / {})", significant(width, 3)),
        };
        f.function.text(&argument, &significant(f.scale, 3))
    };
    let parts: Vec<String> = term.factors.iter().map(of).collect();
    if parts.is_empty() { "1".to_owned() } else { parts.join(" * ") }
}

/// A law with its numbers.
pub(super) fn written(terms: &[Term], space: &dyn TermSpace) -> String {
    let one = |t: &Term| {
        let (c, product) = (significant(t.coefficient, 4), product(t, space));
        let text = as_quotient(&format!("{c} * {product}"));
        format!("{}: {text}", space.places()[t.place].id)
    };
    terms.iter().map(one).collect::<Vec<_>>().join("; ")
}

/// The variables of the system that terms use.
pub(super) fn variable_names(terms: &[Term], space: &dyn TermSpace) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for k in terms.iter().flat_map(Term::variables) {
        for name in &space.variables()[k].names {
            if !all.contains(name) {
                all.push(name.clone());
            }
        }
    }
    all
}
