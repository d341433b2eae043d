//! A set of candidates with values.

use crate::onset::Schedule;
use crate::search::{Candidates, Nuisance};
use pam_vocabulary::ParameterInfo;
use std::sync::Arc;

/// A candidate with its values.
#[derive(Debug, Clone, PartialEq)]
pub struct Member {
    /// Index of the candidate.
    pub candidate: usize,
    /// Its values: parameters, then switches; behind them the times of its schedule.
    pub values: Vec<f64>,
    /// When it acts, if not always.
    pub schedule: Option<Arc<Schedule>>,
    /// True if a fit changes its magnitudes only and keeps its length scales, time constants and cutoff frequencies.
    pub scales_held: bool,
}

impl Member {
    /// A candidate that is always there.
    #[must_use]
    pub fn always(candidate: usize, values: &[f64]) -> Self {
        Self { candidate, values: values.to_vec(), schedule: None, scales_held: false }
    }

    /// Number of the times behind its own values.
    fn time_len(&self) -> usize {
        self.schedule.as_ref().map_or(0, |s| s.times.len())
    }

    /// Its own values, without the times.
    #[must_use]
    pub fn own(&self) -> &[f64] {
        &self.values[..self.values.len() - self.time_len()]
    }

    /// The times of its schedule.
    #[must_use]
    pub fn times(&self) -> &[f64] {
        &self.values[self.values.len() - self.time_len()..]
    }

    /// The same with other values of its own and the times as they are.
    #[must_use]
    pub fn with_own(&self, own: &[f64]) -> Self {
        Self { values: [own, self.times()].concat(), ..self.clone() }
    }

    /// Places and descriptions of the values that are fitted: the candidate's parameters, then the times.
    pub(crate) fn fitted<C: Candidates + ?Sized>(&self, system: &C) -> Vec<(usize, ParameterInfo)> {
        let own = system.candidate(self.candidate).parameters.iter().copied().enumerate();
        let own = own.filter(|(_, p)| !self.scales_held || is_magnitude(p));
        let times = self.schedule.as_ref().filter(|s| s.fitted).map_or(&[][..], |s| &s.times);
        own.chain((self.own().len()..).zip(times.iter().copied())).collect()
    }
}

/// True for a parameter that sets the strength of an effect, such as a force or a gain; false for length scales, time constants and
/// cutoff frequencies.
pub(crate) fn is_magnitude(p: &ParameterInfo) -> bool {
    p.off.is_some() && !p.logarithmic
}

/// Candidates with their values, and the nuisance values.
#[derive(Debug, Clone, PartialEq)]
pub struct Hypothesis {
    /// The members, in the order in which they act; the first [`fixed`](Self::fixed) of them are not fitted.
    pub members: Vec<Member>,
    /// Number of leading members that keep their values.
    pub fixed: usize,
    /// Nuisance values that all experiments share.
    pub shared: Vec<f64>,
    /// Nuisance values of each experiment.
    pub locals: Vec<Vec<f64>>,
}

/// A fitted parameter: which value of which member, and its description.
pub(crate) struct FittedParameter {
    pub(crate) member: usize,
    pub(crate) value: usize,
    pub(crate) info: ParameterInfo,
}

impl Hypothesis {
    /// The system without any candidate and with all nuisances at zero, for a number of experiments.
    #[must_use]
    pub fn base<C: Candidates + ?Sized>(system: &C, experiments: usize) -> Self {
        Self {
            members: Vec::new(),
            fixed: 0,
            shared: vec![0.0; system.shared().len()],
            locals: vec![vec![0.0; system.local().len()]; experiments],
        }
    }

    /// The same with the nuisances of its own experiments at the prior mean, and those that all share as fitted.
    #[must_use]
    pub fn without_locals<C: Candidates + ?Sized>(&self, system: &C, experiments: usize) -> Self {
        Self { locals: vec![vec![0.0; system.local().len()]; experiments], ..self.clone() }
    }

    /// The same with one more candidate.
    #[must_use]
    pub fn with(&self, candidate: usize, values: &[f64]) -> Self {
        let mut more = self.clone();
        more.members.push(Member::always(candidate, values));
        more
    }

    /// The same with another member behind the others.
    #[must_use]
    pub fn with_member(&self, member: Member) -> Self {
        let mut more = self.clone();
        more.members.push(member);
        more
    }

    /// The same without the member at this place.
    #[must_use]
    pub fn without(&self, place: usize) -> Self {
        let mut less = self.clone();
        less.members.remove(place);
        less
    }

    /// The same with the magnitudes of the member at `place` multiplied by a factor, from the values at which they are off.
    pub(crate) fn with_magnitudes<C: Candidates + ?Sized>(
        &self,
        system: &C,
        place: usize,
        factor: f64,
    ) -> Self {
        let infos = system.candidate(self.members[place].candidate).parameters;
        let magnitudes = (0..infos.len()).filter(|&k| is_magnitude(&infos[k]));
        self.with_multiples(system, place, magnitudes, factor)
    }

    /// The same with each of the fitted parameters of the member at `place` multiplied by a factor, and with all magnitudes, if it has
    /// several.
    pub(super) fn scaled<C: Candidates + ?Sized>(
        &self,
        system: &C,
        place: usize,
        factor: f64,
    ) -> Vec<Self> {
        let member = &self.members[place];
        let own = member.fitted(system).into_iter().filter(|(k, _)| *k < member.own().len());
        let own: Vec<(usize, ParameterInfo)> = own.collect();
        let one = |k| self.with_multiples(system, place, std::iter::once(k), factor);
        let mut all: Vec<Self> = own.iter().map(|(k, _)| one(*k)).collect();
        if own.iter().filter(|(_, info)| is_magnitude(info)).count() > 1 {
            all.push(self.with_magnitudes(system, place, factor));
        }
        all
    }

    /// The same with some parameters of the member at `place` multiplied by a factor, within their ranges and above their lower
    /// bounds.
    fn with_multiples<C: Candidates + ?Sized>(
        &self,
        system: &C,
        place: usize,
        parameters: impl Iterator<Item = usize>,
        factor: f64,
    ) -> Self {
        let mut other = self.clone();
        let infos = system.candidate(self.members[place].candidate).parameters;
        for k in parameters {
            let (off, [low, high]) = (infos[k].off.unwrap_or(0.0), infos[k].range);
            let value = &mut other.members[place].values[k];
            *value = (off + factor * (*value - off)).clamp(low, high);
        }
        other.raise_to_bounds(system);
        other
    }

    /// Raises parameters below their lower bound ([`ParameterInfo::not_below`]) to it.
    fn raise_to_bounds<C: Candidates + ?Sized>(&mut self, system: &C) {
        for member in self.members.iter_mut().skip(self.fixed) {
            for (k, info) in system.candidate(member.candidate).parameters.iter().enumerate() {
                if let Some(other) = info.not_below {
                    member.values[k] = member.values[k].max(member.values[other]);
                }
            }
        }
    }

    /// The candidates of the members in ascending order: two hypotheses with the same set have the same.
    #[must_use]
    pub fn set(&self) -> Vec<usize> {
        let mut set: Vec<usize> = self.members.iter().map(|m| m.candidate).collect();
        set.sort_unstable();
        set
    }

    /// Whether a candidate is a member.
    #[must_use]
    pub fn contains(&self, candidate: usize) -> bool {
        self.members.iter().any(|m| m.candidate == candidate)
    }

    /// The fitted parameters, member by member.
    pub(crate) fn parameters<C: Candidates + ?Sized>(&self, system: &C) -> Vec<FittedParameter> {
        let fitted = self.members.iter().enumerate().skip(self.fixed);
        fitted
            .flat_map(|(member, m)| {
                let fitted = m.fitted(system).into_iter();
                fitted.map(move |(value, info)| FittedParameter { member, value, info })
            })
            .collect()
    }

    /// Standard deviation of the prior of each fitted parameter, and by how much it differs from its mean.
    pub(super) fn parameter_priors<C: Candidates + ?Sized>(&self, system: &C) -> Vec<[f64; 2]> {
        let prior = |p: FittedParameter| {
            let member = &self.members[p.member];
            let deviation = system.parameter_deviation(member.candidate, p.value);
            [deviation, member.values[p.value] - p.info.off.unwrap_or(0.0)]
        };
        self.parameters(system).into_iter().map(prior).collect()
    }

    /// The hypothesis after a step in its unknowns: parameters, shared nuisances, then those of each experiment. A
    /// logarithmic parameter moves by at most `largest_log_step`. A parameter that would fall below its lower bound
    /// ([`ParameterInfo::not_below`]) is raised to it.
    pub(super) fn moved<C: Candidates + ?Sized>(
        &self,
        system: &C,
        step: &[f64],
        largest_log_step: f64,
    ) -> Self {
        let mut to = self.clone();
        let parameters = self.parameters(system);
        for (p, &change) in parameters.iter().zip(step) {
            let change = if p.info.logarithmic {
                change.clamp(-largest_log_step, largest_log_step)
            } else {
                change
            };
            let value = &mut to.members[p.member].values[p.value];
            *value = from_coordinate(coordinate(*value, p.info) + change, p.info);
        }
        to.raise_to_bounds(system);
        let moved = |values: &mut [f64], nuisances: &[Nuisance], change: &[f64]| {
            for ((v, n), d) in values.iter_mut().zip(nuisances).zip(change) {
                *v = (*v + d).clamp(n.limits[0], n.limits[1]);
            }
        };
        let (shared, locals) = step[parameters.len()..].split_at(self.shared.len());
        moved(&mut to.shared, system.shared(), shared);
        let len = system.local().len().max(1);
        for (local, change) in to.locals.iter_mut().zip(locals.chunks_exact(len)) {
            moved(local, system.local(), change);
        }
        to
    }
}

/// A value in the coordinate in which it is fitted.
pub(crate) fn coordinate(value: f64, info: ParameterInfo) -> f64 {
    if info.logarithmic { value.max(1e-300).ln() } else { value }
}

/// The inverse of [`coordinate`], kept inside the parameter's range.
fn from_coordinate(at: f64, info: ParameterInfo) -> f64 {
    let value = if info.logarithmic { at.exp() } else { at };
    value.clamp(info.range[0], info.range[1])
}
