//! The whole diagnosis.

use super::cause::{Cause, Rank, floor_level, ranking, share};
use super::gain::Gain;
use super::naming::{Named, Naming};
use super::ordinary::Ordinary;
use super::sets::{Blind, HeldOut, JudgedBy, Prepared, Sets};
use super::trace::{Trace, traces};
use super::verdict::Verdict;
use crate::design::{Separation, separate};
use crate::error::DiagnoseError;
use crate::fit::{Floors, Hypothesis};
use crate::residual::ResidualStory;
use crate::search::{Acceptance, Chance, Reference, Scored, Search, Split, gather, noise_floors};
use pam_effects::effects::{ALL, AnyEffect, DataScales};
use pam_effects::model::{ActiveEffect, ExtendedModel};

/// How a diagnosis is made.
#[derive(Debug, Clone)]
pub struct Options {
    /// Effects that may be named.
    pub candidates: Vec<&'static dyn AnyEffect>,
    /// Most effects that are named together.
    pub most: usize,
    /// When an effect earns its place.
    pub acceptance: Acceptance,
    /// Seed of what is kept aside and of the bootstrap.
    pub seed: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self { candidates: ALL.to_vec(), most: 3, acceptance: Acceptance::default(), seed: 1 }
    }
}

impl Options {
    /// The candidate with this id.
    #[must_use]
    pub fn candidate(&self, id: &str) -> Option<&'static dyn AnyEffect> {
        self.candidates.iter().copied().find(|c| c.info().id == id)
    }
}

/// What a diagnosis is busy with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Tabulating the model's force for each recording.
    Preparing,
    /// Learning what is ordinary.
    Healthy,
    /// Trying candidates.
    Searching,
    /// Weighing alternatives and measuring the gain.
    Judging,
}

/// What was found.
#[derive(Debug, Clone)]
pub struct Diagnosis {
    /// The outcome.
    pub verdict: Verdict,
    /// Named causes, the largest share of the error first.
    pub causes: Vec<Cause>,
    /// Every candidate alone, best first.
    pub ranking: Vec<Rank>,
    /// What is wrong before any cause is named.
    pub residual: ResidualStory,
    /// What is left after.
    pub left: ResidualStory,
    /// Errors before and after on what was kept aside.
    pub gain: Gain,
    /// Share of the held-out error above the floors that a flexible correction without names removes.
    pub ceiling: f64,
    /// Share of the same error that the named causes remove.
    pub removed: f64,
    /// The model with what is ordinary and the named causes; the given model if none is named.
    pub extended: ExtendedModel,
    /// What candidates explain by chance; absent if there is no residual.
    pub chance: Option<Chance>,
    /// Share of the weighted residual of the fitted recordings that the named causes explain.
    pub explained: f64,
    /// What is ordinary, if healthy recordings were given.
    pub ordinary: Option<Ordinary>,
    /// What names were chosen by.
    pub judged_by: JudgedBy,
    /// What took no part in naming or fitting.
    pub held_out: HeldOut,
    /// By how many of its samples the force acts earlier than a held one, as fitted beside the named causes:
    /// 0 held, ½ smooth.
    pub force_lead_samples: f64,
    /// Names of the recordings that were fitted in the end.
    pub fitted: Vec<String>,
    /// Errors that count as explained.
    pub floors: Floors,
    /// Magnitudes of the fitted recordings.
    pub scales: DataScales,
    /// The held-out recordings before and after, for figures.
    pub traces: Vec<Trace>,
}

/// Diagnoses recordings with a model. The same seed gives the same answer at any number of threads.
///
/// # Errors
/// [`DiagnoseError`] if there is too little data, or the model itself diverges on them. That nothing is
/// found, or nothing is explained, is no error.
pub fn diagnose(
    model: &ExtendedModel,
    sets: &Sets<'_>,
    options: &Options,
    progress: &(dyn Fn(Stage, f64) + Sync),
) -> Result<Diagnosis, DiagnoseError> {
    progress(Stage::Preparing, 0.0);
    let blind = sets.heldout.map_or(Blind::Kept, Blind::Given);
    let prepared = Prepared::new(model, sets.data, blind, options.seed)?;
    let noise = noise_floors(&prepared.open());
    let ordinary = match sets.healthy {
        Some(healthy) => {
            Some(Ordinary::learn(model, healthy, options, &|s| progress(Stage::Healthy, s))?)
        }
        None => None,
    };
    let floors = ordinary.as_ref().map_or(noise, |o| o.floors(noise));
    let start = model.with(ordinary.iter().flat_map(|o| o.effects.iter().cloned()));
    let fixed: Vec<(&dyn AnyEffect, Vec<f64>)> =
        start.parts().into_iter().map(|(e, v)| (e as &dyn AnyEffect, v)).collect();
    let search = |split| Search {
        split,
        candidates: options.candidates.iter().map(|e| *e as &dyn AnyEffect).collect(),
        scales: gather(&prepared.open(), &model.base()),
    };
    let choosing = search(prepared.split(model.base(), floors));
    let whole = search(Split::fit_all(prepared.whole(model.base(), floors)));
    // The plain model must be able to run at all.
    whole.split.train.errors(&Hypothesis::base(&fixed, whole.split.train.len()))?;
    let diverges =
        || DiagnoseError::TooLittle("the model diverges on the recordings to be fitted".into());
    let found = choosing
        .run(&fixed, options.most, &options.acceptance, &|s| progress(Stage::Searching, s))
        .ok_or_else(diverges)?;
    progress(Stage::Judging, 0.0);
    let base = whole.base(&fixed).ok_or_else(diverges)?;
    let naming = Naming {
        choosing: &choosing,
        whole: &whole,
        found: &found,
        base: &base,
        fixed: &fixed,
        ordinary: ordinary.as_ref(),
        options,
    };
    let named = naming.named()?;
    Ok(measured(model, &start, &prepared, &naming, named))
}

/// The gain, and what is told of it.
fn measured<'e>(
    model: &ExtendedModel,
    start: &ExtendedModel,
    prepared: &Prepared,
    naming: &Naming<'_, 'e>,
    named: Named<'e>,
) -> Diagnosis {
    let (whole, fixed) = (naming.whole, naming.fixed);
    let floors = whole.split.train.floors;
    let best = &named.best;
    let gain_on = Split { held: prepared.blind(model.base(), floors), ..whole.split.clone() };
    let plain = |h: &Hypothesis<'e>| Hypothesis {
        effects: h.effects.clone(),
        fixed: h.fixed,
        values: h.values.clone(),
        ..Hypothesis::base(&[], gain_on.held.len())
    };
    let before = Hypothesis::base(fixed, gain_on.held.len());
    let after = plain(&best.fit.hypothesis);
    let actives: Vec<ActiveEffect> = best
        .fit
        .hypothesis
        .fitted()
        .filter_map(|(e, values)| {
            let effect = naming.options.candidate(e.info().id)?;
            Some(ActiveEffect { effect, values: values.to_vec() })
        })
        .collect();
    let extended = if actives.is_empty() { model.clone() } else { start.with(actives) };
    // Shares of the error on what is blind; a hypothesis that diverges there removes nothing.
    let level = |s: &Scored<'e>| {
        gain_on.held_errors(&s.fit.hypothesis).map_or(f64::INFINITY, |e| e.in_floors(&floors))
    };
    let (level_before, level_after) = (level(naming.base), level(best));
    let lowest = floor_level(level_after);
    let reference = Reference::learn(&gain_on, &naming.base.fit.hypothesis, &floors);
    let ceiling = reference
        .map_or(0.0, |r| share(level_before, r.held.in_floors(&floors).min(level_after), lowest));
    Diagnosis {
        verdict: named.verdict,
        causes: named.causes,
        ranking: ranking(&naming.found.base, &naming.found.singles, &floors),
        residual: ResidualStory::of(
            &whole.split.train,
            &Hypothesis::base(fixed, whole.split.train.len()),
            &floors,
        ),
        left: ResidualStory::of(&whole.split.train, &best.fit.hypothesis, &floors),
        gain: Gain::measure(&gain_on.held, &before, &after, naming.options.seed),
        ceiling,
        removed: share(level_before, level_after, lowest),
        extended,
        chance: named.chance,
        explained: whole.explained(naming.base, best),
        force_lead_samples: best.fit.hypothesis.common.lead_samples,
        ordinary: naming.ordinary.cloned(),
        judged_by: prepared.judged_by.clone(),
        held_out: prepared.held_out.clone().unwrap_or(HeldOut::Given { recordings: Vec::new() }),
        fitted: prepared.open().iter().map(|t| t.record.source.name.clone()).collect(),
        floors,
        scales: whole.scales.clone(),
        traces: traces(&gain_on.held, &before, &after),
    }
}

impl Diagnosis {
    /// Excitations that would tell the first confusable cause from its alternatives, best first; empty if
    /// nothing is confusable.
    #[must_use]
    pub fn design(&self) -> Vec<Separation> {
        let confused = self.causes.iter().find(|c| !c.alternatives.is_empty());
        let Some(cause) = confused else { return Vec::new() };
        let own = self.extended.effects.iter().rfind(|a| a.effect.info().id == cause.effect);
        own.map_or_else(Vec::new, |own| {
            separate(&self.extended, own, &cause.alternatives, &self.scales, &self.floors)
        })
    }

    /// Ids of the named causes.
    #[must_use]
    pub fn named(&self) -> Vec<&'static str> {
        self.causes.iter().map(|c| c.effect).collect()
    }
}
