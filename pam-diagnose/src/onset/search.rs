//! From the scan to a set whose members begin or end.

use super::fits::{fit_all, moved_in_time};
use super::scan::{Edge, OnsetTest};
use super::scanned::{curves, needed, scanned};
use super::schedule::{Acts, Schedule};
use super::starts::hypotheses;
use super::variants::{additions, exchanged, variants, without_least_ramps};
use crate::diagnosis::total;
use crate::fit::{Fit, Hypothesis, Problem};
use crate::search::{Candidates, Rows, TIE};
use crate::verdict::largest_rise;
use std::sync::Arc;

/// Rounds of improvements.
const ROUNDS: usize = 3;

/// A set in which something begins or ends.
#[derive(Debug, Clone)]
pub(crate) struct TimedSet {
    /// The set, fitted to all open rows.
    pub(crate) set: Hypothesis,
    /// Sets that were fitted with the noise beside it, it among them, with minus two times the logarithm of their posterior
    /// probability; the best first.
    pub(crate) others: Vec<(Hypothesis, f64)>,
}

/// What the search for times found.
#[derive(Debug, Clone, Default)]
pub(crate) struct OnsetFindings {
    /// The test against chance; absent where nothing was worth it.
    pub(crate) test: Option<OnsetTest>,
    /// The set, if one is better than all that are always there.
    pub(crate) timed: Option<TimedSet>,
    /// By how much the named beginning or end would lower the squared residual at each time, in each open recording.
    pub(crate) curves: Vec<(String, Vec<(f64, f64)>)>,
}

/// Searches for a better set than `plain` in which effects begin, end or grow. The noise of `rows` is learned beside `plain`;
/// `screened` are the starting values of the candidates.
pub(crate) fn search<C: Candidates + ?Sized>(
    rows: &mut Rows<'_, C>,
    plain: &Fit,
    base: &Fit,
    screened: &[(usize, Vec<f64>)],
    seed: u64,
) -> OnsetFindings {
    let system = rows.whole.system;
    let none = OnsetFindings::default();
    if !(0..system.candidate_len()).any(|c| system.may_be_timed(c)) {
        return none;
    }
    let settings = rows.whole.settings.onset;
    let mut seeds = vec![plain];
    if !plain.hypothesis.members.is_empty() {
        seeds.push(base);
    }
    let (mut test, mut starts, mut scans) = (None::<OnsetTest>, Vec::new(), Vec::new());
    for (k, from) in seeds.into_iter().enumerate() {
        // Where nothing changes beside the chosen set, it is no mixture of something that does.
        if k > 0 && scans.is_empty() {
            break;
        }
        let found = scanned(&rows.whole, &from.hypothesis, screened, needed(rows), None, seed);
        let Some(found) = found else { continue };
        if found.test.is_some_and(|own| test.is_none_or(|t| own.p_value < t.p_value)) {
            test = found.test;
        }
        if found.by_chance(settings.probability) {
            continue;
        }
        for scored in found.promising.iter().take(settings.candidates) {
            starts.extend(hypotheses(&rows.whole, &from.hypothesis, scored, found.choices));
        }
        scans.push(found);
    }
    let most = rows.whole.settings.search.max_causes.max(plain.hypothesis.members.len());
    starts.retain(|h| h.members.len() <= most);
    let fitted = fit_all(&rows.whole, starts);
    let Some(first) = fitted.first().filter(|f| f.cost < plain.cost) else {
        return OnsetFindings { test, ..none };
    };
    let timed = improved(rows, first.clone(), &fitted[1..], plain, screened, most, seed);
    if timed.is_none() {
        // The noise as it was.
        rows.learn_beside(&plain.hypothesis);
    }
    let curves = timed.as_ref().map_or_else(Vec::new, |t| curves(rows, &scans, &t.set));
    OnsetFindings { test, timed, curves }
}

/// The set with the noise beside it, improved by members more or less and by other courses, as long as it gets better;
/// `None` if it does not reach the odds against `plain`.
fn improved<C: Candidates + ?Sized>(
    rows: &mut Rows<'_, C>,
    first: Fit,
    rivals: &[Fit],
    plain: &Fit,
    screened: &[(usize, Vec<f64>)],
    most: usize,
    seed: u64,
) -> Option<TimedSet> {
    let settings = rows.whole.settings.search;
    let mut best = first;
    let mut others: Vec<(Hypothesis, f64)> = Vec::new();
    let mut rivals: Vec<Hypothesis> = rivals.iter().map(|f| f.hypothesis.clone()).collect();
    for round in 0..ROUNDS {
        best = rows.learn_beside(&best.hypothesis)?;
        best = moved_in_time(&rows.whole, best);
        if let Some(abrupt) = without_least_ramps(rows.whole.system, &best.hypothesis) {
            best = rows.whole.fit(abrupt, settings.iterations).ok()?;
        }
        let again = |h: &Hypothesis| rows.whole.fit(h.clone(), settings.iterations).ok();
        let mut sets = vec![best.clone()];
        sets.extend(again(&plain.hypothesis));
        let mut starts = variants(&rows.whole, &best.hypothesis, most, round == 0);
        // The best rival of each set of candidates.
        let mut known = vec![best.hypothesis.set()];
        rivals.retain(|h| {
            let new = !known.contains(&h.set());
            known.push(h.set());
            new
        });
        starts.extend(rivals.iter().take(settings.rivals).cloned());
        starts.extend(exchanged(&best.hypothesis, &rivals));
        if best.hypothesis.members.len() < most && round + 1 < ROUNDS {
            starts.extend(additions(rows, &best.hypothesis, screened, seed));
        }
        sets.extend(fit_all(&rows.whole, starts));
        let own = |f: &Fit| total(&rows.whole, f);
        sets.sort_by(|a, b| own(a).total_cmp(&own(b)));
        others = sets.iter().map(|f| (f.hypothesis.clone(), own(f))).collect();
        rivals = sets.iter().map(|f| f.hypothesis.clone()).collect();
        // The smallest set against which the odds of the best are not enough.
        let enough = 2.0 * needed(rows);
        let near = sets.iter().filter(|f| own(f) - own(&sets[0]) < enough);
        let size = |f: &&Fit| f.hypothesis.parameters(rows.whole.system).len();
        let smallest = near.clone().map(|f| size(&f)).min()?;
        let near: Vec<&Fit> = near.filter(|f| size(f) == smallest).collect();
        // Of indistinguishable sets, the one that comes first in the list of candidates.
        let least = near.iter().map(|f| own(f)).fold(f64::INFINITY, f64::min);
        let tied = near.into_iter().filter(|f| own(f) - least < 2.0 * TIE);
        let next = tied.min_by_key(|f| f.hypothesis.set())?.clone();
        let always = sets.iter().filter(|f| !is_timed(f));
        let least_rise = rows.whole.settings.onset.least_rise;
        if !is_timed(&next) || always.into_iter().any(|f| largest_rise(&next, f) < least_rise) {
            return None;
        }
        let same =
            next.hypothesis.set() == best.hypothesis.set() && courses(&next) == courses(&best);
        best = next;
        if same {
            break;
        }
    }
    Some(TimedSet { set: best.hypothesis, others })
}

/// Whether a member comes or goes.
fn is_timed(fit: &Fit) -> bool {
    fit.hypothesis.members.iter().any(|m| m.schedule.is_some())
}

/// What the members do in the experiments.
fn courses(fit: &Fit) -> Vec<Option<Vec<Acts>>> {
    fit.hypothesis.members.iter().map(|m| m.schedule.as_ref().map(|s| s.acts.clone())).collect()
}

/// The member that explains best what a hypothesis leaves, among those that act where `may_be` lets them alone: the members of
/// the hypothesis keep their values. No time is before `from_s`. Fits of the hypothesis without and with it; `None` if it does
/// not reach the odds.
pub(super) fn one_more<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    hypothesis: &Hypothesis,
    screened: &[(usize, Vec<f64>)],
    may_be: &dyn Fn(&Edge) -> bool,
    from_s: f64,
    seed: u64,
) -> Option<[Fit; 2]> {
    let settings = problem.settings;
    let needed = settings.search.odds_of_few_blocks.max(settings.onset.odds).ln();
    let fixed = Hypothesis { fixed: hypothesis.members.len(), ..hypothesis.clone() };
    let base = problem.fit(fixed, settings.search.iterations).ok()?;
    let found = scanned(problem, &base.hypothesis, screened, needed, Some(may_be), seed)?;
    if found.by_chance(settings.onset.probability) {
        return None;
    }
    let starts = found.promising.iter().take(settings.onset.candidates);
    let starts = starts.flat_map(|s| hypotheses(problem, &base.hypothesis, s, found.choices));
    let starts = starts.map(|mut h| {
        let member = h.members.last_mut().expect("just added");
        if let Some(schedule) = &member.schedule {
            let mut schedule = Schedule::clone(schedule);
            schedule.times.iter_mut().for_each(|p| p.range[0] = p.range[0].max(from_s));
            member.schedule = Some(Arc::new(schedule));
        }
        h
    });
    let best = fit_all(problem, starts.collect()).into_iter().next()?;
    let best = moved_in_time(problem, best);
    let clear = total(problem, &base) - total(problem, &best) > 2.0 * needed
        && largest_rise(&best, &base) > settings.onset.least_rise;
    clear.then_some([base, best])
}
