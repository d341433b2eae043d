//! Effects that are trained with the network.

use super::error::TrainingError;
use crate::curriculum::{Curriculum, StartModel};
use pam_core::Scalar;
use pam_core::parallel;
use pam_data::{Subject, load_model};
use pam_effects::effects::{AnyEffect, Derivatives, WIDTH};
use pam_effects::simulation::{Base, Nuisances, Trajectory, Trial, simulate};
use pam_effects::{ActiveEffect, EffectError, EffectRecord};
use pam_trajectory::engine::NetworkJoint;
use pam_trajectory::metrics::variance;

/// The effects that a curriculum trains: those of the model file that it starts from, then those of
/// `model.effects`, which replace effects of the same id in the file. Ids are looked up among `known` and all
/// that this process knows.
///
/// # Errors
/// [`TrainingError`] if the file does not read, or an effect is not known.
pub fn effects_of(
    curriculum: &Curriculum,
    known: &[&'static dyn AnyEffect],
) -> Result<Vec<ActiveEffect>, TrainingError> {
    let fail = |e: EffectError| TrainingError::Curriculum(e.to_string());
    let mut records = match &curriculum.model.start {
        StartModel::File(path) => EffectRecord::all_of(&load_model(path)?.info).map_err(fail)?,
        StartModel::Random => Vec::new(),
    };
    for listed in &curriculum.model.effects {
        match records.iter_mut().find(|s| s.effect == listed.effect) {
            Some(own) => *own = listed.clone(),
            None => records.push(listed.clone()),
        }
    }
    records.iter().map(|record| record.resolve(known).map_err(fail)).collect()
}

/// Checks that effects are there once and start inside their ranges.
pub(super) fn check(effects: &[ActiveEffect]) -> Result<(), EffectError> {
    for (k, active) in effects.iter().enumerate() {
        let info = active.effect.info();
        if effects[..k].iter().any(|before| before.effect.info().id == info.id) {
            return Err(fault(active, "it is there twice; leave one of them out".into()));
        }
        for (p, v) in info.parameters.iter().zip(&active.values) {
            let [low, high] = p.range;
            if !(low..=high).contains(v) {
                let message = format!("`{}` is {v}; it may be {low} to {high}", p.name);
                return Err(fault(active, message));
            }
        }
    }
    Ok(())
}

fn fault(active: &ActiveEffect, message: String) -> EffectError {
    EffectError::Effect { id: active.effect.info().id.into(), message }
}

/// Effects and names of their parameters in turn.
fn parameters(effects: &[ActiveEffect]) -> impl Iterator<Item = (&ActiveEffect, &'static str)> {
    effects.iter().flat_map(|a| a.effect.info().parameters.iter().map(move |p| (a, p.name)))
}

/// Names of the parameters with their effects, `coulomb_friction.force_n`.
pub(super) fn parameter_names(effects: &[ActiveEffect]) -> Vec<String> {
    parameters(effects).map(|(a, name)| format!("{}.{name}", a.effect.info().id)).collect()
}

/// How far each parameter (its logarithm, if it is moved by that) must change to change the predictions of
/// `subjects` by one standard deviation of the measured channels (root mean square over channels and recordings).
///
/// # Errors
/// [`EffectError`] if a parameter changes no prediction, or the model diverges.
pub(super) fn units(
    effects: &[ActiveEffect],
    model: &NetworkJoint,
    subjects: &[Subject],
) -> Result<Vec<f64>, EffectError> {
    let squares: Vec<Vec<f64>> =
        parallel::map(subjects.len(), |k| sensitivities(effects, model, &subjects[k]))
            .into_iter()
            .collect::<Result<_, _>>()?;
    let count = subjects.len().max(1) as f64;
    let values = effects.iter().flat_map(ActiveEffect::parameters);
    parameters(effects)
        .zip(values)
        .enumerate()
        .map(|(k, ((active, name), value))| {
            let mean = squares.iter().map(|s| s[k]).sum::<f64>() / count;
            let unit = mean.sqrt().recip();
            if unit.is_finite() && unit > 0.0 {
                return Ok(unit);
            }
            Err(fault(
                active,
                format!(
                    "`{name}` = {value} changes no prediction of these recordings; start it elsewhere"
                ),
            ))
        })
        .collect()
}

/// Mean square of the derivatives of the measured channels of one recording, in their standard deviations, by
/// the parameters.
fn sensitivities(
    effects: &[ActiveEffect],
    model: &NetworkJoint,
    subject: &Subject,
) -> Result<Vec<f64>, EffectError> {
    let trial = Trial::new(model, subject);
    let list: Vec<&dyn AnyEffect> = effects.iter().map(|a| a.effect as &dyn AnyEffect).collect();
    let count = parameters(effects).count();
    let mut squares = Vec::with_capacity(count);
    let mut out = Trajectory::default();
    for first in (0..count).step_by(WIDTH) {
        let mut place = 0;
        let mut seeded: Vec<Derivatives> = Vec::new();
        for active in effects {
            let infos = active.effect.info().parameters;
            for (i, &value) in active.values.iter().enumerate() {
                let Some(info) = infos.get(i) else {
                    seeded.push(Derivatives::constant(value));
                    continue;
                };
                let seed = Derivatives::seeded(value, place, first);
                let slope = if info.logarithmic { value } else { 1.0 };
                seeded.push(Derivatives::new(value, seed.derivatives.map(|d| d * slope)));
                place += 1;
            }
        }
        simulate(&trial, &Base::of(model), &list, &seeded, &Nuisances::none(), &mut out).map_err(
            |e| {
                let message = format!(
                    "on {} {e} with the model that is started from; begin with a stage of derivatives, \
                     or from a trained model",
                    trial.record.source.name
                );
                fault(&effects[0], message)
            },
        )?;
        for k in 0..WIDTH.min(count - first) {
            let mean =
                out.channels.iter().zip(&trial.record.measured).map(|(channel, measured)| {
                    let sum: f64 = channel.iter().map(|v| v.derivatives[k].powi(2)).sum();
                    sum / (channel.len() as f64 * variance(measured).max(f64::MIN_POSITIVE))
                });
            squares.push(0.25 * mean.sum::<f64>());
        }
    }
    Ok(squares)
}
