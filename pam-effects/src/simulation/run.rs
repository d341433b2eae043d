//! What a trial shows with effects.

use super::integrator::{JointIntegrator, Measured, Parts};
use super::record::ResampledRecord;
use super::trial::Trial;
use crate::effects::{AnyEffect, EffectScalar, Observed};
use pam_core::{JointModel, MuscleGeometry};
use thiserror::Error;

/// The base model's own numbers.
#[derive(Debug, Clone, Copy)]
pub struct Base<S> {
    /// Mass m, kg.
    pub mass_kg: S,
    /// Deformation coefficient ν.
    pub deformation: S,
    /// Gas coefficient C, kPa·mm³/g.
    pub gas_coefficient: S,
    /// Auxiliary damping B, kg/s.
    pub damping_kg_s: S,
    /// Nominal size.
    pub geometry: MuscleGeometry,
}

impl Base<f64> {
    /// The numbers of a model.
    #[must_use]
    pub fn of<F>(model: &JointModel<f64, F>) -> Self {
        let p = model.physical();
        Self {
            mass_kg: p.mass_kg,
            deformation: p.deformation,
            gas_coefficient: p.gas_coefficient,
            damping_kg_s: model.auxiliary_damping_kg_s,
            geometry: model.geometry,
        }
    }
}

/// What a recording leaves uncertain, as deviations from the measured values.
#[derive(Debug, Clone, Copy)]
pub struct Nuisances<S> {
    /// Logarithm of the factor on the model's mass.
    pub log_mass: S,
    /// Logarithm of the factor on the model's deformation coefficient.
    pub log_deformation: S,
    /// By how many of its samples the force acts earlier than if each value held until the next.
    pub lead_samples: f64,
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
            start_mm: S::zero(),
            start_mm_s: S::zero(),
            log_air: [S::zero(); 2],
        }
    }
}

/// The channels at the grid points, as the sensors would show them: mm, mm/s, kPa, kPa.
#[derive(Debug, Clone)]
pub struct Trajectory<S> {
    /// In the order of the state.
    pub channels: [Vec<S>; 4],
}

impl<S> Default for Trajectory<S> {
    fn default() -> Self {
        Self { channels: [const { Vec::new() }; 4] }
    }
}

/// A simulation that left the range of the joint.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("the simulation diverges at t = {time_s:.3} s")]
pub struct Diverged {
    /// When.
    pub time_s: f64,
}

/// Simulates a trial with effects. `values` holds the parameters and switches of each effect in turn.
///
/// # Errors
/// [`Diverged`] with the time, if the displacement leaves the range in which the chambers have a volume.
pub fn simulate<S: EffectScalar>(
    trial: &Trial,
    base: &Base<f64>,
    effects: &[&dyn AnyEffect],
    values: &[S],
    nuisances: &Nuisances<S>,
    out: &mut Trajectory<S>,
) -> Result<(), Diverged> {
    let parts = Parts::new(effects, values);
    let base = Base {
        mass_kg: nuisances.log_mass.exp().scaled(base.mass_kg),
        deformation: nuisances.log_deformation.exp().scaled(base.deformation),
        gas_coefficient: S::constant(base.gas_coefficient),
        damping_kg_s: S::constant(base.damping_kg_s),
        geometry: base.geometry,
    };
    let measured = Measured::of(&trial.record);
    JointIntegrator::new(&trial.record, &base, &trial.table, &parts, &measured, nuisances)
        .run(out)?;
    observe(&trial.record, &parts, &mut out.channels);
    for (channel, low_pass) in out.channels.iter_mut().zip(trial.record.filters()) {
        if let Some(low_pass) = low_pass {
            *channel = low_pass.forward_backward(channel);
        }
    }
    Ok(())
}

/// Turns true channels into those that the sensors show.
pub(crate) fn observe<S: EffectScalar>(
    record: &ResampledRecord,
    parts: &Parts<'_, S>,
    channels: &mut [Vec<S>; 4],
) {
    let [x, v, pf, pe] = channels;
    let mut seen = Observed {
        step_s: record.step_s,
        displacement_mm: x,
        velocity_mm_s: v,
        pressures_kpa: [pf, pe],
    };
    for part in &parts.list {
        part.effect.observe(part.p, &mut seen);
    }
}
