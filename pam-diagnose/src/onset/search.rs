//! From the scan to a set whose members begin or end.

use super::cells::{CellProducts, cell_s};
use super::scan::{Edge, OnsetTest, Scan, Scored, touched};
use super::schedule::{Acts, Pattern, Schedule};
use crate::diagnosis::total;
use crate::fit::{Fit, Hypothesis, Member, Problem};
use crate::linearised::Products;
use crate::search::{Candidates, Rows, TIE, stands};
use crate::verdict::largest_rise;
use pam_core::parallel;
use pam_vocabulary::ParameterInfo;
use pam_vocabulary::course::{ActivityWindow, END, ONSET, RAMP};
use std::sync::Arc;

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

/// The scan at a hypothesis.
struct Scanned {
    test: Option<OnsetTest>,
    /// Edges that may reach the odds, the best first.
    promising: Vec<Scored>,
    /// Edges from which each was chosen.
    choices: f64,
    products: CellProducts,
}

impl Scanned {
    fn by_chance(&self, probability: f64) -> bool {
        self.test.is_none_or(|t| t.p_value > 1.0 - probability)
    }
}

/// The scan at a fitted hypothesis over the edges that `may_be`; the logarithm of the odds of a promising one is at least
/// `needed`.
fn scanned<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    at: &Hypothesis,
    starts: &[(usize, Vec<f64>)],
    needed: f64,
    may_be: Option<&dyn Fn(&Edge) -> bool>,
    seed: u64,
) -> Option<Scanned> {
    let settings = &problem.settings.onset;
    let every = vec![true; problem.len()];
    let asked = match may_be {
        Some(may_be) => touched(&CellProducts::cells_of(problem), settings, may_be),
        None => every.clone(),
    };
    let (may_be, of_each) = (may_be.unwrap_or(&|_| true), may_be.is_none());
    let mut products = CellProducts::at(problem, at, starts, &asked)?;
    if asked != every {
        // The comparison with an effect at all times needs every experiment; it is made only where something is promising.
        let scan = Scan::new(&products, settings, may_be);
        let reached = promising(problem, &scan, (products.square, of_each), needed, false);
        if reached.is_empty() {
            let choices = scan.edges_per_direction() as f64;
            return Some(Scanned { test: None, promising: reached, choices, products });
        }
        products = CellProducts::at(problem, at, starts, &every)?;
    }
    Some(judged(problem, products, (may_be, of_each), needed, seed))
}

/// The scan of these products.
fn judged<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    products: CellProducts,
    (may_be, of_each): (&dyn Fn(&Edge) -> bool, bool),
    needed: f64,
    seed: u64,
) -> Scanned {
    let settings = &problem.settings.onset;
    let scan = Scan::new(&products, settings, may_be);
    let choices = scan.edges_per_direction() as f64;
    let promising = promising(problem, &scan, (products.square, of_each), needed, true);
    // The draws take longer than the scan; where nothing is promising, they decide nothing.
    let test = if promising.is_empty() { None } else { scan.test(settings, seed) };
    Scanned { test, promising, choices, products }
}

/// Edges of a scan of residuals with this `square` that may reach the odds, the best first: better than without the candidate,
/// and, if it is asked for, better than with it at all times.
fn promising<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    scan: &Scan<'_>,
    (square, of_each): (f64, bool),
    needed: f64,
    than_always: bool,
) -> Vec<Scored> {
    let choices = scan.edges_per_direction() as f64;
    scan.best(of_each)
        .into_iter()
        .filter(|s| {
            let times = match s.edge.pattern {
                Pattern::Each => s.edge.times_s.len(),
                Pattern::Shared | Pattern::Once => 1,
            };
            let own = problem.system.candidate(s.direction.candidate).parameters.len();
            let of_times = times as f64 * (log_rows(problem) + 2.0 * choices.ln());
            let of_own = own as f64 * log_rows(problem)
                + 2.0 * (problem.system.candidate_len().max(1) as f64).ln();
            let weighted = square * problem.rows_per_observation;
            let odds = |drop: f64, price: f64| {
                let share = (drop / square.max(f64::MIN_POSITIVE)).min(1.0 - 1e-12);
                0.5 * (-weighted * (-share).ln_1p() - price)
            };
            odds(s.drop, of_own + of_times) > needed
                && (!than_always || odds(s.contrast, of_times) > needed)
        })
        .collect()
}

fn log_rows<C: Candidates + ?Sized>(problem: &Problem<'_, C>) -> f64 {
    let rows: usize = (0..problem.len()).map(|i| problem.rows(i)).sum();
    (rows.max(2) as f64).ln()
}

/// The logarithm of the odds that a set with a time must reach against one without.
fn needed<C: Candidates + ?Sized>(rows: &Rows<'_, C>) -> f64 {
    rows.needed_log_odds().max(rows.whole.settings.onset.odds.ln())
}

/// The schedule of an edge with its times, for all experiments of the system. Experiments that are not open go by their order,
/// or like all others; with times of their own they are there in the middle of the others' until they are fitted.
fn schedule<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    edge: &Edge,
    choices: f64,
) -> (Schedule, Vec<f64>) {
    let system = problem.system;
    let (course, time) =
        if edge.begins { (ActivityWindow::BEGINS, ONSET) } else { (ActivityWindow::ENDS, END) };
    let (before, behind) =
        if edge.begins { (Acts::Never, Acts::Always) } else { (Acts::Always, Acts::Never) };
    let count = system.experiment_len();
    let ended = |e: usize| system.time_s(e, system.points(e).max(1) - 1);
    let info = |e: usize| ParameterInfo { range: [0.0, ended(e)], ..time };
    let (mut times, mut values) = (Vec::new(), Vec::new());
    let mut acts = vec![Acts::Always; count];
    match edge.pattern {
        Pattern::Shared => {
            let latest = problem.experiments.iter().map(|&e| ended(e)).fold(0.0, f64::max);
            times.push(ParameterInfo { range: [0.0, latest], ..time });
            values.push(edge.times_s[0]);
            acts = vec![Acts::Within(course, 0); count];
        }
        Pattern::Once => {
            // The last experiment that is before the time as a whole.
            let last = |place: usize| edge.times_s[place] == f64::INFINITY;
            let boundary =
                (0..problem.len()).filter(|&i| last(i)).map(|i| problem.experiments[i]).max();
            for (e, acts) in acts.iter_mut().enumerate() {
                *acts = if boundary.is_some_and(|b| e <= b) { before } else { behind };
            }
            let within = (0..problem.len()).find(|&i| edge.times_s[i].is_finite());
            if let Some(place) = within {
                let e = problem.experiments[place];
                times.push(info(e));
                values.push(edge.times_s[place]);
                acts[e] = Acts::Within(course, 0);
                // What lies between the boundary and this experiment is before it as well.
                acts[..e].fill(before);
            }
        }
        Pattern::Each => {
            let finite = edge.times_s.iter().copied().filter(|t| t.is_finite());
            let middle = finite.clone().sum::<f64>() / finite.count().max(1) as f64;
            for (e, acts) in acts.iter_mut().enumerate() {
                let place = problem.experiments.iter().position(|&open| open == e);
                let time_s = place.map_or(middle, |place| edge.times_s[place]);
                *acts = if time_s == f64::INFINITY {
                    before
                } else if time_s == f64::NEG_INFINITY {
                    behind
                } else {
                    times.push(info(e));
                    values.push(time_s);
                    Acts::Within(course, times.len() - 1)
                };
            }
        }
    }
    let choices = choices.powi(if edge.pattern == Pattern::Each { values.len() as i32 } else { 1 });
    let schedule = Schedule { pattern: edge.pattern, acts, times, fitted: true, choices };
    (schedule, values)
}

/// The sets that an edge stands for.
fn hypotheses<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    from: &Hypothesis,
    scored: &Scored,
    choices: f64,
) -> Vec<Hypothesis> {
    let (direction, edge) = (&scored.direction, &scored.edge);
    let member = |edge: &Edge| {
        let (schedule, times) = schedule(problem, edge, choices);
        Member {
            candidate: direction.candidate,
            values: [direction.values.as_slice(), &times].concat(),
            schedule: Some(Arc::new(schedule)),
            scales_held: false,
        }
    };
    let mut all = vec![from.with_member(member(edge))];
    if let Some(place) = direction.member {
        let ends = Edge { begins: false, ..edge.clone() };
        for edge in [edge, &ends] {
            let mut other = from.clone();
            other.members[place] = member(edge);
            all.push(other);
        }
    }
    all
}

/// Fits sets to all open rows, and leaves behind those that cannot come near the best any more; the best first.
fn fit_all<C: Candidates + ?Sized>(problem: &Problem<'_, C>, starts: Vec<Hypothesis>) -> Vec<Fit> {
    let settings = &problem.settings.search;
    let fitted = parallel::map_each(starts, |start| {
        problem.fit_to(start, settings.first_iterations, settings.converged_drop)
    });
    let mut going: Vec<Fit> = fitted.into_iter().flatten().collect();
    let mut done: Vec<Fit> = Vec::new();
    let mut iterations = settings.first_iterations;
    let price = |fit: &Fit| total(problem, fit);
    while !going.is_empty() {
        going.sort_by(|a, b| price(a).total_cmp(&price(b)));
        let best = going.iter().chain(&done).map(price).fold(f64::INFINITY, f64::min);
        let mut followed = 0;
        let (further, ended): (Vec<Fit>, Vec<Fit>) = going.into_iter().partition(|fit| {
            let near = price(fit) + fit.may_reach() - fit.cost < best;
            let goes_on = near && !fit.has_converged() && iterations < settings.iterations;
            followed += usize::from(goes_on);
            goes_on && (iterations < settings.tried_iterations || followed <= settings.followed)
        });
        done.extend(ended);
        iterations += settings.first_iterations;
        let go_on = |fit| problem.fit_further(fit, settings.first_iterations);
        going = parallel::map_each(further, go_on).into_iter().flatten().collect();
    }
    done.retain(|fit| {
        let h = &fit.hypothesis;
        stands(problem.system, h) && within(problem, h) && inside(problem.system, h)
    });
    done.sort_by(|a, b| price(a).total_cmp(&price(b)));
    done
}

/// Whether no own value of a timed member, and no ramp, is at a limit of its range, but where it is off: there the name stands
/// for something else.
fn inside<C: Candidates + ?Sized>(system: &C, h: &Hypothesis) -> bool {
    let timed = h.members.iter().filter(|m| m.schedule.is_some());
    timed.flat_map(|m| m.fitted(system).into_iter().map(move |f| (m, f))).all(|(m, (k, info))| {
        let (value, [low, high]) = (m.values[k], info.range);
        let margin = 1e-9 * (high - low);
        info.off == Some(value) || (value > low + margin && value < high - margin)
    })
}

/// Whether the times of all members are inside the recordings: at their ends a member is there always, or never.
fn within<C: Candidates + ?Sized>(problem: &Problem<'_, C>, h: &Hypothesis) -> bool {
    h.members.iter().all(|m| {
        let Some(schedule) = &m.schedule else { return true };
        (0..problem.len()).all(|place| {
            let (e, window) = (problem.experiments[place], &problem.windows[place]);
            let ends = [window.start, window.end.max(1) - 1].map(|k| problem.system.time_s(e, k));
            let open = schedule.times_in(e).all(|t| {
                let scale = schedule.times[t].logarithmic;
                scale || (m.times()[t] > ends[0] && m.times()[t] < ends[1])
            });
            // With the same times everywhere, one recording that holds them is enough.
            open || schedule.pattern == Pattern::Shared && problem.len() > 1
        })
    })
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

/// The set with other candidates of its rivals in place of each timed member, at the same times.
fn exchanged(best: &Hypothesis, rivals: &[Hypothesis]) -> Vec<Hypothesis> {
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
fn without_least_ramps<C: Candidates + ?Sized>(system: &C, h: &Hypothesis) -> Option<Hypothesis> {
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

/// Rounds of improvements.
const ROUNDS: usize = 3;

/// What the members do in the experiments.
fn courses(fit: &Fit) -> Vec<Option<Vec<Acts>>> {
    fit.hypothesis.members.iter().map(|m| m.schedule.as_ref().map(|s| s.acts.clone())).collect()
}

/// The set without each member, with timed members that are always there, and, if asked for, with other courses of them.
fn variants<C: Candidates + ?Sized>(
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
/// Shares of what is left of a recording behind an onset, at which an effect that passes ends.
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
fn additions<C: Candidates + ?Sized>(
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

/// Largest shift of a time that is tried, in cells.
const LARGEST_SHIFT: f64 = 1.5;
/// Distance of the shifts, in rows: the cost has valleys of a few rows, as a friction that begins while the joint moves has.
const SHIFT_ROWS: f64 = 2.0;
/// Valleys that are followed.
const VALLEYS: usize = 3;
/// Rounds of shifts.
const SHIFT_ROUNDS: usize = 2;

/// The fit from other times nearby: a time shows to first order only from within the response of the system.
pub(crate) fn moved_in_time<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    mut best: Fit,
) -> Fit {
    let settings = &problem.settings.search;
    let row_s = (0..problem.len()).map(|i| problem.row_s(i)).filter(|s| s.is_finite());
    let step_s = SHIFT_ROWS * row_s.fold(0.0, f64::max);
    let count = (LARGEST_SHIFT * cell_s(problem) / step_s).ceil() as i32;
    for _ in 0..SHIFT_ROUNDS {
        let mut valleys = Vec::new();
        for (place, member) in best.hypothesis.members.iter().enumerate() {
            let Some(schedule) = &member.schedule else { continue };
            for (k, info) in schedule.times.iter().enumerate().filter(|(_, i)| !i.logarithmic) {
                let at = member.own().len() + k;
                let shifted = |shift: i32| {
                    let mut other = best.hypothesis.clone();
                    let value = &mut other.members[place].values[at];
                    *value =
                        (*value + f64::from(shift) * step_s).clamp(info.range[0], info.range[1]);
                    other
                };
                let tried: Vec<Hypothesis> = (-count..=count).map(shifted).collect();
                let costs = parallel::map(tried.len(), |k| {
                    let h = &tried[k];
                    problem.errors(h).map_or(f64::INFINITY, |e| problem.cost(h, &e))
                });
                let inner = 1..tried.len() - 1;
                let lowest = |k: &usize| costs[*k] <= costs[k - 1] && costs[*k] < costs[k + 1];
                // The middle is where the fit is.
                let own = inner.filter(lowest).filter(|k| *k != count as usize);
                valleys.extend(own.map(|k| (costs[k], tried[k].clone())));
            }
        }
        valleys.sort_by(|a, b| a.0.total_cmp(&b.0));
        valleys.truncate(VALLEYS);
        let fitted = parallel::map_each(valleys, |(_, h)| {
            problem.fit_to(h, settings.tried_iterations, settings.converged_drop)
        });
        let better = fitted.into_iter().flatten().filter(|f| f.cost < best.cost - 1.0);
        let Some(next) = better.min_by(|a, b| a.cost.total_cmp(&b.cost)) else { break };
        best = problem.fit_further(next.clone(), settings.iterations).unwrap_or(next);
    }
    best
}

/// The curves of the first member of a set that begins or ends.
fn curves<C: Candidates + ?Sized>(
    rows: &Rows<'_, C>,
    scans: &[Scanned],
    set: &Hypothesis,
) -> Vec<(String, Vec<(f64, f64)>)> {
    let Some(member) = set.members.iter().find(|m| m.schedule.is_some()) else {
        return Vec::new();
    };
    let ends = |a: &Acts| matches!(a, Acts::Within(c, _) if !c.onset);
    let begins = !member.schedule.as_ref().is_some_and(|s| s.acts.iter().any(ends));
    let system = rows.whole.system;
    scans
        .iter()
        .map(|s| {
            let scan = Scan::new(&s.products, &rows.whole.settings.onset, &|_| true);
            scan.curve(member.candidate, begins)
        })
        .filter(|curves| curves.iter().any(|c| !c.is_empty()))
        .max_by(|a, b| highest(a).total_cmp(&highest(b)))
        .into_iter()
        .flatten()
        .zip(&rows.whole.experiments)
        .map(|(curve, &e)| {
            let start_s = system.start_s(e);
            let at = |(t, drop): (f64, f64)| (start_s + t, drop);
            (system.name(e).to_owned(), curve.into_iter().map(at).collect())
        })
        .collect()
}

fn highest(curves: &[Vec<(f64, f64)>]) -> f64 {
    curves.iter().flatten().map(|p| p.1).fold(0.0, f64::max)
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
