//! Names whose intervals hold that they are absent.

use crate::fit::{Interval, Problem};
use crate::search::Candidates;
use crate::verdict::Cause;
use pam_vocabulary::ParameterInfo;

/// Whether every parameter that could switch a cause off may be at the value at which it is off. False for a cause
/// without such a parameter.
pub(crate) fn may_be_absent<'p>(
    parameters: impl IntoIterator<Item = (&'p ParameterInfo, Interval)>,
) -> bool {
    let mut offs = parameters.into_iter().filter_map(|(info, i)| Some((info.off?, i))).peekable();
    offs.peek().is_some() && offs.all(|(off, interval)| interval.contains(off))
}

/// Whether the interval of a scale of a cause says nothing.
pub(crate) fn vague<C: Candidates + ?Sized>(problem: &Problem<'_, C>, cause: &Cause) -> bool {
    let ratio = problem.settings.rejection.vague_ratio;
    let infos = problem.system.candidate(cause.member.candidate).parameters;
    // An interval without a number is vague as well.
    let narrow = |i: &Interval| i.ci95[1] <= ratio * i.ci95[0];
    infos.iter().zip(&cause.parameters).any(|(p, (_, i))| p.logarithmic && !narrow(i))
}
