//! Factors along a variable, such as the displacement: where it turned, and what repeats.

use super::function::Function;
use super::space::{Place, Variable};
use super::term::{Factor, Lag};

/// Pitches of sines and cosines, relative to the variable's typical size. Neighbours differ by a sixth, so that the phase of a pitch
/// between them is followed up to the ends of the range.
const PITCHES: [f64; 9] = [0.25, 0.29, 0.34, 0.4, 0.47, 0.55, 0.65, 0.77, 0.9];

/// Slip elements of `widths` (relative to the typical size), sines and cosines of each variable of a place whose change over a step is
/// known: alone, and times each of `companions`.
pub(crate) fn repeating(
    place: &Place,
    variables: &[Variable],
    widths: &[f64],
    companions: &[Factor],
) -> Vec<Vec<Factor>> {
    let mut all = Vec::new();
    for &k in place.variables.iter().filter(|k| variables[**k].change.is_some()) {
        let size = variables[k].size;
        let slip = |width: &f64| Factor {
            lag: Some(Lag::Slip { width: width * size }),
            ..Factor::of(k, Function::Linear, 1.0)
        };
        for factor in widths.iter().map(slip).chain(waves_along(k, variables)) {
            all.push(vec![factor]);
            all.extend(companions.iter().map(|c| vec![factor, *c]));
        }
    }
    all
}

/// Sines and cosines of a variable.
pub(crate) fn waves_along(variable: usize, variables: &[Variable]) -> Vec<Factor> {
    let size = variables[variable].size;
    let of = |pitch: f64| {
        [Function::Sine, Function::Cosine].map(|f| Factor::of(variable, f, pitch * size))
    };
    PITCHES.into_iter().flat_map(of).collect()
}
