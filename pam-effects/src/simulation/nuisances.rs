//! Deviations of a recording from its measured values.

use crate::effects::EffectScalar;

/// Quantities that a recording leaves uncertain, as deviations from the measured values.
#[derive(Debug, Clone, Copy)]
pub struct Nuisances<S> {
    /// Logarithm of the factor on the model's mass.
    pub log_mass: S,
    /// Logarithm of the factor on the model's deformation coefficient.
    pub log_deformation: S,
    /// Lead of the force over a zero-order hold, in samples.
    pub lead_samples: f64,
    /// Share of the [doubtful force](super::ResampledRecord::doubtful_force) that is noise of its sensor and does not act.
    pub force_noise_share: S,
    /// Added to the displacement at the start, mm.
    pub start_mm: S,
    /// Added to the velocity at the start, mm/s.
    pub start_mm_s: S,
    /// Logarithms of the factors on the sealed masses.
    pub log_air: [S; 2],
}

impl<S: EffectScalar> Nuisances<S> {
    /// No deviation.
    #[must_use]
    pub fn none() -> Self {
        Self {
            log_mass: S::zero(),
            log_deformation: S::zero(),
            lead_samples: 0.0,
            force_noise_share: S::zero(),
            start_mm: S::zero(),
            start_mm_s: S::zero(),
            log_air: [S::zero(); 2],
        }
    }
}
