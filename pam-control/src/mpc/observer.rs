//! State and unexplained force from encoder and pressure sensors.
//!
//! ```text
//! x̂˙ = v̂ + 3ω e                      e = x − x̂
//! v̂˙ = (d̂ − f(x̂, v̂, m̂) − B v̂) / m + 3ω² e
//! d̂˙ = m ω³ e
//! ```
//!
//! an extended-state observer with three equal poles (Han 2009). The air follows the valves' modelled flows
//! and is drawn towards the measured pressures, which come through a first-order low-pass that the observer
//! runs too.

use crate::execution::{Reading, SAMPLE_S};
use crate::synthesis::ForceBatch;
use pam_core::{JointModel, SealedMasses};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// How fast the observer follows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ObserverSettings {
    /// The poles ω, rad/s.
    pub pole_rad_s: f64,
    /// Cutoff of the pressure sensors' low-pass, Hz.
    pub pressure_cutoff_hz: f64,
    /// Rate at which the air is drawn towards the measured pressures, 1/s.
    pub mass_rate: f64,
}

impl Default for ObserverSettings {
    fn default() -> Self {
        Self { pole_rad_s: 60.0, pressure_cutoff_hz: 3.0, mass_rate: 2.0 }
    }
}

/// Estimated state of the joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Belief {
    /// Displacement, mm.
    pub displacement_mm: f64,
    /// Velocity, mm/s.
    pub velocity_mm_s: f64,
    /// Air, g.
    pub masses: SealedMasses,
    /// Force along +x that the model does not explain, mN.
    pub force_mn: f64,
}

/// The observer.
#[derive(Debug, Clone)]
pub struct Observer {
    settings: ObserverSettings,
    belief: Belief,
    filtered_kpa: [f64; 2],
}

impl Observer {
    /// Starts from a joint at rest.
    #[must_use]
    pub fn at_rest<F>(
        settings: ObserverSettings,
        model: &JointModel<f64, F>,
        reading: &Reading,
    ) -> Self
    where
        F: pam_core::ForceModel<f64>,
    {
        let masses = model.gas_law_masses(reading.displacement_mm, reading.pressures_kpa);
        let belief = Belief {
            displacement_mm: reading.displacement_mm,
            velocity_mm_s: 0.0,
            masses,
            force_mn: 0.0,
        };
        Self { settings, belief, filtered_kpa: reading.pressures_kpa }
    }

    /// The present estimate.
    #[must_use]
    pub fn belief(&self) -> &Belief {
        &self.belief
    }

    /// Takes a reading and the flows (g/s) of the sample that begins with it in.
    pub fn update<F, B>(
        &mut self,
        model: &JointModel<f64, F>,
        mass_kg: f64,
        batch: &B,
        work: &mut B::Work,
        reading: &Reading,
        flows_g_s: [f64; 2],
    ) where
        F: pam_core::ForceModel<f64>,
        B: ForceBatch,
    {
        let b = self.belief;
        let mut force = [0.0];
        let point = [b.masses.flexor_g, b.masses.extensor_g, b.displacement_mm, b.velocity_mm_s];
        batch.values_into(&[point], &mut force, work);
        let omega = self.settings.pole_rad_s;
        let error = reading.displacement_mm - b.displacement_mm;
        let acceleration =
            (b.force_mn - force[0] - model.auxiliary_damping_kg_s * b.velocity_mm_s) / mass_kg;
        let share = -(-TAU * self.settings.pressure_cutoff_hz * SAMPLE_S).exp_m1();
        let pressures = model.gas_law_pressures_kpa(b.displacement_mm, b.masses);
        let mut drawn = [0.0; 2];
        for i in 0..2 {
            self.filtered_kpa[i] += share * (pressures[i] - self.filtered_kpa[i]);
            drawn[i] = reading.pressures_kpa[i] - self.filtered_kpa[i];
        }
        let correction = model.gas_law_masses(b.displacement_mm, drawn);
        let rate = self.settings.mass_rate;
        let h = SAMPLE_S;
        let velocity = b.velocity_mm_s + h * (acceleration + 3.0 * omega * omega * error);
        self.belief = Belief {
            displacement_mm: b.displacement_mm + h * (velocity + 3.0 * omega * error),
            velocity_mm_s: velocity,
            force_mn: b.force_mn + h * mass_kg * omega.powi(3) * error,
            masses: SealedMasses {
                flexor_g: b.masses.flexor_g + h * (flows_g_s[0] + rate * correction.flexor_g),
                extensor_g: b.masses.extensor_g + h * (flows_g_s[1] + rate * correction.extensor_g),
            },
        };
    }
}
