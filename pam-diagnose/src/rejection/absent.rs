//! Names whose intervals hold that they are absent.

use crate::fit::{Fit, Interval, Problem};
use crate::search::Candidates;
use pam_effects::effects::ParameterInfo;

/// Whether every parameter that could switch a cause off may be at the value at which it is off. False for a cause
/// without such a parameter.
pub(crate) fn may_be_absent<'p>(
    parameters: impl IntoIterator<Item = (&'p ParameterInfo, Interval)>,
) -> bool {
    let mut offs = parameters.into_iter().filter_map(|(info, i)| Some((info.off?, i))).peekable();
    offs.peek().is_some() && offs.all(|(off, interval)| interval.contains(off))
}

/// The first member of a fit that may be absent, or one of whose scales has an interval that says nothing.
pub(crate) fn insignificant<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    fit: &Fit,
) -> Option<usize> {
    let intervals = problem.intervals(fit).ok()?;
    let ratio = problem.settings.rejection.vague_ratio;
    // An interval without a number is vague as well.
    let narrow = |i: &Interval| i.ci95[1] <= ratio * i.ci95[0];
    let mut at = 0;
    fit.hypothesis.members.iter().position(|member| {
        let parameters = problem.system.candidate(member.candidate).parameters;
        let own = &intervals[at..at + parameters.len()];
        at += parameters.len();
        let pairs = || parameters.iter().zip(own);
        may_be_absent(pairs().map(|(p, i)| (p, *i)))
            || pairs().any(|(p, i)| p.logarithmic && !narrow(i))
    })
}
