//! Whether a named effect is the same everywhere.

use super::explore::{Scored, Search};
use crate::fit::coordinate;
use rayon::prelude::*;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, StudentsT};

/// One effect's parameters, fitted to parts of the recordings.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Constancy {
    /// Name of the parameter.
    pub parameter: &'static str,
    /// Recording, start of the part (s), value there.
    pub parts: Vec<(String, f64, f64)>,
    /// Spread of the parts (half the distance of the quartiles) over the size of the common value.
    pub relative_spread: f64,
    /// Half the 95 % interval of each parameter's mean over the parts, in the coordinate in which it is
    /// fitted; zero for fewer than four parts. It holds errors of the model that change from part to part,
    /// which the scatter of the residuals does not show.
    #[serde(skip)]
    pub half_widths: Vec<f64>,
}

/// Parts of each recording.
const PARTS: usize = 3;
/// Fewest parts that say something of the spread.
const FEWEST: usize = 4;

impl<'e> Search<'_, 'e> {
    /// Fits the effect at `place` of a fitted set anew to thirds of each recording, with everything else as
    /// it is. An effect that is real has one value; a name that only mimics another cause has as many as
    /// there are parts.
    #[must_use]
    pub fn constancy(&self, scored: &Scored<'e>, place: usize) -> Option<Constancy> {
        let fitted = &scored.fit.hypothesis;
        let at = fitted.fixed + place;
        let infos = fitted.effects.get(at)?.info().parameters;
        let info = *infos.first()?;
        // The effect goes to the end, where it alone is fitted.
        let mut alone = fitted.without(place);
        alone.fixed = alone.effects.len();
        let alone = alone.with(fitted.effects[at], &fitted.values[fitted.value_range(at)]);
        let common = fitted.values[fitted.value_range(at).start];
        let parts: Vec<(String, f64, Vec<f64>)> = (0..self.split.train.len() * PARTS)
            .into_par_iter()
            .filter_map(|k| {
                let (trial, part) = (k / PARTS, k % PARTS);
                let whole = self.split.train.windows[trial].clone();
                let len = whole.len() / PARTS;
                let from = whole.start + part * len;
                let mut problem = self.split.train.with_windows(|_, _| from..from + len);
                problem.trials = vec![problem.trials[trial]];
                problem.windows = vec![problem.windows[trial].clone()];
                let mut start = alone.clone();
                start.locals = vec![alone.locals[trial]];
                let fit = problem.fit(start, 3).ok()?;
                let h = &fit.hypothesis;
                let first = h.value_range(h.effects.len() - 1).start;
                let values = h.values[first..first + infos.len()].to_vec();
                let t = problem.trials[0];
                Some((t.record.source.name.clone(), from as f64 * t.record.step_s, values))
            })
            .collect();
        let quartiles = |of: &dyn Fn(&[f64]) -> f64| {
            let mut values: Vec<f64> = parts.iter().map(|p| of(&p.2)).collect();
            values.sort_by(f64::total_cmp);
            let at = |share: f64| values[(share * (values.len() - 1) as f64).round() as usize];
            at(0.75) - at(0.25)
        };
        let n = parts.len();
        let relative_spread =
            if n < 3 { 0.0 } else { 0.5 * quartiles(&|v| v[0]) / common.abs().max(1e-12) };
        let half_widths = infos
            .iter()
            .enumerate()
            .map(|(k, info)| {
                if n < FEWEST {
                    return 0.0;
                }
                // Robust against parts in which the effect is hardly excited.
                let sd = quartiles(&|v| coordinate(v[k], *info)) / 1.349;
                let quantile =
                    StudentsT::new(0.0, 1.0, n as f64 - 1.0).map_or(1.96, |t| t.inverse_cdf(0.975));
                quantile * sd / (n as f64).sqrt()
            })
            .collect();
        let parts = parts.into_iter().map(|(name, start, values)| (name, start, values[0]));
        let parts = parts.collect();
        Some(Constancy { parameter: info.name, parts, relative_spread, half_widths })
    }
}
