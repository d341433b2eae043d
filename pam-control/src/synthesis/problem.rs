//! Inputs and results of the synthesis.

use crate::error::ControlError;
use pam_core::units::{ATMOSPHERE_KPA, KPA_PER_PSI};
use pam_core::{JointModel, SealedMasses};
use serde::{Deserialize, Serialize};

/// Target of one sample.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Target {
    /// Time, s.
    pub time_s: f64,
    /// Displacement x_d, mm.
    pub displacement_mm: f64,
    /// Velocity ẋ_d, mm/s.
    pub velocity_mm_s: f64,
    /// Acceleration ẍ_d, mm/s².
    pub acceleration_mm_s2: f64,
    /// Stiffness K_d, N/mm.
    pub stiffness_n_mm: f64,
    /// External force F_e that is expected, mN.
    pub load_mn: f64,
}

impl Target {
    /// Checks that all numbers are finite and the stiffness is positive.
    ///
    /// # Errors
    /// [`ControlError::Value`] naming the quantity.
    pub fn validate(&self) -> Result<(), ControlError> {
        for (field, value) in [
            ("time (s)", self.time_s),
            ("displacement (mm)", self.displacement_mm),
            ("velocity (mm/s)", self.velocity_mm_s),
            ("acceleration (mm/s²)", self.acceleration_mm_s2),
            ("load (mN)", self.load_mn),
        ] {
            ControlError::require_finite(field, value)?;
        }
        ControlError::require_positive("stiffness (N/mm)", self.stiffness_n_mm)
    }
}

/// Pressures between which the published model was trained, kPa absolute (10 and 80 psi gauge).
pub const TRAINED_KPA: [f64; 2] =
    [10.0 * KPA_PER_PSI + ATMOSPHERE_KPA, 80.0 * KPA_PER_PSI + ATMOSPHERE_KPA];

/// Least and most air in a muscle, g.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MassBounds {
    /// Least, g.
    pub least_g: f64,
    /// Most, g.
    pub most_g: f64,
}

impl MassBounds {
    /// Bounds that make sense.
    ///
    /// # Errors
    /// [`ControlError::Value`] unless `0 < least < most`, both finite.
    pub fn new(least_g: f64, most_g: f64) -> Result<Self, ControlError> {
        ControlError::require_positive("least air mass (g)", least_g)?;
        ControlError::require_positive("most air mass (g)", most_g)?;
        if most_g <= least_g {
            return Err(ControlError::Value {
                field: "most air mass (g)",
                value: most_g,
                why: format!("it must be more than the least, {least_g} g"),
            });
        }
        Ok(Self { least_g, most_g })
    }

    /// The air of muscles at x = 0 between these pressures (kPa absolute) by a model's gas law.
    #[must_use]
    pub fn of_pressures<F>(model: &JointModel<f64, F>, [low, high]: [f64; 2]) -> Self
    where
        F: pam_core::ForceModel<f64>,
    {
        Self {
            least_g: model.gas_law_masses(0.0, [low; 2]).flexor_g,
            most_g: model.gas_law_masses(0.0, [high; 2]).flexor_g,
        }
    }

    /// The air between which the training conditions lie: 10 to 80 psi gauge at x = 0.
    #[must_use]
    pub fn trained<F: pam_core::ForceModel<f64>>(model: &JointModel<f64, F>) -> Self {
        Self::of_pressures(model, TRAINED_KPA)
    }

    /// True if both masses lie within, up to rounding.
    #[must_use]
    pub fn contain(&self, masses: SealedMasses) -> bool {
        let slack = 1e-9 * self.most_g;
        [masses.flexor_g, masses.extensor_g]
            .iter()
            .all(|m| (self.least_g - slack..=self.most_g + slack).contains(m))
    }

    /// Most less least, g.
    #[must_use]
    pub fn width_g(&self) -> f64 {
        self.most_g - self.least_g
    }

    pub(super) fn clamp(&self, u: [f64; 2]) -> [f64; 2] {
        u.map(|m| m.clamp(self.least_g, self.most_g))
    }
}

/// How the synthesis is done.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SynthesisSettings {
    /// Step h of the stiffness estimate K̂, mm.
    pub stiffness_step_mm: f64,
    /// Largest force by which a solution may miss the acceleration, mN.
    pub tolerance_mn: f64,
    /// Largest difference to the wanted stiffness that counts as reached, N/mm.
    pub stiffness_tolerance_n_mm: f64,
    /// Least and most air.
    pub bounds: MassBounds,
    /// Samples that are solved side by side.
    pub segments: usize,
}

impl SynthesisSettings {
    /// The published set-up (Wang and Realmuto 2026, section II-E) within given bounds: h = 1 mm,
    /// ε = 0.001 mN.
    #[must_use]
    pub fn published(bounds: MassBounds) -> Self {
        Self {
            stiffness_step_mm: 1.0,
            tolerance_mn: 1e-3,
            stiffness_tolerance_n_mm: 1e-6,
            bounds,
            segments: 16,
        }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// [`ControlError::Value`] naming the first that is impossible.
    pub fn validate(&self) -> Result<(), ControlError> {
        ControlError::require_positive("stiffness step h (mm)", self.stiffness_step_mm)?;
        ControlError::require_positive("tolerance (mN)", self.tolerance_mn)?;
        ControlError::require_positive(
            "stiffness tolerance (N/mm)",
            self.stiffness_tolerance_n_mm,
        )?;
        ControlError::require_positive("segments", self.segments as f64)?;
        MassBounds::new(self.bounds.least_g, self.bounds.most_g).map(|_| ())
    }
}

/// How well a target is met.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// Motion and stiffness.
    Reached,
    /// The motion; the stiffness is the nearest that can be had with it.
    NearestStiffness,
    /// Not even the motion: the masses are those that miss its acceleration by least.
    MotionUnreachable,
}

/// The air for one target.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Solution {
    /// The air.
    pub masses: SealedMasses,
    /// Stiffness estimate K̂ there, N/mm.
    pub stiffness_n_mm: f64,
    /// `m ẍ_d + f + B ẋ_d − F_e` there, mN.
    pub residual_mn: f64,
    /// How well the target is met.
    pub outcome: Outcome,
    /// Least and largest stiffness that the motion can be had with, where they were needed (a stiffness
    /// was not reached), N/mm.
    pub reachable_n_mm: Option<[f64; 2]>,
}
