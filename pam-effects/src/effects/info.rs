//! What is known of an effect before any data: its id, its parameters, what they may be.

/// Which part of the joint an effect belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Group {
    /// Forces and inertia of the joint.
    Mechanics,
    /// The air in the muscles.
    Gas,
    /// Between command and force, or between joint and record.
    Sensing,
}

/// One learnable number of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterInfo {
    /// Name with the unit in it.
    pub name: &'static str,
    /// Values that are physically possible. A fit that ends at a limit refutes the effect.
    pub range: [f64; 2],
    /// Whether the parameter is a scale that is fitted by its logarithm.
    pub logarithmic: bool,
    /// The value at which the effect is absent, if this parameter alone can switch it off.
    pub off: Option<f64>,
}

impl ParameterInfo {
    /// A parameter that is fitted as it is and whose effect is absent at zero.
    #[must_use]
    pub const fn linear(name: &'static str, range: [f64; 2]) -> Self {
        Self { name, range, logarithmic: false, off: Some(0.0) }
    }

    /// The same parameter with another value at which the effect is absent, or none.
    #[must_use]
    pub const fn off_at(self, off: Option<f64>) -> Self {
        Self { off, ..self }
    }

    /// A positive scale (a length, a time, a cutoff) that is fitted by its logarithm.
    #[must_use]
    pub const fn scale(name: &'static str, range: [f64; 2]) -> Self {
        Self { name, range, logarithmic: true, off: None }
    }
}

/// An effect's place in the vocabulary.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EffectInfo {
    /// Id of `effects.md`; never changes.
    pub id: &'static str,
    /// Where it lives.
    pub group: Group,
    /// What it is, in a few words that fit into a sentence.
    pub what: &'static str,
    /// Its learnable numbers.
    pub parameters: &'static [ParameterInfo],
    /// Fixed switches behind the parameters: variants of the effect that are tried beside each other
    /// and are not fitted.
    pub switches: &'static [&'static str],
    /// Whether it changes the gas law of the chambers.
    pub air: bool,
    /// Which excitation brings it out, for designs and for sentences.
    pub excited_by: &'static str,
}

impl EffectInfo {
    /// Number of values that describe the effect: parameters and switches.
    #[must_use]
    pub fn value_len(&self) -> usize {
        self.parameters.len() + self.switches.len()
    }
}
