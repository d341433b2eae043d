//! Names whose intervals hold that they are absent.

use crate::fit::{Fit, HALF_WIDTH, Interval, Problem};
use crate::search::Candidates;
use crate::verdict::Cause;
use pam_numerics::statistics::chi_square_quantile;
use pam_numerics::{ScaledCholesky, dot};
use pam_vocabulary::ParameterInfo;

/// Probability of the intervals of parameters.
pub(crate) const OF_INTERVALS: f64 = 0.95;

/// Fraction of the cost reduction due to a cause that may remain with its magnitudes at their off values, for the cause to count as absent there.
const LEFT_WHERE_OFF: f64 = 0.05;

/// Whether setting the magnitudes of a member of the best fit to their off values removes it: the cost is then the same as without it. A slack
/// tendon is not removed: with zero stiffness loss, the volume of its chamber still stays constant.
pub(crate) fn is_absent_where_off<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    best: &Fit,
    place: usize,
) -> bool {
    if !problem.system.acts_where_off(best.hypothesis.members[place].candidate) {
        return true;
    }
    let off = best.hypothesis.with_magnitudes(problem.system, place, 0.0);
    let without = best.hypothesis.without(place);
    let [off, without] = [off, without].map(|h| Some(problem.cost(&h, &problem.errors(&h).ok()?)));
    match (off, without) {
        (Some(off), Some(without)) => without - off <= LEFT_WHERE_OFF * (without - best.cost),
        _ => true,
    }
}

/// Whether every parameter that could switch a cause off may be at the value at which it is off, in the region that holds the truth with
/// this `probability`. False for a cause without such a parameter.
///
/// Each interval, wider or narrower by the ratio of the normal quantiles, holds that value, and so does the region of all of them together:
/// two biases of which only the difference is
/// known have wide intervals each, and are not both zero. With the `covariance` `C` of the parameters, by their places, the deviations
/// `d` are furthest from zero along `w = C⁻¹ d`. The statistic `(wᵀ d)² / (wᵀ C w + σ²)` has the χ² distribution of their number
/// (Wald 1943); `further` gives half a 95 % interval of `wᵀ d` for other reasons, from which `σ` follows.
pub(crate) fn may_be_absent<'p>(
    parameters: impl IntoIterator<Item = (&'p ParameterInfo, Interval)>,
    covariance: impl Fn(usize, usize) -> f64,
    further: impl Fn(&[f64]) -> f64,
    probability: f64,
) -> bool {
    let all: Vec<(&ParameterInfo, Interval)> = parameters.into_iter().collect();
    let off = |k: &usize| all[*k].0.off;
    let offs: Vec<(usize, f64)> = (0..all.len()).filter_map(|k| Some((k, off(&k)?))).collect();
    let [of_region, of_intervals] =
        [probability, OF_INTERVALS].map(|p| chi_square_quantile(p, 1.0).sqrt());
    let holds = |interval: &Interval, off: f64| {
        let ends = interval.ci95.map(|end| {
            // The same end where nothing is to be widened, not one that differs by rounding.
            let further = (of_region / of_intervals - 1.0) * (end - interval.value);
            end + further
        });
        ends[0] <= off && off <= ends[1]
    };
    if offs.is_empty() || !offs.iter().all(|&(k, off)| holds(&all[k].1, off)) {
        return false;
    }
    if offs.len() < 2 {
        return true;
    }
    let entry = |i: usize, j: usize| covariance(offs[i].0, offs[j].0);
    let deviations: Vec<f64> = offs.iter().map(|&(k, off)| all[k].1.value - off).collect();
    let along = ScaledCholesky::new(offs.len(), entry, 0.0).and_then(|f| f.solve(&deviations));
    let Some(along) = along else { return true };
    let mut weights = vec![0.0; all.len()];
    offs.iter().zip(&along).for_each(|(&(k, _), w)| weights[k] = *w);
    // As C⁻¹ d, both the deviation and its variance.
    let size = dot(&deviations, &along);
    let variance = size + (further(&weights) / HALF_WIDTH).powi(2);
    size * size / variance <= chi_square_quantile(probability, offs.len() as f64)
}

/// Returns true if the data do not identify a length scale, time constant or cutoff frequency of a cause: its interval spans more than a factor of
/// `rejection.vague_ratio`, and either the magnitude of the cause is not significant or the interval covers the whole range of the
/// parameter. If a creep is slower than the recording, for example, its stiffness is identified while its time constant only has a lower
/// bound.
pub(crate) fn vague<C: Candidates + ?Sized>(problem: &Problem<'_, C>, cause: &Cause) -> bool {
    let ratio = problem.settings.rejection.vague_ratio;
    let infos = problem.system.candidate(cause.member.candidate).parameters;
    let is_significant = !cause.may_be_chance && infos.iter().any(|p| p.off.is_some());
    let is_vague = |(info, (_, interval)): (&ParameterInfo, &(&str, Interval))| {
        info.logarithmic && is_undetermined(interval, info, ratio, is_significant)
    };
    infos.iter().zip(&cause.parameters).any(is_vague)
}

/// Whether this interval leaves a scale undetermined.
fn is_undetermined(
    interval: &Interval,
    info: &ParameterInfo,
    ratio: f64,
    is_significant: bool,
) -> bool {
    let ([low, high], range) = (interval.ci95, info.range);
    // So does an interval that is not a number.
    let is_narrow = high <= ratio * low;
    let is_limited = low > range[0] || high < range[1];
    !(is_narrow || is_significant && is_limited)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_absent(value: f64, half_width: f64, probability: f64) -> bool {
        let info = ParameterInfo::linear("force_n", [-10.0, 10.0]);
        let interval = Interval { value, ci95: [value - half_width, value + half_width] };
        may_be_absent([(&info, interval)], |_, _| 1.0, |_| 0.0, probability)
    }

    /// 1.96 standard deviations are 95 %, and 3.12 are all but 5 % of 28 candidates.
    #[test]
    fn a_region_of_many_candidates_is_wider() {
        assert!(is_absent(0.9, 1.0, OF_INTERVALS));
        assert!(!is_absent(1.1, 1.0, OF_INTERVALS));
        let of_all = 1.0 - 0.05 / 28.0;
        assert!(is_absent(1.55, 1.0, of_all));
        assert!(!is_absent(1.65, 1.0, of_all));
    }

    /// A time constant of at least 0.2 s is enough beside a significant amplitude; the whole range, or no number, never is.
    #[test]
    fn a_wide_scale_is_no_reason_against_a_significant_magnitude() {
        let info = ParameterInfo::scale("time_constant_s", [0.02, 1000.0]);
        let undetermined = |ci95: [f64; 2], is_significant: bool| {
            is_undetermined(&Interval { value: 4.0, ci95 }, &info, 100.0, is_significant)
        };
        assert!(!undetermined([1.0, 90.0], false));
        assert!(undetermined([0.2, 90.0], false));
        assert!(!undetermined([0.2, 90.0], true));
        assert!(!undetermined([0.2, 1000.0], true));
        assert!(undetermined([0.02, 1000.0], true));
        assert!(undetermined([f64::NAN; 2], true));
    }

    /// A cause without a parameter that switches it off is there.
    #[test]
    fn a_scale_alone_is_never_absent() {
        let info = ParameterInfo::scale("time_constant_s", [0.01, 10.0]);
        let interval = Interval { value: 1.0, ci95: [0.0, 2.0] };
        assert!(!may_be_absent([(&info, interval)], |_, _| 1.0, |_| 0.0, OF_INTERVALS));
    }
}
