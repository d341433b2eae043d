//! Effects as an extension of a model that is trained.

use crate::curriculum::{Curriculum, Precision, StartModel};
use crate::{Extension, ExtensionError, ExtensionParameter, TrainingError};
use pam_core::Scalar;
use pam_data::Subject;
use pam_data::{StoredEffect, load_model};
use pam_effects::EffectError;
use pam_effects::effects::{ALL, AnyEffect, Derivatives, WIDTH};
use pam_effects::gradient::EffectGradient;
use pam_effects::model::ActiveEffect;
use pam_effects::simulation::{Base, Nuisances, Trajectory, Trial, simulate};
use pam_trajectory::gradient::ExtendedGradient;
use pam_trajectory::gradient::NetworkJoint;
use pam_trajectory::metrics::variance;
use pam_trajectory::windows::Windows;
use rayon::prelude::*;
use std::sync::Arc;

/// Effects whose parameters are trained with the network. Each stays in its
/// [range](pam_effects::effects::ParameterInfo::range) and is moved by its logarithm where it is a scale; switches stay
/// as they are.
#[derive(Debug, Clone)]
pub struct EffectExtension {
    effects: Vec<ActiveEffect>,
}

impl EffectExtension {
    /// Effects with the values from which they are trained.
    ///
    /// # Errors
    /// [`ExtensionError`] for a value outside its range, or an effect that is there twice.
    pub fn new(effects: Vec<ActiveEffect>) -> Result<Self, ExtensionError> {
        for (k, active) in effects.iter().enumerate() {
            let info = active.effect.info();
            let fail = |message: String| Err(ExtensionError { part: info.id.into(), message });
            if effects[..k].iter().any(|before| before.effect.info().id == info.id) {
                return fail("it is there twice; leave one of them out".into());
            }
            for (p, v) in info.parameters.iter().zip(&active.values) {
                let [low, high] = p.range;
                if !(low..=high).contains(v) {
                    return fail(format!("`{}` is {v}; it may be {low} to {high}", p.name));
                }
            }
        }
        Ok(Self { effects })
    }

    /// The effects that a curriculum trains: those of the model file that it starts from, then those of
    /// `model.effects`, which replace effects of the same id in the file. `None` if there are none.
    ///
    /// # Errors
    /// [`TrainingError`] if the file does not read, or an effect is not known or out of its range.
    pub fn of_curriculum(
        curriculum: &Curriculum,
    ) -> Result<Option<Arc<dyn Extension>>, TrainingError> {
        let mut stored: Vec<StoredEffect> = match &curriculum.model.start {
            StartModel::File(path) => load_model(path)?.info.effects,
            StartModel::Random => Vec::new(),
        };
        for listed in &curriculum.model.effects {
            match stored.iter_mut().find(|s| s.effect == listed.effect) {
                Some(own) => *own = listed.clone(),
                None => stored.push(listed.clone()),
            }
        }
        if stored.is_empty() {
            return Ok(None);
        }
        let effects = stored
            .iter()
            .map(|s| ActiveEffect::from_stored(s, ALL))
            .collect::<Result<Vec<_>, EffectError>>()
            .map_err(|e| TrainingError::Curriculum(e.to_string()))?;
        Ok(Some(Arc::new(Self::new(effects)?)))
    }

    /// Parameters and switches in turn, with other parameters.
    fn values_with(&self, parameters: &[f64]) -> Vec<Vec<f64>> {
        let mut rest = parameters;
        self.effects
            .iter()
            .map(|active| {
                let (own, next) = rest.split_at(active.effect.info().parameters.len());
                rest = next;
                own.iter().chain(&active.values[own.len()..]).copied().collect()
            })
            .collect()
    }

    /// Mean square of the derivatives of the measured channels of one recording, in their standard deviations,
    /// by the coordinates.
    fn sensitivities(
        &self,
        model: &NetworkJoint,
        values: &[Vec<f64>],
        subject: &Subject,
    ) -> Result<Vec<f64>, ExtensionError> {
        let trial = Trial::new(model, subject);
        let effects: Vec<&dyn AnyEffect> =
            self.effects.iter().map(|a| a.effect as &dyn AnyEffect).collect();
        let count = self.parameters().len();
        let mut squares = Vec::with_capacity(count);
        let mut out = Trajectory::default();
        for first in (0..count).step_by(WIDTH) {
            let mut place = 0;
            let mut seeded: Vec<Derivatives> = Vec::new();
            for (active, values) in self.effects.iter().zip(values) {
                let infos = active.effect.info().parameters;
                for (i, &value) in values.iter().enumerate() {
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
            simulate(&trial, &Base::of(model), &effects, &seeded, &Nuisances::none(), &mut out)
                .map_err(|e| ExtensionError {
                    part: self.effects[0].effect.info().id.into(),
                    message: format!(
                        "on {} {e} with the model that is started from; begin with a stage of derivatives, \
                         or from a trained model",
                        trial.record.source.name
                    ),
                })?;
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
}

impl Extension for EffectExtension {
    fn parameters(&self) -> Vec<ExtensionParameter> {
        self.effects
            .iter()
            .flat_map(|active| {
                let info = active.effect.info();
                info.parameters.iter().zip(&active.values).map(|(p, &start)| ExtensionParameter {
                    name: format!("{}.{}", info.id, p.name),
                    range: p.range,
                    logarithmic: p.logarithmic,
                    start,
                })
            })
            .collect()
    }

    fn units(
        &self,
        model: &NetworkJoint,
        values: &[f64],
        subjects: &[Subject],
    ) -> Result<Vec<f64>, ExtensionError> {
        let by_effect = self.values_with(values);
        let squares: Vec<Vec<f64>> = subjects
            .par_iter()
            .map(|subject| self.sensitivities(model, &by_effect, subject))
            .collect::<Result<_, _>>()?;
        let count = subjects.len().max(1) as f64;
        self.parameters()
            .iter()
            .enumerate()
            .map(|(k, parameter)| {
                let mean = squares.iter().map(|s| s[k]).sum::<f64>() / count;
                let unit = mean.sqrt().recip();
                if unit.is_finite() && unit > 0.0 {
                    return Ok(unit);
                }
                let (part, name) = parameter.name.split_once('.').unwrap_or(("", &parameter.name));
                Err(ExtensionError {
                    part: part.into(),
                    message: format!(
                        "`{name}` = {} changes no prediction of these recordings; start it elsewhere",
                        values[k]
                    ),
                })
            })
            .collect()
    }

    fn engine(
        &self,
        windows: &Windows,
        precision: Precision,
    ) -> Result<Box<dyn ExtendedGradient>, ExtensionError> {
        let whole = windows.since_s.iter().all(|&t| t == 0.0);
        if let Some(active) = self.effects.iter().find(|a| a.effect.remembers() && !whole) {
            return Err(ExtensionError {
                part: active.effect.info().id.into(),
                message: "it depends on what was before, which a window within a recording does not show; \
                          train it on whole recordings, without horizon_s"
                    .into(),
            });
        }
        let effects: Vec<&'static dyn AnyEffect> = self.effects.iter().map(|a| a.effect).collect();
        let values: Vec<f64> = self.effects.iter().flat_map(|a| a.values.clone()).collect();
        Ok(match precision {
            Precision::F32 => Box::new(EffectGradient::<f32>::new(effects, &values, windows)),
            Precision::F64 => Box::new(EffectGradient::<f64>::new(effects, &values, windows)),
        })
    }

    fn stored(&self, values: &[f64]) -> Vec<StoredEffect> {
        let with = self.effects.iter().zip(self.values_with(values));
        with.map(|(a, values)| ActiveEffect { effect: a.effect, values }.stored()).collect()
    }
}
