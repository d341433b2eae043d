//! The effects that act in one experiment, their values, and shares of them.

use crate::fit::Member;
use crate::onset::Acts;
use pam_effects::effects::{AnyEffect, ParameterInfo, timed};
use pam_effects::model::ActiveEffect;

/// Effects in an experiment.
pub(super) struct Parts<'s> {
    pub(super) effects: Vec<&'s dyn AnyEffect>,
    /// All their values.
    pub(super) values: Vec<f64>,
    /// Of each member the place of each of its values among all; `None` for a value that this experiment does not have.
    pub(super) places: Vec<Vec<Option<usize>>>,
}

impl<'s> Parts<'s> {
    pub(super) fn add_always(&mut self, effect: &'s dyn AnyEffect, member: &Member) {
        let first = self.values.len();
        self.effects.push(effect);
        self.values.extend(&member.values);
        self.places.push((first..self.values.len()).map(Some).collect());
    }

    pub(super) fn add(
        &mut self,
        effect: &'static dyn AnyEffect,
        member: &Member,
        experiment: usize,
    ) {
        let first = self.values.len();
        let (own, times) = (member.own(), member.times());
        let acts = member.schedule.as_ref().map_or(Acts::Always, |s| s.acts[experiment]);
        let mut places: Vec<Option<usize>> = vec![None; member.values.len()];
        match acts {
            Acts::Never => {}
            Acts::Always => {
                self.effects.push(effect);
                self.values.extend(own);
                for (k, place) in places.iter_mut().take(own.len()).enumerate() {
                    *place = Some(first + k);
                }
            }
            Acts::Within(course, from) => {
                let (parameters, count) = (effect.info().parameters.len(), course.time_len());
                self.effects.push(timed(effect, course));
                self.values.extend(&own[..parameters]);
                self.values.extend(&times[from..from + count]);
                self.values.extend(&own[parameters..]);
                for (k, place) in places.iter_mut().take(own.len()).enumerate() {
                    *place = Some(first + k + if k < parameters { 0 } else { count });
                }
                for (k, place) in places.iter_mut().skip(own.len() + from).take(count).enumerate() {
                    *place = Some(first + parameters + k);
                }
            }
        }
        self.places.push(places);
    }
}

/// The difference of each magnitude of an effect from its off value; 0 for its other values.
pub(super) fn magnitudes(effect: &ActiveEffect) -> Vec<f64> {
    let infos = effect.effect.info().parameters.iter().map(Some).chain(std::iter::repeat(None));
    let magnitude = |(value, info): (&f64, Option<&ParameterInfo>)| {
        info.and_then(|p| p.off).map_or(0.0, |off| value - off)
    };
    effect.values.iter().zip(infos).map(magnitude).collect()
}

/// A share of an effect.
pub(super) fn in_part(effect: &ActiveEffect, share: f64) -> ActiveEffect {
    let magnitudes = magnitudes(effect);
    let missing = magnitudes.iter().map(|magnitude| (1.0 - share) * magnitude);
    let values = effect.values.iter().zip(missing).map(|(value, missing)| value - missing);
    ActiveEffect { effect: effect.effect, values: values.collect() }
}
