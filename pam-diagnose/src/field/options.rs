//! Options of a diagnosis of a field.

use crate::settings::DiagnosisSettings;

/// Meaning of the noise levels of the outputs ([`Outputs::noise`](pam_train::field::Outputs::noise)) are taken for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FieldNoise {
    /// For nothing: size and correlation of the noise are learned from what a flexible model cannot learn of the
    /// residual. The diagnosis does not depend on the levels.
    #[default]
    Learned,
    /// For lower limits of a noise that is learned: nothing smaller than that is looked at. A level of NaN is none.
    AtLeast,
    /// For the size of the noise, of which only the correlation is learned. A level of NaN is learned.
    Given,
}

/// Options of [`diagnose_field`](super::diagnose_field).
#[derive(Debug, Clone, PartialEq)]
pub struct FieldOptions {
    /// Parameters of the field (by index) that are fitted along with every hypothesis, since they are not
    /// known well: a mass, a stiffness. Without them, a cause may be named for a slightly wrong parameter.
    pub refitted: Vec<usize>,
    /// Those of them that are positive and fitted by their logarithm.
    pub logarithmic: Vec<usize>,
    /// Prior standard deviation of each refitted parameter, of its logarithm for a logarithmic one; free, if absent. Where the
    /// error is large, such as the drift of a free motion, it keeps the model without causes from values at which
    /// nothing moves.
    pub refitted_deviation: Option<Vec<f64>>,
    /// Prior standard deviation of each initial state; zero for one that is known exactly. If absent, measured states
    /// have that of their noise and the others are known.
    pub initial_state_deviation: Option<Vec<f64>>,
    /// Prior standard deviation of a delay of the inputs that all experiments share and that is fitted along with every
    /// hypothesis, s; zero for none.
    pub delay_deviation_s: f64,
    /// Meaning of the noise levels of the outputs.
    pub noise: FieldNoise,
    /// Number of experiments, the last ones of the problem, on which the field was validated: their error is its
    /// baseline discrepancy.
    pub baseline: usize,
    /// Seed of the null tests and the bootstrap; `data.split_seed` draws the split.
    pub seed: u64,
    /// Every other number on which the diagnosis depends.
    pub settings: DiagnosisSettings,
}

impl Default for FieldOptions {
    fn default() -> Self {
        Self {
            refitted: Vec::new(),
            logarithmic: Vec::new(),
            refitted_deviation: None,
            initial_state_deviation: None,
            delay_deviation_s: 0.0,
            noise: FieldNoise::default(),
            baseline: 0,
            seed: 1,
            settings: DiagnosisSettings::default(),
        }
    }
}
