//! Terms that may be missing from a field.

use pam_expression::WithTerms;
use pam_vocabulary::ParameterInfo;

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
    /// The candidate of which it is a property, as the asymmetry of a friction is one of the friction: where both are named,
    /// it follows behind.
    pub property_of: Option<String>,
}

impl Candidate {
    /// A term with one parameter and its starting values.
    #[must_use]
    pub fn one(name: &str, index: usize, info: ParameterInfo, starts: &[f64]) -> Self {
        Self {
            name: name.to_owned(),
            parameters: vec![(index, info)],
            starts: starts.iter().map(|&s| vec![s]).collect(),
            property_of: None,
        }
    }

    /// The same as a property of another candidate.
    #[must_use]
    pub fn of(self, other: &str) -> Self {
        Self { property_of: Some(other.to_owned()), ..self }
    }

    /// A term with one parameter that is fitted as it is, is absent at zero and stays inside `range`.
    ///
    /// ```
    /// use pam_diagnose::field::Candidate;
    /// // Parameter 2 of the field, called `coulomb_n`, from 0 to 100 N, fitted from 1 and from 5 N on.
    /// let friction = Candidate::term("dry_friction", (2, "coulomb_n"), [0.0, 100.0], &[1.0, 5.0]);
    /// assert_eq!(friction.parameters[0].1.off, Some(0.0));
    /// ```
    #[must_use]
    pub fn term(
        name: &str,
        (index, parameter): (usize, &'static str),
        range: [f64; 2],
        starts: &[f64],
    ) -> Self {
        Self::one(name, index, ParameterInfo::linear(parameter, range), starts)
    }

    /// The terms of a field that were added to it [as expressions](pam_expression::Terms).
    #[must_use]
    pub fn of_terms<F>(field: &WithTerms<F>) -> Vec<Self> {
        let candidate = |(first, term): (usize, &pam_expression::Term)| Self {
            name: term.name.clone(),
            parameters: (first..).zip(term.parameters.iter().copied()).collect(),
            starts: term.starts.clone(),
            property_of: None,
        };
        field.terms().map(candidate).collect()
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
