//! Values that a cause appears to have where it is absent.

use crate::fit::{Interval, Member, Problem, is_magnitude};
use crate::onset::{Acts, Pattern, Schedule};
use crate::search::Candidates;
use pam_core::parallel;
use pam_numerics::statistics::t_quantile_95;
use pam_vocabulary::ParameterInfo;
use std::sync::Arc;

/// Iterations of the weights of a variance between recordings.
const ITERATIONS: usize = 20;

/// The magnitudes that a candidate appears to have in baseline recordings, where it is absent: model errors resemble it, with a different
/// magnitude in each recording.
///
/// They are estimated twice, with free scales and with the scales of the cause, and the narrower interval is used: a model error that
/// resembles the cause shows in both. With free scales alone, a slack that begins where the motion hardly goes may have any size; with
/// held scales alone, a slack absorbs errors that a slack elsewhere fits better.
pub(crate) struct Apparent {
    /// With free scales and with held ones: for each baseline recording the deviations of the magnitudes from the values at which they
    /// are off, with standard errors.
    each: Vec<Vec<Vec<[f64; 2]>>>,
    /// The place of each magnitude among the parameters.
    magnitudes: Vec<usize>,
    /// Number of parameters.
    parameters: usize,
    /// Recordings that are diagnosed.
    diagnosed: usize,
}

impl Apparent {
    /// Fits the cause alone to each baseline recording, once from its own values and once from small magnitudes, and keeps the better
    /// fit. An onset or end that all diagnosed recordings share is kept: model errors recur at the same time under the same excitation.
    /// Empty without baseline recordings.
    pub(crate) fn of<C: Candidates + ?Sized>(
        baseline: Option<&Problem<'_, C>>,
        cause: &Member,
        infos: &[ParameterInfo],
        diagnosed: usize,
    ) -> Self {
        let magnitudes: Vec<usize> =
            (0..infos.len()).filter(|&k| is_magnitude(&infos[k])).collect();
        let seen = |(i, (_, info)): (&Interval, &(usize, ParameterInfo))| {
            [i.value - info.off.unwrap_or(0.0), i.deviation()]
        };
        // A cause without magnitudes needs no fits.
        let baseline = baseline.filter(|_| !magnitudes.is_empty());
        let has_scales = magnitudes.len() < infos.len();
        let ways = if has_scales { &[false, true][..] } else { &[false] };
        let seen_with = |baseline: &Problem<'_, C>, scales_held: bool| {
            let settings = &baseline.settings.intervals;
            let iterations = settings.baseline_iterations;
            let cause = on_baseline(cause, baseline.system.experiment_len());
            let cause = Member { scales_held, ..cause };
            let fitted = cause.fitted(baseline.system);
            let mut small = cause.own().to_vec();
            for &k in &magnitudes {
                let off = infos[k].off.unwrap_or(0.0);
                small[k] = off + settings.baseline_small_share * (small[k] - off);
            }
            let starts = [cause.with_own(&small), cause];
            let all = parallel::map(baseline.len(), |i| {
                let alone = baseline.part(i, baseline.windows[i].clone());
                let fits = starts.iter().filter_map(|start| {
                    alone.fit(alone.base().with_member(start.clone()), iterations).ok()
                });
                let fit = fits.min_by(|a, b| a.cost.total_cmp(&b.cost))?;
                let intervals = alone.intervals(&fit).ok()?;
                let all = intervals.iter().zip(&fitted);
                Some(all.filter(|(_, (_, info))| is_magnitude(info)).map(seen).collect::<Vec<_>>())
            });
            all.into_iter().flatten().collect::<Vec<_>>()
        };
        let each = baseline.map_or_else(Vec::new, |baseline| {
            ways.iter().map(|&held| seen_with(baseline, held)).collect()
        });
        Self { each, magnitudes, parameters: infos.len(), diagnosed }
    }

    /// Half-width of the 95 % interval that the apparent values give a parameter; zero for a parameter that is not a magnitude.
    pub(crate) fn half_width(&self, parameter: usize) -> f64 {
        let mut weights = vec![0.0; self.parameters];
        weights[parameter] = 1.0;
        self.half_width_of(&weights)
    }

    /// The same of a sum of parameters with these weights: for the mean of so many recordings as are diagnosed beside so many
    /// baseline recordings.
    pub(super) fn half_width_of(&self, weights: &[f64]) -> f64 {
        let along = |recording: &Vec<[f64; 2]>| {
            let terms = recording.iter().zip(&self.magnitudes);
            let [value, square] = terms.fold([0.0, 0.0], |[value, square], ([v, s], &k)| {
                [value + weights[k] * v, square + (weights[k] * s).powi(2)]
            });
            [value, square.sqrt()]
        };
        let half_width = |each: &Vec<Vec<[f64; 2]>>| {
            let seen: Vec<[f64; 2]> = each.iter().map(along).collect();
            between_recordings(&seen).map_or(0.0, |(deviation, count)| {
                let means = (1.0 / self.diagnosed as f64 + 1.0 / count).sqrt();
                t_quantile_95(count) * deviation * means
            })
        };
        self.each.iter().map(half_width).reduce(f64::min).unwrap_or(0.0)
    }
}

/// The cause with a schedule for the baseline recordings: the onset and end that all diagnosed recordings share, or none if they differ.
fn on_baseline(cause: &Member, recordings: usize) -> Member {
    let shared = cause.schedule.as_ref().filter(|s| s.pattern == Pattern::Shared);
    let timed = |s: &Arc<Schedule>| s.acts.iter().position(|a| matches!(a, Acts::Within(..)));
    match shared.and_then(|s| Some((s, timed(s)?))) {
        Some((schedule, like)) => Member {
            schedule: Some(Arc::new(schedule.held().of_parts(&vec![like; recordings]))),
            ..cause.clone()
        },
        None => Member::always(cause.candidate, cause.own()),
    }
}

/// The standard deviation about zero of a value that differs between recordings, from one estimate `v_i` with its standard error
/// `s_i` of each, and the number of recordings that tell it; `None` where nothing shows beside the errors.
///
/// `v_i` has the variance `τ² + s_i²`, so `τ² = Σ w_i (v_i² − s_i²) / Σ w_i`, with the weights `w_i = (τ² + s_i²)⁻²` of the best such
/// mean (the method of moments of random effects; DerSimonian and Laird 1986). A recording that shows little of the value counts
/// like one that shows much of it.
fn between_recordings(seen: &[[f64; 2]]) -> Option<(f64, f64)> {
    let known: Vec<[f64; 2]> =
        seen.iter().copied().filter(|[v, s]| v.is_finite() && s.is_finite() && *s > 0.0).collect();
    let scale = known.iter().map(|[_, s]| s * s).fold(f64::INFINITY, f64::min);
    let mut variance = known.iter().map(|[v, _]| v * v).sum::<f64>() / known.len().max(1) as f64;
    for _ in 0..ITERATIONS {
        let (mut sum, mut weights) = (0.0, 0.0);
        for [v, s] in &known {
            let weight = (scale / (variance + s * s)).powi(2);
            sum += weight * (v * v - s * s);
            weights += weight;
        }
        variance = (sum / weights).max(0.0);
    }
    // Not a number without any recording.
    if variance.is_nan() || variance <= 0.0 {
        return None;
    }
    let shares: Vec<f64> = known.iter().map(|[_, s]| variance / (variance + s * s)).collect();
    let (sum, squares) = (shares.iter().sum::<f64>(), shares.iter().map(|w| w * w).sum::<f64>());
    Some((variance.sqrt(), (sum * sum / squares).max(1.0)))
}
