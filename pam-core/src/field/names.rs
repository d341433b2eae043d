/// Names of what a field has, with the unit as suffix: `position_mm`, `voltage_v`.
///
/// A list may be shorter than what it names, or empty; the rest is called `state_1`, `input_0` and so on.
///
/// ```
/// use pam_core::FieldNames;
///
/// let names = FieldNames::new(&["position_mm", "speed_mm_s"], &["voltage_v"], &[], &["gain"]);
/// assert_eq!(names.state(1), "speed_mm_s");
/// assert_eq!(names.parameter(3), "parameter_3");
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FieldNames {
    /// The states.
    pub states: Vec<String>,
    /// The inputs.
    pub inputs: Vec<String>,
    /// The outputs `h(t, y, u)`.
    pub outputs: Vec<String>,
    /// The parameters.
    pub parameters: Vec<String>,
}

impl FieldNames {
    /// Names of states, inputs, outputs and parameters.
    #[must_use]
    pub fn new(states: &[&str], inputs: &[&str], outputs: &[&str], parameters: &[&str]) -> Self {
        let owned = |names: &[&str]| names.iter().map(|n| (*n).to_owned()).collect();
        Self {
            states: owned(states),
            inputs: owned(inputs),
            outputs: owned(outputs),
            parameters: owned(parameters),
        }
    }

    /// Name of a state.
    #[must_use]
    pub fn state(&self, index: usize) -> String {
        named(&self.states, "state", index)
    }

    /// Name of an input.
    #[must_use]
    pub fn input(&self, index: usize) -> String {
        named(&self.inputs, "input", index)
    }

    /// Name of an output.
    #[must_use]
    pub fn output(&self, index: usize) -> String {
        named(&self.outputs, "output", index)
    }

    /// Name of a parameter.
    #[must_use]
    pub fn parameter(&self, index: usize) -> String {
        named(&self.parameters, "parameter", index)
    }

    /// Name of a signal of a field of `state_len` states: states first, then outputs.
    #[must_use]
    pub fn signal(&self, index: usize, state_len: usize) -> String {
        if index < state_len { self.state(index) } else { self.output(index - state_len) }
    }
}

fn named(names: &[String], what: &str, index: usize) -> String {
    names.get(index).cloned().unwrap_or_else(|| format!("{what}_{index}"))
}
