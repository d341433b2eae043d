//! Terms that may be missing from a field.

use pam_effects::effects::ParameterInfo;

/// A possible cause: a term of the field that some of its parameters switch on.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Its name.
    pub name: String,
    /// Its parameters: index in the field, and name with unit, range, the value at which the term is absent.
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
