//! The whole diagnosis.

use super::cause::{Cause, Rank, floor_level, level, ranking, share, words};
use super::gain::Gain;
use super::ordinary::Ordinary;
use super::sets::{HeldOut, Prepared, Sets};
use super::verdict::{Verdict, weigh};
use crate::design::{Separation, separate};
use crate::effects::{ALL, AnyEffect, Evidence};
use crate::error::DiagnoseError;
use crate::extended::{Active, Extended};
use crate::fit::{Floors, Hypothesis, Interval};
use crate::residual::ResidualStory;
use crate::search::{
    Acceptance, Chance, Constancy, Findings, Reference, Scored, Search, gather, noise_floors,
};

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
    pub extended: Extended,
    /// What candidates explain by chance; absent if there is no residual.
    pub chance: Option<Chance>,
    /// Share of the weighted residual of the fitted recordings that the named causes explain.
    pub explained: f64,
    /// What is ordinary, if healthy recordings were given.
    pub ordinary: Option<Ordinary>,
    /// What took no part in naming.
    pub held_out: HeldOut,
    /// Names of the recordings that were fitted.
    pub fitted: Vec<String>,
    /// Errors that count as explained.
    pub floors: Floors,
    /// Magnitudes of the fitted recordings.
    pub evidence: Evidence,
    /// The held-out recordings before and after, for figures.
    pub traces: Vec<Trace>,
}

/// A held-out recording with both predictions, on the grid of the simulation.
#[derive(Debug, Clone)]
pub struct Trace {
    /// Its name.
    pub name: String,
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Force, N.
    pub force_n: Vec<f64>,
    /// Measured channels: mm, mm/s, kPa, kPa.
    pub measured: [Vec<f64>; 4],
    /// Predicted before.
    pub before: [Vec<f64>; 4],
    /// Predicted after.
    pub after: [Vec<f64>; 4],
}

/// Diagnoses recordings with a model. The same seed gives the same answer at any number of threads.
///
/// # Errors
/// [`DiagnoseError`] if there is too little data, or the model itself diverges on them. That nothing is
/// found, or nothing is explained, is no error.
pub fn diagnose(
    model: &Extended,
    sets: &Sets<'_>,
    options: &Options,
    progress: &(dyn Fn(Stage, f64) + Sync),
) -> Result<Diagnosis, DiagnoseError> {
    progress(Stage::Preparing, 0.0);
    let prepared = Prepared::new(model, sets.data, sets.heldout, options.seed)?;
    let noise = noise_floors(&prepared.all());
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
    let search = Search {
        split: prepared.split(model.base(), floors),
        candidates: options.candidates.iter().map(|e| *e as &dyn AnyEffect).collect(),
        evidence: gather(&prepared.train(), &model.base()),
    };
    // The plain model must be able to run at all.
    search.split.train.errors(&Hypothesis::base(&fixed, search.split.train.len()))?;
    let found = search
        .run(&fixed, options.most, &options.acceptance, &|s| progress(Stage::Searching, s))
        .ok_or_else(|| {
            DiagnoseError::TooLittle("the model diverges on the recordings kept aside".into())
        })?;
    progress(Stage::Judging, 0.0);
    judge(model, &start, &fixed, &prepared, &search, &found, ordinary, options)
}

#[allow(clippy::too_many_arguments)]
fn judge<'e>(
    model: &Extended,
    start: &Extended,
    fixed: &[(&'e dyn AnyEffect, Vec<f64>)],
    prepared: &Prepared,
    search: &Search<'_, 'e>,
    found: &Findings<'e>,
    ordinary: Option<Ordinary>,
    options: &Options,
) -> Result<Diagnosis, DiagnoseError> {
    let split = &search.split;
    let floors = split.held.floors;
    let reference = Reference::learn(split, &found.base.fit.hypothesis, &floors);
    let base_level = level(&found.base, &floors);
    let held_base = found.base.held.in_floors(&floors);
    let explainable = reference.map_or(3.0, |r| r.held.in_floors(&floors) / held_base * base_level);
    let mut best = found.best.clone();
    let weighed = |s: &Scored<'e>| {
        let named = s.fit.hypothesis.ids().len();
        weigh(base_level, level(s, &floors), explainable.min(base_level), named)
    };
    let context = Context { fixed, ordinary: ordinary.as_ref(), options };
    let mut causes = causes(search, found, &best, &context)?;
    // A name that stands for something it is not goes; the others are fitted again without it.
    while let Some(place) = causes.iter().position(Cause::mimics) {
        let less = best.fit.hypothesis.without(place);
        best = match split.train.fit(less, 10).ok().and_then(|fit| search.score(fit)) {
            Some(less) if !less.fit.hypothesis.ids().is_empty() => less,
            _ => found.base.clone(),
        };
        causes = self::causes(search, found, &best, &context)?;
    }
    // Names that explain no more than the luckiest candidate would by chance are no names.
    let chance = search.chance(&found.base, options.seed);
    let members = best.fit.hypothesis.ids().len();
    let explained = search.explained(&found.base, &best);
    if chance.is_some_and(|c| members > 0 && explained <= c.of_set(members)) {
        best = found.base.clone();
        causes.clear();
    }
    let mut verdict = weighed(&best);
    if verdict == Verdict::NothingFound && !found.best.fit.hypothesis.ids().is_empty() {
        verdict = Verdict::Unexplained;
    }
    if verdict == Verdict::Unexplained {
        best = found.base.clone();
        causes.clear();
    }
    let plain = |h: &Hypothesis<'e>| Hypothesis {
        effects: h.effects.clone(),
        fixed: h.fixed,
        values: h.values.clone(),
        ..Hypothesis::base(&[], split.held.len())
    };
    let before = Hypothesis::base(fixed, split.held.len());
    let after = plain(&best.fit.hypothesis);
    let gain = Gain::measure(&split.held, &before, &after, options.seed);
    let named: Vec<Active> = best
        .fit
        .hypothesis
        .fitted()
        .filter_map(|(e, values)| {
            Some(Active { effect: options.candidate(e.info().id)?, values: values.to_vec() })
        })
        .collect();
    causes.sort_by(|a, b| b.share_of_error_removed.total_cmp(&a.share_of_error_removed));
    let extended = if named.is_empty() { model.clone() } else { start.with(named) };
    let held_level = |s: &Scored<'_>| s.held.in_floors(&floors);
    let lowest = floor_level(held_level(&best));
    Ok(Diagnosis {
        verdict,
        causes,
        ranking: ranking(&found.base, &found.singles, &floors),
        residual: ResidualStory::of(
            &split.train,
            &Hypothesis::base(fixed, split.train.len()),
            &floors,
        ),
        left: ResidualStory::of(&split.train, &best.fit.hypothesis, &floors),
        gain,
        ceiling: reference.map_or(0.0, |r| share(held_base, r.held.in_floors(&floors), lowest)),
        removed: share(held_base, held_level(&best), lowest),
        extended,
        chance,
        explained: search.explained(&found.base, &best),
        ordinary,
        held_out: prepared.held_out.clone(),
        fitted: prepared.train().iter().map(|t| t.source.name.clone()).collect(),
        floors,
        evidence: search.evidence.clone(),
        traces: traces(search, &before, &after),
    })
}

/// What the weighing of causes needs besides the search.
struct Context<'c, 'e> {
    fixed: &'c [(&'e dyn AnyEffect, Vec<f64>)],
    ordinary: Option<&'c Ordinary>,
    options: &'c Options,
}

fn causes<'e>(
    search: &Search<'_, 'e>,
    found: &Findings<'e>,
    best: &Scored<'e>,
    context: &Context<'_, 'e>,
) -> Result<Vec<Cause>, DiagnoseError> {
    let members = best.fit.hypothesis.ids().len();
    if members == 0 {
        return Ok(Vec::new());
    }
    let floors = &search.split.held.floors;
    let mut intervals = search.split.train.intervals(&best.fit)?.into_iter();
    let named_level = level(best, floors);
    let lowest = floor_level(named_level);
    let fitted: Vec<&dyn AnyEffect> = best.fit.hypothesis.fitted().map(|f| f.0).collect();
    Ok((0..members)
        .map(|place| {
            let (effect, what, excited_by) = words(fitted[place]);
            let own: Vec<Interval> =
                intervals.by_ref().take(fitted[place].info().parameters.len()).collect();
            let constancy = search.constancy(best, place);
            let parameters =
                honest_intervals(search, best, place, &own, constancy.as_ref(), context);
            let without = if members == 1 {
                level(&found.base, floors)
            } else {
                let less = best.fit.hypothesis.without(place);
                let scored = search.split.train.fit(less, 6).ok().and_then(|f| search.score(f));
                scored.map_or(named_level, |s| level(&s, floors))
            };
            let whole = (level(&found.base, floors) - lowest).max(1e-9);
            let alternatives: Vec<Active> = search
                .confusable(&found.base, best, place, &found.singles)
                .into_iter()
                .filter_map(|(id, values)| {
                    Some(Active { effect: context.options.candidate(id)?, values })
                })
                .collect();
            Cause {
                effect,
                what,
                parameters,
                share_of_error_removed: ((without - named_level) / whole).clamp(0.0, 1.0),
                confusable_with: alternatives.iter().map(|a| a.effect.info().id).collect(),
                alternatives,
                excited_by,
                constancy,
            }
        })
        .collect())
}

/// The intervals of an effect's parameters with what the scatter of the residuals does not show: errors of the
/// model that change from part to part, what the effect seems to be on healthy recordings, and other shapes
/// of the same effect that fit as well.
fn honest_intervals<'e>(
    search: &Search<'_, 'e>,
    best: &Scored<'e>,
    place: usize,
    own: &[Interval],
    constancy: Option<&Constancy>,
    context: &Context<'_, 'e>,
) -> Vec<(&'static str, Interval)> {
    let h = &best.fit.hypothesis;
    let at = h.fixed + place;
    let (effect, values) = (h.effects[at], &h.values[h.value_range(at)]);
    let infos = effect.info().parameters;
    let apparent = context
        .ordinary
        .and_then(|o| o.apparent(search.split.train.base, context.fixed, effect, values));
    let mut intervals: Vec<Interval> = own
        .iter()
        .zip(infos)
        .enumerate()
        .map(|(k, (interval, info))| {
            let parts = constancy.and_then(|c| c.half_widths.get(k)).copied().unwrap_or(0.0);
            let healthy = match (&apparent, info.off) {
                (Some(seems), Some(off)) => 1.96 * (seems[k] - off).abs(),
                _ => 0.0,
            };
            // A healthy recording cannot make more of a number than the number itself.
            interval.widened(parts.hypot(healthy.min(interval.value.abs())), *info)
        })
        .collect();
    for shape in search.other_shapes(best, place) {
        for (interval, value) in intervals.iter_mut().zip(shape) {
            interval.ci95 = [interval.ci95[0].min(value), interval.ci95[1].max(value)];
        }
    }
    infos.iter().map(|p| p.name).zip(intervals).collect()
}

fn traces<'e>(
    search: &Search<'_, 'e>,
    before: &Hypothesis<'e>,
    after: &Hypothesis<'e>,
) -> Vec<Trace> {
    let problem = &search.split.held;
    (0..problem.len())
        .filter_map(|i| {
            let (t, window) = (problem.trials[i], problem.windows[i].clone());
            let run = |h: &Hypothesis<'e>| {
                let mut out = crate::simulation::Trajectory::default();
                problem.simulate(h, i, &mut out).ok()?;
                Some(out.channels.map(|c| c[window.clone()].to_vec()))
            };
            let force = t.force.values_mn();
            Some(Trace {
                name: t.source.name.clone(),
                time_s: window.clone().map(|k| t.source.start_s + k as f64 * t.step_s).collect(),
                force_n: window.clone().map(|k| force[2 * k] / pam_core::units::MN_PER_N).collect(),
                measured: [0, 1, 2, 3].map(|c| t.measured[c][window.clone()].to_vec()),
                before: run(before)?,
                after: run(after)?,
            })
        })
        .collect()
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
            separate(&self.extended, own, &cause.alternatives, &self.evidence, &self.floors)
        })
    }

    /// Ids of the named causes.
    #[must_use]
    pub fn named(&self) -> Vec<&'static str> {
        self.causes.iter().map(|c| c.effect).collect()
    }
}
