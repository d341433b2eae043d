//! What may be missing from a field.

use crate::search::Acceptance;
use pam_effects::effects::ParameterInfo;

/// A possible cause: a term of the field that some of its parameters switch on.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Its name.
    pub name: String,
    /// Its parameters: index in the field, name with unit, range, the value at which the term is absent.
    pub parameters: Vec<(usize, ParameterInfo)>,
    /// Values from which a fit starts, in the order of `parameters`; the derivative by an amplitude must not
    /// vanish there. Scales (widths, periods, times) are spread over a grid.
    pub starts: Vec<Vec<f64>>,
}

impl Candidate {
    /// A term with one parameter and its starting values.
    #[must_use]
    pub fn one(name: &str, index: usize, info: ParameterInfo, starts: &[f64]) -> Self {
        Self {
            name: name.to_owned(),
            parameters: vec![(index, info)],
            starts: starts.iter().map(|&s| vec![s]).collect(),
        }
    }

    /// Writes the values at which the term is absent into the field's parameters; scales keep theirs.
    pub(super) fn switch_off(&self, parameters: &mut [f64]) {
        for (index, info) in &self.parameters {
            if let Some(off) = info.off {
                parameters[*index] = off;
            }
        }
    }
}

/// How a field is diagnosed.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldOptions {
    /// Causes at most.
    pub most_causes: usize,
    /// When a cause earns its place.
    pub acceptance: Acceptance,
    /// Share of each experiment, its end, that judges and is not fitted.
    pub held_share: f64,
    /// Parameters of the field (by index) that are fitted along with every hypothesis, since they are not
    /// known well: a mass, a stiffness. Without them, a cause may be named for a slightly wrong number.
    pub refitted: Vec<usize>,
    /// Steps of each fit.
    pub iterations: usize,
}

impl Default for FieldOptions {
    fn default() -> Self {
        Self {
            most_causes: 3,
            acceptance: Acceptance::default(),
            held_share: 1.0 / 3.0,
            refitted: Vec::new(),
            iterations: 15,
        }
    }
}
