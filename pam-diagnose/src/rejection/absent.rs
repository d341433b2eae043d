//! Names whose intervals hold that they are absent.

use crate::fit::{Interval, Problem};
use crate::search::Candidates;
use crate::verdict::Cause;
use pam_numerics::statistics::chi_square_quantile;
use pam_numerics::{ScaledCholesky, dot};
use pam_vocabulary::ParameterInfo;

/// Probability of the region in which several parameters have to hold that a cause is absent, as of an interval.
const REGION: f64 = 0.95;

/// Whether every parameter that could switch a cause off may be at the value at which it is off. False for a cause
/// without such a parameter.
///
/// Each interval holds that value, and so does the region of all of them together: two biases of which only the difference is
/// known have wide intervals each, and are not both zero. The statistic `dᵀ C⁻¹ d` of the deviations `d` has the χ² distribution
/// of their number (Wald 1943). `covariance` is by the places of the parameters.
pub(crate) fn may_be_absent<'p>(
    parameters: impl IntoIterator<Item = (&'p ParameterInfo, Interval)>,
    covariance: impl Fn(usize, usize) -> f64,
) -> bool {
    let all = parameters.into_iter().enumerate();
    let offs: Vec<(usize, f64, Interval)> =
        all.filter_map(|(k, (info, i))| Some((k, info.off?, i))).collect();
    if offs.is_empty() || !offs.iter().all(|(_, off, interval)| interval.contains(*off)) {
        return false;
    }
    if offs.len() < 2 {
        return true;
    }
    let entry = |i: usize, j: usize| covariance(offs[i].0, offs[j].0);
    let deviations: Vec<f64> = offs.iter().map(|(_, off, i)| i.value - off).collect();
    let solved = ScaledCholesky::new(offs.len(), entry, 0.0).and_then(|f| f.solve(&deviations));
    let most = chi_square_quantile(REGION, offs.len() as f64);
    solved.is_none_or(|solved| dot(&deviations, &solved) <= most)
}

/// Whether the interval of a scale of a cause says nothing.
pub(crate) fn vague<C: Candidates + ?Sized>(problem: &Problem<'_, C>, cause: &Cause) -> bool {
    let ratio = problem.settings.rejection.vague_ratio;
    let infos = problem.system.candidate(cause.member.candidate).parameters;
    // An interval without a number is vague as well.
    let narrow = |i: &Interval| i.ci95[1] <= ratio * i.ci95[0];
    infos.iter().zip(&cause.parameters).any(|(p, (_, i))| p.logarithmic && !narrow(i))
}
