//! From what a search found to names that stand, and the verdict.

use super::cause::{Cause, floor_level, level, words};
use super::ordinary::Ordinary;
use super::run::Options;
use super::verdict::{Verdict, weigh};
use crate::error::DiagnoseError;
use crate::fit::Interval;
use crate::search::{Chance, Constancy, Findings, Reference, Scored, Search, Settled};
use pam_effects::effects::AnyEffect;
use pam_effects::model::ActiveEffect;

/// What the weighing of names needs.
pub(super) struct Naming<'n, 'e> {
    /// The search that chose: a part is fitted, the rest judges.
    pub(super) choosing: &'n Search<'n, 'e>,
    /// All that may be fitted.
    pub(super) whole: &'n Search<'n, 'e>,
    /// What the search found.
    pub(super) found: &'n Findings<'e>,
    /// The base model on all that may be fitted.
    pub(super) base: &'n Scored<'e>,
    /// Effects that are part of the model.
    pub(super) fixed: &'n [(&'e dyn AnyEffect, Vec<f64>)],
    pub(super) ordinary: Option<&'n Ordinary>,
    pub(super) options: &'n Options,
}

/// Names with their verdict.
pub(super) struct Named<'e> {
    pub(super) verdict: Verdict,
    /// The largest share of the error first.
    pub(super) causes: Vec<Cause>,
    /// The base model if nothing is named.
    pub(super) best: Scored<'e>,
    pub(super) chance: Option<Chance>,
}

impl<'e> Naming<'_, 'e> {
    /// Settles on a set, refutes names that stand for something else, and weighs what is left.
    pub(super) fn named(&self) -> Result<Named<'e>, DiagnoseError> {
        let mut set = self.whole.settle(self.found, &self.options.acceptance);
        let mut causes = self.causes(set.as_ref())?;
        // A name that stands for something else, or for nothing, goes; the others are fitted again without it.
        let mut mimicked = false;
        let refuted = |c: &Cause| c.mimics() || self.may_be_absent(c);
        while let (Some(s), Some(place)) = (&set, causes.iter().position(refuted)) {
            mimicked |= causes[place].mimics() && !self.may_be_absent(&causes[place]);
            set = self
                .whole
                .settle_without(self.choosing, s, place)
                .filter(|less| !less.whole.fit.hypothesis.ids().is_empty());
            causes = self.causes(set.as_ref())?;
        }
        // Names that explain no more than the luckiest candidate would by chance are no names.
        let chance = self.whole.chance(self.base, self.options.seed);
        set = set.filter(|s| {
            let members = s.whole.fit.hypothesis.ids().len();
            let explained = self.whole.explained(self.base, &s.whole);
            chance.is_none_or(|c| explained > c.of_set(members))
        });
        let mut verdict = self.weighed(set.as_ref());
        // What a name stood for in vain is there all the same.
        if verdict == Verdict::NothingFound && mimicked {
            verdict = Verdict::Unexplained;
        }
        if verdict == Verdict::Unexplained {
            set = None;
        }
        match set {
            Some(s) => {
                causes
                    .sort_by(|a, b| b.share_of_error_removed.total_cmp(&a.share_of_error_removed));
                Ok(Named { verdict, causes, best: s.whole, chance })
            }
            None => Ok(Named { verdict, causes: Vec::new(), best: self.base.clone(), chance }),
        }
    }

    fn weighed(&self, set: Option<&Settled<'e>>) -> Verdict {
        let split = &self.choosing.split;
        let floors = &split.held.floors;
        let base_level = level(self.base, floors);
        let judged = self.found.base.held.in_floors(floors);
        let reference = Reference::learn(split, &self.found.base.fit.hypothesis, floors);
        let explainable = reference.map_or(3.0, |r| r.held.in_floors(floors) / judged * base_level);
        let (named, members) = match set {
            Some(s) => (level(&s.whole, floors), s.whole.fit.hypothesis.ids().len()),
            None => (base_level, 0),
        };
        weigh(base_level, named, explainable.min(base_level), members)
    }

    fn causes(&self, set: Option<&Settled<'e>>) -> Result<Vec<Cause>, DiagnoseError> {
        let Some(set) = set else { return Ok(Vec::new()) };
        let best = &set.whole;
        let problem = &self.whole.split.train;
        let members = best.fit.hypothesis.ids().len();
        let mut intervals = problem.intervals(&best.fit)?.into_iter();
        let floors = &problem.floors;
        let named_level = level(best, floors);
        let base_level = level(self.base, floors);
        let fitted: Vec<&dyn AnyEffect> = best.fit.hypothesis.fitted().map(|f| f.0).collect();
        Ok((0..members)
            .map(|place| {
                let (effect, what, excited_by) = words(fitted[place]);
                let own: Vec<Interval> =
                    intervals.by_ref().take(fitted[place].info().parameters.len()).collect();
                let constancy = self.whole.constancy(best, place);
                let parameters = self.honest_intervals(best, place, &own, constancy.as_ref());
                let without = if members == 1 {
                    base_level
                } else {
                    let less = best.fit.hypothesis.without(place);
                    let scored = problem.fit(less, 6).ok().and_then(|f| self.whole.score(f));
                    scored.map_or(named_level, |s| level(&s, floors))
                };
                let removable = (base_level - floor_level(named_level)).max(1e-9);
                let alternatives: Vec<ActiveEffect> = self
                    .choosing
                    .confusable(&self.found.base, &set.chosen, place, &self.found.singles)
                    .into_iter()
                    .filter_map(|(id, values)| {
                        Some(ActiveEffect { effect: self.options.candidate(id)?, values })
                    })
                    .collect();
                Cause {
                    effect,
                    what,
                    parameters,
                    share_of_error_removed: ((without - named_level) / removable).clamp(0.0, 1.0),
                    confusable_with: alternatives.iter().map(|a| a.effect.info().id).collect(),
                    alternatives,
                    excited_by,
                    constancy,
                }
            })
            .collect())
    }

    /// Whether the honest intervals hold that there is no such effect: every parameter that could switch it off
    /// may be off. The scatter of the residuals alone spoke for it, or it would not be in the set; errors of
    /// the model that change from part to part, or what the effect seems to be on healthy recordings, are as
    /// large as it is.
    fn may_be_absent(&self, cause: &Cause) -> bool {
        let Some(effect) = self.options.candidate(cause.effect) else { return false };
        let mut offs = effect
            .info()
            .parameters
            .iter()
            .zip(&cause.parameters)
            .filter_map(|(info, (_, interval))| Some((info.off?, interval.ci95)))
            .peekable();
        offs.peek().is_some() && offs.all(|(off, [low, high])| low <= off && off <= high)
    }

    /// The intervals of an effect's parameters with what the scatter of the residuals does not show: errors
    /// of the model that change from part to part, what the effect seems to be on healthy recordings, and
    /// other shapes of the same effect that fit as well.
    fn honest_intervals(
        &self,
        best: &Scored<'e>,
        place: usize,
        own: &[Interval],
        constancy: Option<&Constancy>,
    ) -> Vec<(&'static str, Interval)> {
        let h = &best.fit.hypothesis;
        let at = h.fixed + place;
        let (effect, values) = (h.effects[at], &h.values[h.value_range(at)]);
        let infos = effect.info().parameters;
        let base = self.whole.split.train.base;
        let apparent = self.ordinary.and_then(|o| o.apparent(base, self.fixed, effect, values));
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
        for shape in self.whole.other_shapes(best, place) {
            for (interval, value) in intervals.iter_mut().zip(shape) {
                interval.ci95 = [interval.ci95[0].min(value), interval.ci95[1].max(value)];
            }
        }
        infos.iter().map(|p| p.name).zip(intervals).collect()
    }
}
