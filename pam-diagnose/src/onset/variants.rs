//! Sets near one in which something begins or ends: with members more or less, or with other courses of them.

use super::scanned::{needed, scanned};
use super::schedule::{Acts, Pattern, Schedule};
use super::starts::hypotheses;
use crate::fit::{Hypothesis, Member, Problem};
use crate::linearised::Products;
use crate::search::{Candidates, Rows};
use pam_vocabulary::ParameterInfo;
use pam_vocabulary::course::{ActivityWindow, END, RAMP};
use std::sync::Arc;

/// The set with other candidates of its rivals in place of each timed member, at the same times.
pub(super) fn exchanged(best: &Hypothesis, rivals: &[Hypothesis]) -> Vec<Hypothesis> {
    let mut all = Vec::new();
    for (place, member) in best.members.iter().enumerate() {
        if member.schedule.is_none() {
            continue;
        }
        let mut known: Vec<usize> = best.set();
        for other in rivals.iter().flat_map(|h| &h.members).filter(|m| m.schedule.is_some()) {
            if known.contains(&other.candidate) || known.len() > best.members.len() + MOST_EXCHANGED
            {
                continue;
            }
            known.push(other.candidate);
            let values = [other.own(), member.times()].concat();
            let mut set = best.clone();
            set.members[place] = Member { candidate: other.candidate, values, ..member.clone() };
            all.push(set);
        }
    }
    all
}

/// Candidates that are tried in place of a timed member.
const MOST_EXCHANGED: usize = 6;

/// The hypothesis with members that begin where they grew over the least ramp; `None` if there are none.
pub(super) fn without_least_ramps<C: Candidates + ?Sized>(
    system: &C,
    h: &Hypothesis,
) -> Option<Hypothesis> {
    let mut other = h.clone();
    for member in &mut other.members {
        let Some(schedule) = member.schedule.clone() else { continue };
        let ramp = schedule.times.iter().position(|p| p.name == RAMP.name);
        let Some(ramp) = ramp.filter(|&k| member.times()[k] < 1.01 * system.ramp_s()) else {
            continue;
        };
        let at = member.own().len() + ramp;
        let mut schedule = Schedule::clone(&schedule);
        schedule.times.remove(ramp);
        for acts in &mut schedule.acts {
            if let Acts::Within(course, _) = acts {
                course.ramp = false;
            }
        }
        member.values.remove(at);
        member.schedule = Some(Arc::new(schedule));
    }
    (other != *h).then_some(other)
}

/// The set without each member, with timed members that are always there, and, if asked for, with other courses of them.
pub(super) fn variants<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    set: &Hypothesis,
    most: usize,
    with_windows: bool,
) -> Vec<Hypothesis> {
    let mut all = Vec::new();
    for (place, member) in set.members.iter().enumerate() {
        if set.members.len() > 1 {
            all.push(set.without(place));
        }
        let Some(schedule) = &member.schedule else { continue };
        let always = Member::always(member.candidate, member.own());
        let mut with = |members: Vec<Member>| {
            if set.members.len() + members.len() - 1 <= most {
                let mut other = set.without(place);
                other.members.extend(members);
                all.push(other);
            }
        };
        with(vec![always.clone()]);
        // It may have been there before, and have grown.
        let twice = set.members.iter().filter(|m| m.candidate == member.candidate).count();
        if twice < 2 {
            let half: Vec<f64> = halved(problem, member);
            with(vec![Member::always(member.candidate, &half), member.with_own(&half)]);
        }
        let simple =
            schedule.acts.iter().any(|a| matches!(a, Acts::Within(c, _) if c.time_len() == 1));
        if with_windows && simple && schedule.pattern != Pattern::Each {
            for course in [ActivityWindow::GROWS, ActivityWindow::PASSES] {
                for member in other_course(problem, member, schedule, course) {
                    with(vec![member]);
                }
            }
        }
    }
    all
}

/// Own values with half of each magnitude.
fn halved<C: Candidates + ?Sized>(problem: &Problem<'_, C>, member: &Member) -> Vec<f64> {
    let mut own = member.own().to_vec();
    let infos = problem.system.candidate(member.candidate).parameters;
    for (value, info) in own.iter_mut().zip(infos) {
        if let Some(off) = info.off {
            *value = off + 0.5 * (*value - off);
        }
    }
    own
}

/// Ramps of the duration of the data from which a growing effect is fitted.
const RAMP_SHARES: [f64; 2] = [0.05, 0.3];
/// Fractions of the remaining recording after an onset at which a temporary effect is tried to end.
const END_SHARES: [f64; 2] = [0.35, 0.7];

/// A member that begins, as one that grows, or that ends again.
fn other_course<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    member: &Member,
    schedule: &Schedule,
    course: ActivityWindow,
) -> Vec<Member> {
    let acts: Vec<Acts> = schedule
        .acts
        .iter()
        .map(|a| match a {
            Acts::Within(own, first) if *own == ActivityWindow::BEGINS => {
                Acts::Within(course, *first)
            }
            other => *other,
        })
        .collect();
    if acts == schedule.acts {
        return Vec::new();
    }
    let (onset, latest) = (member.times()[0], schedule.times[0].range[1]);
    let (info, values): (ParameterInfo, Vec<f64>) = if course == ActivityWindow::GROWS {
        let least = problem.system.ramp_s();
        let range = [least, latest];
        let ramps = RAMP_SHARES.map(|share| (share * latest).max(2.0 * least));
        (ParameterInfo { range, ..RAMP }, ramps.to_vec())
    } else {
        let last_s = problem
            .experiments
            .iter()
            .zip(&problem.windows)
            .map(|(&e, w)| problem.system.time_s(e, w.end.max(1) - 1))
            .fold(0.0, f64::max);
        let ends = END_SHARES.map(|share| onset + share * (last_s - onset));
        (ParameterInfo { range: [0.0, latest], ..END }, ends.to_vec())
    };
    let times = vec![schedule.times[0], info];
    let choices = 2.0 * schedule.choices;
    let schedule = Arc::new(Schedule { acts, times, choices, ..schedule.clone() });
    let with = |value: f64| Member {
        values: [member.own(), &[onset, value]].concat(),
        schedule: Some(Arc::clone(&schedule)),
        ..member.clone()
    };
    values.into_iter().map(with).collect()
}

/// Sets with a further member: one that is always there, or one that begins or ends.
pub(super) fn additions<C: Candidates + ?Sized>(
    rows: &Rows<'_, C>,
    set: &Hypothesis,
    screened: &[(usize, Vec<f64>)],
    seed: u64,
) -> Vec<Hypothesis> {
    let settings = &rows.whole.settings;
    let mut all = Vec::new();
    if let Some(products) = Products::at(&rows.whole, set, screened) {
        let linearised = products.beside();
        let best = linearised.singles();
        let promising = best.iter().filter(|s| rows.is_promising(s, linearised.residual));
        for subset in promising.take(settings.search.additions) {
            let add = |h: Hypothesis, s: &&crate::linearised::Start| h.with(s.candidate, &s.values);
            all.push(subset.starts.iter().fold(set.clone(), add));
        }
    }
    if let Some(found) = scanned(&rows.whole, set, screened, needed(rows), None, seed)
        && !found.by_chance(settings.onset.probability)
    {
        for scored in found.promising.iter().take(settings.search.additions) {
            all.extend(hypotheses(&rows.whole, set, scored, found.choices));
        }
    }
    all
}
