//! Which signals of a field are measured.

use super::FieldError;
use pam_core::ParametricField;

/// Which signals are measured, and how well. The signals of a field are its states, and after them its outputs
/// ([`outputs_into`](pam_core::VectorField::outputs_into)).
///
/// ```
/// use pam_train::field::Outputs;
///
/// // Of a field with two states and one output: the first state and the output, with the deviations of their noise.
/// let outputs = Outputs::new([(0, 0.02), (2, 0.1)]);
/// assert_eq!(outputs.signals, [0, 2]);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Outputs {
    /// Index of the signal behind each output: of a state, or the number of states plus the index of an output.
    pub signals: Vec<usize>,
    /// Standard deviation of the noise of each output, in its unit; NaN where it is not known.
    pub noise: Vec<f64>,
}

impl Outputs {
    /// Pairs of a signal's index and the standard deviation of its noise.
    pub fn new(outputs: impl IntoIterator<Item = (usize, f64)>) -> Self {
        let (signals, noise) = outputs.into_iter().unzip();
        Self { signals, noise }
    }

    /// Signals whose noise is not known: its standard deviation is NaN. Least squares and diagnosis estimate it.
    pub fn of_unknown_noise(signals: impl IntoIterator<Item = usize>) -> Self {
        Self::new(signals.into_iter().map(|signal| (signal, f64::NAN)))
    }

    /// Signals by the names that the field gives them, with the standard deviation of their noise (NaN where it is not
    /// known).
    ///
    /// # Errors
    /// [`FieldError::Shape`] with the signals that there are, if a name is none of them.
    pub fn named<'n, F: ParametricField>(
        field: &F,
        outputs: impl IntoIterator<Item = (&'n str, f64)>,
    ) -> Result<Self, FieldError> {
        let (names, states) = (field.names(), field.state_len());
        let all: Vec<String> =
            (0..states + field.output_len()).map(|k| names.signal(k, states)).collect();
        let found = outputs.into_iter().map(|(name, noise)| {
            let index = all.iter().position(|n| n == name);
            let why = || format!("the field has no signal `{name}`; it has {all:?}");
            index.map(|k| (k, noise)).ok_or_else(|| FieldError::Shape(why()))
        });
        Ok(Self::new(found.collect::<Result<Vec<_>, _>>()?))
    }

    /// Number of outputs.
    #[must_use]
    pub fn len(&self) -> usize {
        self.signals.len()
    }

    /// Whether nothing is measured.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.signals.is_empty()
    }

    /// By what an error of each output is divided in a loss: its noise, or 1 of its unit where that is not known.
    pub(super) fn units(&self) -> Vec<f64> {
        self.noise.iter().map(|n| if n.is_nan() { 1.0 } else { *n }).collect()
    }
}
