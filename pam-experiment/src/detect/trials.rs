//! Limits by trials: whole diagnoses of recordings with an effect in them, made by simulation.
//!
//! Which cause a diagnosis names depends on all of its tests, on rival effects and on chance, which no noncentrality predicts. Each trial
//! puts the effect at one magnitude into recordings ([`Synthesis`]) and diagnoses them; the outcomes so far choose the next magnitude
//! ([`LimitPosterior`]).

use super::posterior::LimitPosterior;
use super::ray::Ray;
use crate::error::ExperimentError;
use crate::plan::Synthesis;
use pam_data::Subject;
use pam_diagnose::{DiagnoseOptions, RecordingSets, diagnose};
use pam_effects::effects::AnyEffect;
use pam_effects::{ActiveEffect, ExtendedModel};
use serde::{Deserialize, Serialize};

/// A diagnosis of recordings with the effect in them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LimitTrial {
    /// The value of the effect's parameter.
    pub value: f64,
    /// The magnitude along the effect's way.
    #[serde(default, skip_serializing)]
    pub magnitude: f64,
    /// Whether the effect was named, or was confusable with a named one.
    pub named: bool,
    /// Ids of the named causes, and of those confusable with them.
    pub names: Vec<String>,
}

/// A limit as trials show it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TriedLimit {
    /// The trials, in their order.
    pub trials: Vec<LimitTrial>,
    /// 95 % credible interval of the parameter's value at the limit.
    pub interval: [f64; 2],
    /// The magnitude at the limit: the median of the posterior.
    #[serde(default, skip_serializing)]
    pub magnitude: f64,
}

/// What trials are made with.
pub(super) struct Trials<'a> {
    pub(super) model: &'a ExtendedModel,
    /// The recordings of which others are made.
    pub(super) recordings: &'a [Subject],
    pub(super) synthesis: &'a Synthesis,
    pub(super) diagnosis: &'a DiagnoseOptions,
    pub(super) power: f64,
    pub(super) count: usize,
}

impl Trials<'_> {
    /// Tries an effect about an expected limit; `done` is called after each trial. `place` tells its trials from those of other
    /// effects.
    pub(super) fn of(
        &self,
        (effect, ray): (&'static dyn AnyEffect, &Ray),
        expected: f64,
        place: usize,
        done: &(dyn Fn() + Sync),
    ) -> TriedLimit {
        let mut posterior = LimitPosterior::about(expected, self.power);
        let mut trials = Vec::new();
        for k in 0..self.count {
            let magnitude = ray.within_range(posterior.next_magnitude());
            let active = ActiveEffect { effect, values: ray.values(magnitude) };
            let seed = (self.diagnosis.seed.wrapping_mul(1_000_003))
                .wrapping_add((place * self.count + k) as u64);
            let names = self.names(&active, seed);
            done();
            // Where the simulation or the diagnosis fails, nothing is learned of the limit.
            let Ok(names) = names else { continue };
            let named = names.iter().any(|n| n == ray.effect);
            posterior.learn(magnitude, named);
            trials.push(LimitTrial { value: ray.value(magnitude), magnitude, named, names });
        }
        let value = |share| ray.value(ray.within_range(posterior.quantile(share)));
        let mut interval = [value(0.025), value(0.975)];
        interval.sort_by(f64::total_cmp);
        TriedLimit { trials, interval, magnitude: posterior.quantile(0.5) }
    }

    fn names(&self, effect: &ActiveEffect, seed: u64) -> Result<Vec<String>, ExperimentError> {
        let data = self.synthesis.set(Some(effect), seed)?;
        let options = DiagnoseOptions { seed, law: false, ladder: None, ..self.diagnosis.clone() };
        let baseline = self.diagnosis.discrepancy.as_ref().map(|_| self.recordings);
        let sets = RecordingSets { data: &data, test: None, baseline };
        let found = diagnose(self.model, &sets, &options, &|_, _| {})?;
        let mut names: Vec<String> = Vec::new();
        for cause in &found.causes {
            names.push(cause.effect.clone());
            names.extend(cause.confusable_with.iter().cloned());
        }
        Ok(names)
    }
}

impl TriedLimit {
    /// How often the other effect was named, or not distinguished from a name, in trials in which the hidden effect was named at
    /// `multiples` of its limit or more, of how many; `None` if of none.
    #[must_use]
    pub fn confusions(&self, other: &str, multiples: f64) -> Option<[usize; 2]> {
        let own =
            self.trials.iter().filter(|t| t.named && t.magnitude >= multiples * self.magnitude);
        let counts = own.fold([0, 0], |[confused, all], t| {
            [confused + usize::from(t.names.iter().any(|n| n == other)), all + 1]
        });
        (counts[1] > 0).then_some(counts)
    }
}
