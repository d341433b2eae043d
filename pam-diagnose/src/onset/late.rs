//! What begins in the test data alone.

use super::scan::Edge;
use super::search::one_more;
use super::times::Times;
use crate::fit::{Hypothesis, Interval, Problem};
use crate::search::Candidates;
use crate::verdict::share;
use serde::Serialize;
use std::collections::BTreeMap;

/// A cause that is there in the test data only. Nothing is left to confirm it, so it is told and not made a part of the model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LateFault {
    /// Id of the candidate that explains it best.
    pub effect: String,
    /// Its parameters, the times behind them, with 95 % intervals.
    pub parameters: BTreeMap<&'static str, Interval>,
    /// When it acts.
    pub acts: Times,
    /// Share of the squared error of the test data that it removes.
    pub share_of_error_removed: f64,
}

impl LateFault {
    /// In words.
    #[must_use]
    pub fn sentence(&self) -> String {
        use pam_core::units::significant;
        let times = [pam_vocabulary::course::ONSET, pam_vocabulary::course::END].map(|p| p.name);
        let own = self.parameters.iter().filter(|(name, _)| !times.contains(name));
        let values: Vec<String> =
            own.map(|(name, i)| format!("{name} = {}", significant(i.value, 3))).collect();
        format!(
            "an error occurs in the test data only: {}. It looks like {} ({}), which no other data confirm",
            self.acts.sentence("it"),
            pam_vocabulary::plain_name(&self.effect),
            values.join(", ")
        )
    }
}

/// The cause that explains best what the final set leaves of the `test` rows, if it acts in none of the `open` ones.
pub(crate) fn late_fault<C: Candidates + ?Sized>(
    open: &Problem<'_, C>,
    test: &Problem<'_, C>,
    hypothesis: &Hypothesis,
    screened: &[(usize, Vec<f64>)],
    seed: u64,
) -> Option<LateFault> {
    let system = open.system;
    let mut experiments: Vec<usize> =
        open.experiments.iter().chain(&test.experiments).copied().collect();
    experiments.sort_unstable();
    experiments.dedup();
    let window = |of: &Problem<'_, C>, e: usize| {
        let place = of.experiments.iter().position(|&other| other == e)?;
        Some(of.windows[place].clone())
    };
    let windows: Vec<_> = experiments
        .iter()
        .filter_map(|&e| match (window(open, e), window(test, e)) {
            (Some(open), Some(test)) => Some(open.start..test.end),
            (open, test) => open.or(test),
        })
        .collect();
    let all = Problem { experiments, windows: windows.clone(), unseen: None, ..open.clone() };
    let all = all.with_windows(|place, _| windows[place].clone());
    let none = vec![0.0; system.local().len()];
    let local = |e: &usize| {
        let place = open.experiments.iter().position(|other| other == e);
        place.map_or_else(|| none.clone(), |place| hypothesis.locals[place].clone())
    };
    let whole =
        Hypothesis { locals: all.experiments.iter().map(local).collect(), ..hypothesis.clone() };
    // The last time of each experiment that is open; −∞ where none is.
    let open_s: Vec<f64> = all
        .experiments
        .iter()
        .map(|&e| {
            let end = window(open, e).map(|w| system.time_s(e, w.end.max(1) - 1));
            end.unwrap_or(f64::NEG_INFINITY)
        })
        .collect();
    let outside = |edge: &Edge| {
        edge.times_s.iter().zip(&open_s).all(|(&time_s, &open_s)| {
            let closed = open_s == f64::NEG_INFINITY;
            closed || if edge.begins { time_s >= open_s } else { time_s == f64::NEG_INFINITY }
        })
    };
    // In an experiment that is open at first, it begins in the test rows.
    let test_s: f64 = open_s.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let from_s = if all.len() == open.len() { test_s } else { 0.0 };
    let [base, best] = one_more(&all, &whole, screened, &outside, from_s, seed)?;
    let member = best.hypothesis.members.last()?;
    let intervals = all.intervals(&best).ok()?;
    let fitted = member.fitted(system);
    let own = system.candidate(member.candidate);
    let place = best.hypothesis.members.len() - 1;
    let mut intervals = intervals;
    for (k, interval) in intervals.iter_mut().skip(own.parameters.len()).enumerate() {
        interval.ci95 = super::time_interval(&all, &best, place, k);
    }
    let parameters = fitted.iter().zip(&intervals).map(|((_, info), i)| (info.name, *i)).collect();
    let tested: Vec<usize> = test.experiments.clone();
    let acts = Times::of(system, &tested, member, &intervals[own.parameters.len()..])?;
    Some(LateFault {
        effect: own.id.to_owned(),
        parameters,
        acts,
        share_of_error_removed: share(base.errors.chi_square(), best.errors.chi_square(), 0.0),
    })
}
