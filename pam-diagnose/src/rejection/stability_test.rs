//! Whether a cause has one value at all times and in all recordings.

use crate::fit::{Fit, Influences, Problem};
use crate::search::Candidates;
use pam_numerics::statistics::chi_square_quantile;
use serde::Serialize;

/// A parameter that changes within a recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChangeInTime {
    /// The parameter.
    pub parameter: &'static str,
    /// The recording in which it changes most clearly.
    pub recording: String,
    /// When, s.
    pub time_s: f64,
    /// Its value before, to first order.
    pub before: f64,
    /// Its value after.
    pub after: f64,
}

/// A parameter that differs between recordings.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DifferenceBetween {
    /// The parameter.
    pub parameter: &'static str,
    /// Its value in each recording, to first order.
    pub values: Vec<(String, f64)>,
    /// The condition of the recordings with which it goes, and whether it grows with it; absent if none is clear.
    pub grows_with: Option<(String, bool)>,
}

/// Tests of one cause for a common value of all its parameters.
///
/// The scores of the likelihood, block of time by block of time, sum to zero over all blocks at the best fit. Where the
/// value changes with time, their cumulative sum within a recording drifts away and returns: its largest excursion is that
/// of a Brownian bridge otherwise (Andrews 1993; Zeileis and Hornik 2007). Where recordings differ, their sums differ by
/// more than their scatter: a χ² (Cochran 1954).
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct StabilityTest {
    /// A change within a recording.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub in_time: Option<ChangeInTime>,
    /// A difference between recordings.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub between: Option<DifferenceBetween>,
}

/// Smallest change, relative to the value, that is worth a word.
const LEAST_CHANGE: f64 = 0.25;
/// Fewest blocks of a recording in which a change is looked for.
const FEWEST_BLOCKS: usize = 6;
/// Correlation from which a parameter goes with a condition.
const CLEAR_CORRELATION: f64 = 0.8;

impl StabilityTest {
    /// Tests the parameters `of` (places among the fitted parameters) of a fit. `None` if the scores cannot be computed.
    pub(crate) fn of<C: Candidates + ?Sized>(
        problem: &Problem<'_, C>,
        fit: &Fit,
        influences: &Influences,
        of: std::ops::Range<usize>,
    ) -> Self {
        let tests = (of.len() * (problem.len() + 1)).max(1) as f64;
        let tail = (1.0 - problem.settings.rejection.stability_test_quantile) / tests;
        let parameters = fit.hypothesis.parameters(problem.system);
        let mut found = Self::default();
        for k in of {
            let p = &parameters[k];
            let value = fit.hypothesis.members[p.member].values[p.value];
            let size = (value - p.info.off.unwrap_or(0.0)).abs();
            // Influences are in the coordinate of the fit.
            let slope = if p.info.logarithmic { value } else { 1.0 };
            let series = Series { problem, influences, k, value, slope, size };
            if found.in_time.is_none() {
                found.in_time = series.in_time(tail).map(|mut c| {
                    c.parameter = p.info.name;
                    c
                });
            }
            if found.between.is_none() && problem.len() > 1 {
                found.between = series.between(tail).map(|mut d| {
                    d.parameter = p.info.name;
                    d
                });
            }
        }
        found
    }

    /// Whether there is neither a change nor a difference.
    #[must_use]
    pub fn holds(&self) -> bool {
        self.in_time.is_none() && self.between.is_none()
    }

    /// In words; empty if the value is constant.
    #[must_use]
    pub fn sentence(&self, effect: &str) -> String {
        use pam_core::units::significant;
        let n = |v: f64| significant(v, 3);
        let mut parts = Vec::new();
        if let Some(c) = &self.in_time {
            parts.push(format!(
                "`{}` of {effect} changes at t = {} s in {}, from {} to {}",
                c.parameter,
                n(c.time_s),
                c.recording,
                n(c.before),
                n(c.after)
            ));
        }
        if let Some(d) = &self.between {
            let [low, high] = d
                .values
                .iter()
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v.1), h.max(v.1)]);
            let with = match &d.grows_with {
                Some((what, true)) => format!("; it grows with the {what}"),
                Some((what, false)) => format!("; it falls with the {what}"),
                None => String::new(),
            };
            let constant =
                if self.in_time.is_none() { " is constant within a recording and" } else { "" };
            parts.push(format!(
                "`{}` of {effect}{constant} differs between recordings, from {} to {}{with}",
                d.parameter,
                n(low),
                n(high)
            ));
        }
        parts.join("; ")
    }
}

/// The influences of blocks on one parameter.
struct Series<'s, 'a, C: ?Sized> {
    problem: &'s Problem<'a, C>,
    influences: &'s Influences,
    k: usize,
    value: f64,
    slope: f64,
    size: f64,
}

impl<C: Candidates + ?Sized> Series<'_, '_, C> {
    fn of_experiment(&self, place: usize) -> Vec<f64> {
        let pairs = self.influences.values[self.k].iter().zip(&self.influences.experiments);
        pairs.filter(|(_, e)| **e == place).map(|(v, _)| *v).collect()
    }

    /// The value that blocks with a mean influence would give by themselves.
    fn value_of(&self, mean_influence: f64) -> f64 {
        let blocks = self.influences.experiments.len() as f64;
        self.value + self.slope * mean_influence * blocks
    }

    fn in_time(&self, tail: f64) -> Option<ChangeInTime> {
        // P(sup |bridge| > x) ≈ 2 exp(−2 x²).
        let quantile = (0.5 * (2.0 / tail).ln()).sqrt();
        let mut best: Option<(f64, ChangeInTime)> = None;
        for place in 0..self.problem.len() {
            let own = self.of_experiment(place);
            let n = own.len();
            if n < FEWEST_BLOCKS {
                continue;
            }
            let mean = own.iter().sum::<f64>() / n as f64;
            // The scatter about the two sides of the largest excursion: a change is no scatter.
            let mut sum = 0.0;
            let (mut at, mut excursion) = (0, 0.0_f64);
            for (k, v) in own.iter().enumerate() {
                sum += v - mean;
                if sum.abs() > excursion {
                    (at, excursion) = (k + 1, sum.abs());
                }
            }
            if at == 0 || at >= n {
                continue;
            }
            let of = |side: &[f64]| side.iter().sum::<f64>() / side.len() as f64;
            let (first, second) = (of(&own[..at]), of(&own[at..]));
            let left: f64 = own[..at].iter().map(|v| (v - first).powi(2)).sum::<f64>()
                + own[at..].iter().map(|v| (v - second).powi(2)).sum::<f64>();
            let deviation = (left / (n as f64 - 2.0)).sqrt();
            let ratio = excursion / (deviation * (n as f64).sqrt()).max(f64::MIN_POSITIVE);
            let (before, after) = (self.value_of(first), self.value_of(second));
            if ratio > quantile
                && (after - before).abs() > LEAST_CHANGE * self.size
                && best.as_ref().is_none_or(|b| ratio > b.0)
            {
                let e = self.problem.experiments[place];
                let points =
                    self.problem.rows_per_block(place) * self.problem.system.points_per_row();
                let point = self.problem.windows[place].start + at * points;
                let change = ChangeInTime {
                    parameter: "",
                    recording: self.problem.system.name(e).to_owned(),
                    time_s: self.problem.system.start_s(e) + self.problem.system.time_s(e, point),
                    before,
                    after,
                };
                best = Some((ratio, change));
            }
        }
        best.map(|b| b.1)
    }

    fn between(&self, tail: f64) -> Option<DifferenceBetween> {
        let count = self.problem.len();
        let mut statistic = 0.0;
        let mut values = Vec::new();
        for place in 0..count {
            let own = self.of_experiment(place);
            let n = own.len() as f64;
            if own.len() < 2 {
                return None;
            }
            let mean = own.iter().sum::<f64>() / n;
            let variance = own.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
            // With few blocks the variance is uncertain: F instead of χ².
            let correction = (n - 1.0) / (n + 1.0);
            statistic += correction * n * mean * mean / variance.max(f64::MIN_POSITIVE);
            let name = self.problem.system.name(self.problem.experiments[place]).to_owned();
            values.push((name, self.value_of(mean)));
        }
        let limit = chi_square_quantile(1.0 - tail, count as f64 - 1.0);
        let [low, high] = values
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], v| [l.min(v.1), h.max(v.1)]);
        if !(statistic > limit && high - low > LEAST_CHANGE * self.size) {
            return None;
        }
        let grows_with = self.grows_with(&values);
        Some(DifferenceBetween { parameter: "", values, grows_with })
    }

    /// The condition of the recordings that correlates best with the values.
    fn grows_with(&self, values: &[(String, f64)]) -> Option<(String, bool)> {
        if values.len() < 3 {
            return None;
        }
        let system = self.problem.system;
        let mut conditions: Vec<(String, Vec<f64>)> = Vec::new();
        for (c, output) in system.outputs().iter().enumerate() {
            let of = |&e: &usize| {
                let y = system.measured(e, c);
                let mean = y.iter().sum::<f64>() / y.len().max(1) as f64;
                let square =
                    y.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / y.len().max(1) as f64;
                (mean, square.sqrt())
            };
            let each: Vec<(f64, f64)> = self.problem.experiments.iter().map(of).collect();
            let mean = each.iter().map(|m| m.0).collect();
            let size = each.iter().map(|m| m.1).collect();
            conditions.push((format!("mean {}", output.name), mean));
            conditions.push((format!("amplitude of the {}", output.name), size));
        }
        let y: Vec<f64> = values.iter().map(|v| v.1).collect();
        conditions
            .into_iter()
            .map(|(name, x)| (name, correlation(&x, &y)))
            .filter(|(_, r)| r.abs() > CLEAR_CORRELATION)
            .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
            .map(|(name, r)| (name, r > 0.0))
    }
}

/// Correlation of two series; 0 if one of them is constant.
pub(crate) fn correlation(x: &[f64], y: &[f64]) -> f64 {
    let mean = |v: &[f64]| v.iter().sum::<f64>() / v.len().max(1) as f64;
    let (mx, my) = (mean(x), mean(y));
    let sum =
        |f: &dyn Fn(f64, f64) -> f64| x.iter().zip(y).map(|(a, b)| f(a - mx, b - my)).sum::<f64>();
    let size = sum(&|a, _| a * a).sqrt() * sum(&|_, b| b * b).sqrt();
    if size > 0.0 { sum(&|a, b| a * b) / size } else { 0.0 }
}
