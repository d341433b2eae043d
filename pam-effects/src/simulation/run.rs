//! Simulation of a trial.

use super::base::Base;
use super::integrator::JointIntegrator;
use super::measured::Measured;
use super::nuisances::Nuisances;
use super::observation::measure;
use super::parts::Parts;
use super::steps::substeps;
use super::table::ForceTable;
use super::trajectory::{Diverged, Trajectory};
use super::trial::Trial;
use crate::effects::{AnyEffect, Derivatives, EffectScalar, FewDerivatives, ManyDerivatives};
use pam_core::simd::arch;
use pulp::{Simd, WithSimd};

/// Scalars that trials are simulated with: numbers, and numbers with derivatives.
pub trait SimulationScalar: EffectScalar {
    /// Implements [`simulate_until`].
    ///
    /// # Errors
    /// See [`simulate_until`].
    fn simulate(
        trial: &Trial,
        base: &Base<f64>,
        effects: &[&dyn AnyEffect],
        values: &[Self],
        nuisances: &Nuisances<Self>,
        points: usize,
        out: &mut Trajectory<Self>,
    ) -> Result<(), Diverged>;

    /// Implements [`sensed`].
    fn measure(
        trial: &Trial,
        effects: &[&dyn AnyEffect],
        values: &[Self],
        out: &mut Trajectory<Self>,
    );
}

// Methods for concrete types are compiled in this crate, once.
macro_rules! simulation_scalars {
    ($($scalar:ty),+) => {
        $(impl SimulationScalar for $scalar {
            fn simulate(
                trial: &Trial,
                base: &Base<f64>,
                effects: &[&dyn AnyEffect],
                values: &[Self],
                nuisances: &Nuisances<Self>,
                points: usize,
                out: &mut Trajectory<Self>,
            ) -> Result<(), Diverged> {
                run(trial, base, effects, values, nuisances, points, out)
            }

            fn measure(
                trial: &Trial,
                effects: &[&dyn AnyEffect],
                values: &[Self],
                out: &mut Trajectory<Self>,
            ) {
                measure(&trial.record, &Parts::new(effects, values), &mut out.channels);
            }
        })+
    };
}

simulation_scalars!(f64, Derivatives, FewDerivatives, ManyDerivatives);

/// Simulates a trial with effects. `values` holds the parameters and switches of each effect in turn.
///
/// # Errors
/// [`Diverged`] with the time, if the displacement leaves the range in which the chambers have a volume.
pub fn simulate<S: SimulationScalar>(
    trial: &Trial,
    base: &Base<f64>,
    effects: &[&dyn AnyEffect],
    values: &[S],
    nuisances: &Nuisances<S>,
    out: &mut Trajectory<S>,
) -> Result<(), Diverged> {
    simulate_until(trial, base, effects, values, nuisances, trial.record.points(), out)
}

/// As [`simulate`], for the first `points` of the grid.
///
/// # Errors
/// As [`simulate`], up to these points.
pub fn simulate_until<S: SimulationScalar>(
    trial: &Trial,
    base: &Base<f64>,
    effects: &[&dyn AnyEffect],
    values: &[S],
    nuisances: &Nuisances<S>,
    points: usize,
    out: &mut Trajectory<S>,
) -> Result<(), Diverged> {
    S::simulate(trial, base, effects, values, nuisances, points.min(trial.record.points()), out)
}

fn run<S: EffectScalar>(
    trial: &Trial,
    base: &Base<f64>,
    effects: &[&dyn AnyEffect],
    values: &[S],
    nuisances: &Nuisances<S>,
    points: usize,
    out: &mut Trajectory<S>,
) -> Result<(), Diverged> {
    let parts = Parts::new(effects, values);
    let of = (effects, &parts, values);
    true_channels(trial, base, of, nuisances, points, &mut out.channels)?;
    measure(&trial.record, &parts, &mut out.channels);
    Ok(())
}

/// The motion of the first `points` of the grid at all steps of the simulation, before any sensor.
///
/// # Errors
/// As [`simulate_until`].
pub fn motion_until(
    trial: &Trial,
    base: &Base<f64>,
    effects: &[&dyn AnyEffect],
    values: &[f64],
    nuisances: &Nuisances<f64>,
    points: usize,
) -> Result<Trajectory<f64>, Diverged> {
    let of = (effects, &Parts::new(effects, values), values);
    let mut motion = Trajectory::default();
    let points = points.min(trial.record.points());
    true_channels(trial, base, of, nuisances, points, &mut motion.channels)?;
    Ok(motion)
}

/// A [motion](motion_until) as the sensors show it, among effects by which it has no derivatives.
pub fn sensed<S: SimulationScalar>(
    trial: &Trial,
    effects: &[&dyn AnyEffect],
    values: &[S],
    motion: &Trajectory<f64>,
    out: &mut Trajectory<S>,
) {
    for (to, from) in out.channels.iter_mut().zip(&motion.channels) {
        to.clear();
        to.extend(from.iter().map(|&value| S::constant(value)));
    }
    S::measure(trial, effects, values, out);
}

/// The channels at all steps as they are, before any sensor. Effects come with their values, as parts and as they are.
fn true_channels<S: EffectScalar>(
    trial: &Trial,
    base: &Base<f64>,
    (effects, parts, values): (&[&dyn AnyEffect], &Parts<'_, S>, &[S]),
    nuisances: &Nuisances<S>,
    points: usize,
    channels: &mut [Vec<S>; 4],
) -> Result<(), Diverged> {
    let base = Base {
        mass_kg: nuisances.log_mass.exp().scaled(base.mass_kg),
        deformation: nuisances.log_deformation.exp().scaled(base.deformation),
        gas_coefficient: S::constant(base.gas_coefficient),
        damping_kg_s: S::constant(base.damping_kg_s),
        geometry: base.geometry,
    };
    let substeps = substeps_of(trial, &base, effects, values);
    let measured = Measured::of(&trial.record);
    let record = &trial.record;
    let joint =
        |force| JointIntegrator::new(record, &base, force, parts, &measured, nuisances, substeps);
    // Unless air is lost, its masses stay, and the table at these masses is the force.
    let table = trial.table_at(joint(&trial.table).masses());
    let led = trial.led(nuisances.lead_samples);
    let mut joint = joint(&*table).driven_by(&led).with_gas_table();
    arch().dispatch(Running { joint: &mut joint, points, channels })
}

/// A simulation, for the vectors of this machine.
pub(super) struct Running<'r, 'a, S> {
    pub(super) joint: &'r mut JointIntegrator<'a, S, ForceTable>,
    pub(super) points: usize,
    pub(super) channels: &'r mut [Vec<S>; 4],
}

impl<S: EffectScalar> WithSimd for Running<'_, '_, S> {
    type Output = Result<(), Diverged>;

    #[inline(always)]
    fn with_simd<V: Simd>(self, _: V) -> Self::Output {
        self.joint.run(self.points, self.channels, |_, _| {})
    }
}

/// Substeps of each step of the grid (4 ms, or less where the samples are closer) that the mechanics of a model and the kinks of its
/// force need on a trial, without effects; at most 32, which may not be enough.
#[must_use]
pub fn needed_substeps(trial: &Trial, base: &Base<f64>) -> usize {
    substeps_of(trial, base, &[], &[])
}

/// Substeps by the real parts of all numbers.
fn substeps_of<S: EffectScalar>(
    trial: &Trial,
    base: &Base<S>,
    effects: &[&dyn AnyEffect],
    values: &[S],
) -> usize {
    let values: Vec<f64> = values.iter().map(|v| v.real()).collect();
    let (parts, base) = (Parts::new(effects, &values), base.real());
    let (record, measured) = (&trial.record, Measured::of(&trial.record));
    let none = Nuisances::none();
    let mut joint = JointIntegrator::new(record, &base, &trial.table, &parts, &measured, &none, 1);
    substeps(&mut joint).max(trial.least_substeps)
}
