//! One run of a system.

use pam_core::FieldNames;
use pam_solvers::{Fixed, InputError, Interpolation, SampledInput};

/// One run of a system: what drove it, where it started, what was measured.
///
/// ```
/// use pam_solvers::Constant;
/// use pam_train::field::Experiment;
///
/// // Two states measured at three times under a constant input.
/// let times_s = vec![0.0, 0.1, 0.2];
/// let measured = vec![1.0, 0.0, 0.9, -0.8, 0.7, -1.4]; // row by row
/// let run = Experiment::new("step", Constant(vec![2.0]), times_s, measured).starting_at(vec![1.0, 0.0]);
/// assert!((run.sample_s() - 0.1).abs() < 1e-12);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Experiment<I> {
    /// Name in messages.
    pub name: String,
    /// The input `u(t)`.
    pub input: I,
    /// The state at the first time. Empty for a start at rest: measured states at their first measured value, all others at
    /// zero.
    pub initial_state: Vec<f64>,
    /// Times of the measurements, increasing, s. The solve starts at the first.
    pub times_s: Vec<f64>,
    /// The measured outputs, row-major `[times, outputs]`.
    pub measured: Vec<f64>,
    /// Names of its inputs, if they are known; compared with those of the field.
    pub input_names: Vec<String>,
    /// Names of its measured outputs, if they are known; compared with those of the field.
    pub output_names: Vec<String>,
}

/// A measured input that owns its samples and is no parameter of anything.
pub type MeasuredInput = Fixed<SampledInput<'static, f64>>;

impl<I> Experiment<I> {
    /// A run that starts at rest; `measured` is row-major `[times, outputs]`.
    pub fn new(name: &str, input: I, times_s: Vec<f64>, measured: Vec<f64>) -> Self {
        Self {
            name: name.to_owned(),
            input,
            initial_state: Vec::new(),
            times_s,
            measured,
            input_names: Vec::new(),
            output_names: Vec::new(),
        }
    }

    /// The same run from another state at the first time.
    #[must_use]
    pub fn starting_at(self, initial_state: Vec<f64>) -> Self {
        Self { initial_state, ..self }
    }

    /// The time between samples, their median, s; 0 with fewer than two of them.
    #[must_use]
    pub fn sample_s(&self) -> f64 {
        let mut steps: Vec<f64> = self.times_s.windows(2).map(|w| w[1] - w[0]).collect();
        steps.sort_by(f64::total_cmp);
        steps.get(steps.len() / 2).copied().unwrap_or(0.0)
    }

    /// The first mismatch between the names of the run and those of a field, if there is one.
    pub(super) fn misnamed(&self, names: &FieldNames, outputs: &[String]) -> Option<String> {
        let differs = |own: &[String], other: &[String]| {
            !own.is_empty() && own.iter().zip(other).any(|(a, b)| a != b)
        };
        let what = if differs(&self.input_names, &names.inputs) {
            ("inputs", &self.input_names, names.inputs.as_slice())
        } else if differs(&self.output_names, outputs) {
            ("outputs", &self.output_names, outputs)
        } else {
            return None;
        };
        let (kind, own, other) = what;
        Some(format!(
            "experiment `{}` has the {kind} {own:?}, the problem {other:?}; give them in this order",
            self.name
        ))
    }
}

impl Experiment<MeasuredInput> {
    /// A run from arrays: times (s), inputs and measured outputs by name, each with one value for each time. It owns all of
    /// them.
    ///
    /// Inputs are held from sample to sample, as a digital controller puts them out;
    /// [`read_by`](Self::read_by) reads them otherwise.
    ///
    /// ```
    /// use pam_train::field::Experiment;
    ///
    /// let (times_s, voltage) = ([0.0, 0.1, 0.2], [1.0, 1.0, 0.0]);
    /// let position = [0.0, 0.4, 1.3];
    /// let run = Experiment::sampled(
    ///     "run 1", &times_s, &[("voltage_v", &voltage)], &[("position_mm", &position)],
    /// )?;
    /// assert_eq!(run.measured, position);
    /// # Ok::<(), pam_solvers::InputError>(())
    /// ```
    ///
    /// # Errors
    /// [`InputError`] if there is no sample, a list has another length than the times, or times do not increase.
    pub fn sampled(
        name: &str,
        times_s: &[f64],
        inputs: &[(&str, &[f64])],
        outputs: &[(&str, &[f64])],
    ) -> Result<Self, InputError> {
        let rows = times_s.len();
        let interleaved = |channels: &[(&str, &[f64])]| -> Result<Vec<f64>, InputError> {
            if let Some(bad) = channels.iter().find(|c| c.1.len() != rows) {
                return Err(InputError::Lengths { times: rows, values: bad.1.len(), variables: 1 });
            }
            Ok((0..rows).flat_map(|k| channels.iter().map(move |c| c.1[k])).collect())
        };
        let names = |channels: &[(&str, &[f64])]| channels.iter().map(|c| c.0.to_owned()).collect();
        let values = interleaved(inputs)?;
        let input =
            SampledInput::owned(times_s.to_vec(), values, inputs.len(), Interpolation::Hold)?;
        Ok(Self {
            input_names: names(inputs),
            output_names: names(outputs),
            ..Self::new(name, Fixed(input), times_s.to_vec(), interleaved(outputs)?)
        })
    }

    /// The same run with its inputs read otherwise between their samples.
    #[must_use]
    pub fn read_by(self, interpolation: Interpolation) -> Self {
        Self { input: Fixed(self.input.0.read_by(interpolation)), ..self }
    }
}
