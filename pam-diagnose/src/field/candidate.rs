//! Terms that may be missing from a field, and the options of its diagnosis.

use crate::settings::DiagnosisSettings;
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

/// Options of [`diagnose_field`](super::diagnose_field).
#[derive(Debug, Clone, PartialEq)]
pub struct FieldOptions {
    /// Parameters of the field (by index) that are fitted along with every hypothesis, since they are not
    /// known well: a mass, a stiffness. Without them, a cause may be named for a slightly wrong parameter.
    pub refitted: Vec<usize>,
    /// Prior standard deviation of each initial state; zero for one that is known exactly. If absent, measured states
    /// have that of their noise and the others are known.
    pub initial_state_deviation: Option<Vec<f64>>,
    /// Number of experiments that form the test set: the last ones before those of the baseline. With 0, a part of the
    /// data is held out.
    pub test: usize,
    /// Number of experiments, the last ones of the problem, on which the field was validated: their error is its
    /// baseline discrepancy.
    pub baseline: usize,
    /// Seed of the split, the null test and the bootstrap.
    pub seed: u64,
    /// Every other number on which the diagnosis depends.
    pub settings: DiagnosisSettings,
}

impl Default for FieldOptions {
    fn default() -> Self {
        let (refitted, initial_state_deviation) = (Vec::new(), None);
        let settings = DiagnosisSettings::default();
        Self { refitted, initial_state_deviation, test: 0, baseline: 0, seed: 1, settings }
    }
}
