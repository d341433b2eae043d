//! The description of an effect: id, group, parameters, switches.

/// The part of the joint that an effect belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Group {
    /// Forces and inertia of the joint.
    Mechanics,
    /// The air in the muscles.
    Gas,
    /// Between command and force, or between joint and recording.
    Sensing,
}

impl Group {
    /// The name of the group in text.
    #[must_use]
    pub const fn label(self) -> &'static str {
        match self {
            Self::Mechanics => "mechanics",
            Self::Gas => "gas",
            Self::Sensing => "actuation and sensing",
        }
    }
}

/// A parameter of an effect: a number that is hidden, fitted or trained.
///
/// ```
/// use pam_vocabulary::ParameterInfo;
///
/// let force = ParameterInfo::linear("force_n", [0.0, 300.0]); // absent at zero
/// assert_eq!(force.off, Some(0.0));
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterInfo {
    /// Name, with its unit as suffix: `force_n`, `velocity_mm_s`.
    pub name: &'static str,
    /// One line: meaning and sign convention. May be empty for effects outside the vocabulary.
    pub meaning: &'static str,
    /// Smallest and largest physical value. A fit that ends at a limit refutes the effect.
    pub range: [f64; 2],
    /// `true` for a positive scale (a length, a time, a cutoff) that is fitted by its logarithm.
    pub logarithmic: bool,
    /// The value at which the parameter contributes nothing, `None` for a scale. The effect is absent where
    /// all of its parameters that have such a value take it.
    pub off: Option<f64>,
    /// Index of another parameter of the effect that is a lower bound of this one in a fit.
    pub not_below: Option<usize>,
}

impl ParameterInfo {
    /// A parameter that is fitted as it is and contributes nothing at zero.
    #[must_use]
    pub const fn linear(name: &'static str, range: [f64; 2]) -> Self {
        Self { name, meaning: "", range, logarithmic: false, off: Some(0.0), not_below: None }
    }

    /// A positive scale that is fitted by its logarithm.
    #[must_use]
    pub const fn scale(name: &'static str, range: [f64; 2]) -> Self {
        Self { name, meaning: "", range, logarithmic: true, off: None, not_below: None }
    }

    /// Sets the value at which the parameter contributes nothing.
    #[must_use]
    pub const fn off_at(self, off: Option<f64>) -> Self {
        Self { off, ..self }
    }

    /// Sets the parameter of the same effect, by its index, that is a lower bound of this one.
    #[must_use]
    pub const fn not_below(self, parameter: usize) -> Self {
        Self { not_below: Some(parameter), ..self }
    }

    /// Sets the meaning.
    #[must_use]
    pub const fn meaning(self, meaning: &'static str) -> Self {
        Self { meaning, ..self }
    }

    /// `true` for a value inside the range; NaN is outside.
    #[must_use]
    pub fn admits(&self, value: f64) -> bool {
        (self.range[0]..=self.range[1]).contains(&value)
    }
}

/// A number that selects a variant of an effect. It is tried, not fitted; absent switches are zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Switch {
    /// Name.
    pub name: &'static str,
    /// The variants.
    pub meaning: &'static str,
}

/// An effect as the vocabulary, or a user outside it, describes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectInfo {
    /// Id in files, reports and on the command line; never changes once released.
    pub id: &'static str,
    /// Plain name for headings and sentences; the words of the id where it is empty.
    pub name: &'static str,
    /// Group.
    pub group: Group,
    /// One line: a noun phrase that fits into a sentence.
    pub description: &'static str,
    /// Parameters.
    pub parameters: &'static [ParameterInfo],
    /// Switches.
    pub switches: &'static [Switch],
    /// The excitation under which the effect shows best.
    pub excited_by: &'static str,
}

impl EffectInfo {
    /// An effect without switches.
    #[must_use]
    pub const fn new(
        id: &'static str,
        group: Group,
        description: &'static str,
        parameters: &'static [ParameterInfo],
    ) -> Self {
        Self { id, name: "", group, description, parameters, switches: &[], excited_by: "" }
    }

    /// The plain name: "dry friction" for `coulomb_friction`.
    #[must_use]
    pub fn plain_name(&self) -> String {
        if self.name.is_empty() { self.id.replace('_', " ") } else { self.name.to_owned() }
    }

    /// Sets the plain name.
    #[must_use]
    pub const fn named(self, name: &'static str) -> Self {
        Self { name, ..self }
    }

    /// Sets the excitation under which the effect shows best.
    #[must_use]
    pub const fn excited_by(self, excited_by: &'static str) -> Self {
        Self { excited_by, ..self }
    }

    /// Number of values that describe the effect: parameters, then switches.
    #[must_use]
    pub const fn value_len(&self) -> usize {
        self.parameters.len() + self.switches.len()
    }

    /// Names of the values: parameters, then switches.
    pub fn value_names(&self) -> impl Iterator<Item = &'static str> + use<> {
        let parameters = self.parameters.iter().map(|p| p.name);
        parameters.chain(self.switches.iter().map(|s| s.name))
    }
}
