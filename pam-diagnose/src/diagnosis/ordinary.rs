//! What is ordinary: the error of the model on recordings on which it was validated.

use super::run::Options;
use super::sets::{Blind, Prepared};
use crate::error::DiagnoseError;
use crate::fit::{Floors, Hypothesis};
use crate::search::{Search, Split, gather, noise_floors};
use pam_data::Subject;
use pam_effects::effects::AnyEffect;
use pam_effects::model::{ActiveEffect, ExtendedModel};
use pam_effects::simulation::Base;
use std::sync::Arc;

/// Effects and error level of healthy recordings. A model that misses something small everywhere misses it
/// in the data under diagnosis as well; that is not what is asked for.
#[derive(Debug, Clone)]
pub struct Ordinary {
    /// Effects that the healthy recordings show; part of the model from there on.
    pub effects: Vec<ActiveEffect>,
    /// Root mean square errors that are left then: mm, kPa, kPa.
    pub rms: [f64; 3],
    /// Names of the healthy recordings.
    pub recordings: Vec<String>,
    /// The recordings themselves.
    pub(super) prepared: Arc<Prepared>,
}

impl Ordinary {
    /// Learns what is ordinary.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the recordings are too short or the model diverges on them.
    pub fn learn(
        model: &ExtendedModel,
        healthy: &[Subject],
        options: &Options,
        done: &(dyn Fn(f64) + Sync),
    ) -> Result<Self, DiagnoseError> {
        let prepared = Prepared::new(model, healthy, Blind::Nothing, options.seed)?;
        let floors = noise_floors(&prepared.open());
        let search = Search {
            split: prepared.split(model.base(), floors),
            // Effects of the vocabulary only: a candidate of the user's is what is asked about.
            candidates: pam_effects::effects::ALL.iter().map(|e| *e as &dyn AnyEffect).collect(),
            scales: gather(&prepared.open(), &model.base()),
        };
        let parts = model.parts();
        let fixed: Vec<(&dyn AnyEffect, Vec<f64>)> =
            parts.iter().map(|(e, v)| (*e as &dyn AnyEffect, v.clone())).collect();
        let found = search.run(&fixed, options.most.max(2), &options.acceptance, done).ok_or_else(
            || DiagnoseError::TooLittle("the model diverges on the healthy recordings".into()),
        )?;
        let whole = Search {
            split: Split::fit_all(prepared.whole(model.base(), floors)),
            candidates: search.candidates.clone(),
            scales: search.scales.clone(),
        };
        let settled = whole.settle(&found, &options.acceptance);
        // What judges has no uncertain numbers of its own: the level of both, as in the data to come.
        let level = settled.as_ref().map_or(&found.best, |s| &s.chosen);
        let left = level.fit.errors.and(&level.held);
        let best = settled.as_ref().map_or(&found.best, |s| &s.whole);
        let effects = best
            .fit
            .hypothesis
            .fitted()
            .filter_map(|(e, values)| {
                let effect = pam_effects::effects::by_id(e.info().id)?;
                Some(ActiveEffect { effect, values: values.to_vec() })
            })
            .collect();
        Ok(Self {
            effects,
            rms: left.mean().map(f64::sqrt),
            recordings: prepared.open().iter().map(|t| t.record.source.name.clone()).collect(),
            prepared: Arc::new(prepared),
        })
    }

    /// Floors with what is ordinary on top of the noise.
    #[must_use]
    pub fn floors(&self, noise: Floors) -> Floors {
        Floors([0, 1, 2].map(|c| noise.0[c].hypot(self.rms[c])))
    }

    /// What an effect seems to be on the healthy recordings, where it is not: its fitted values beside the
    /// ordinary effects, with scales as they were found. `None` if it cannot be fitted there.
    pub(super) fn apparent(
        &self,
        base: Base<f64>,
        fixed: &[(&dyn AnyEffect, Vec<f64>)],
        effect: &dyn AnyEffect,
        values: &[f64],
    ) -> Option<Vec<f64>> {
        let problem = self.prepared.whole(base, noise_floors(&self.prepared.open()));
        let start = Hypothesis::base(fixed, problem.len()).with(effect, values);
        let fit = problem.fit(start, 6).ok()?;
        let h = &fit.hypothesis;
        Some(h.values[h.value_range(h.effects.len() - 1)].to_vec())
    }
}
