//! Factors that fade while a pressure rests.

use super::space::{Place, Variable};
use super::term::Factor;

/// What low-passes with some time constants leave of the pressures at a place where air flows or a force acts.
pub(crate) fn relaxing(place: &Place, variables: &[Variable], times_s: &[f64]) -> Vec<Vec<Factor>> {
    if place.remembers && !place.rich {
        return Vec::new();
    }
    let known = place.variables.iter().filter(|k| variables[**k].relaxes());
    known.flat_map(|&k| times_s.iter().map(move |&t| vec![Factor::high_pass(k, t)])).collect()
}
