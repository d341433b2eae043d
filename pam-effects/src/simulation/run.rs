//! Simulation of a trial.

use super::base::Base;
use super::integrator::JointIntegrator;
use super::measured::Measured;
use super::nuisances::Nuisances;
use super::observation::measure;
use super::parts::Parts;
use super::trajectory::{Diverged, Trajectory};
use super::trial::Trial;
use crate::effects::{AnyEffect, EffectScalar};

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
        .run(&mut out.channels, |_, _| {})?;
    measure(&trial.record, &parts, &mut out.channels);
    Ok(())
}
