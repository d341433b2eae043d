//! Whether a named effect is the same everywhere.

use super::explore::{Scored, Search};
use rayon::prelude::*;
use serde::Serialize;

/// One effect's first parameter, fitted to parts of the recordings.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Constancy {
    /// Name of the parameter.
    pub parameter: &'static str,
    /// Recording, start of the part (s), value there.
    pub parts: Vec<(String, f64, f64)>,
    /// Spread of the parts (half the distance of the quartiles) over the size of the common value.
    pub relative_spread: f64,
}

/// Parts of each recording.
const PARTS: usize = 3;

impl<'e> Search<'_, 'e> {
    /// Fits the effect at `place` of a fitted set anew to thirds of each recording, with everything else as
    /// it is. An effect that is real has one value; a name that only mimics another cause has as many as
    /// there are parts.
    #[must_use]
    pub fn constancy(&self, scored: &Scored<'e>, place: usize) -> Option<Constancy> {
        let fitted = &scored.fit.hypothesis;
        let at = fitted.fixed + place;
        let info = *fitted.effects.get(at)?.info().parameters.first()?;
        // The effect goes to the end, where it alone is fitted.
        let mut alone = fitted.without(place);
        alone.fixed = alone.effects.len();
        let alone = alone.with(fitted.effects[at], &fitted.values[fitted.value_range(at)]);
        let common = fitted.values[fitted.value_range(at).start];
        let parts: Vec<(String, f64, f64)> = (0..self.split.train.len() * PARTS)
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
                let value = h.values[h.value_range(h.effects.len() - 1).start];
                let t = problem.trials[0];
                Some((t.source.name.clone(), from as f64 * t.step_s, value))
            })
            .collect();
        let mut values: Vec<f64> = parts.iter().map(|p| p.2).collect();
        values.sort_by(f64::total_cmp);
        let quartile = |share: f64| values[(share * (values.len() - 1) as f64).round() as usize];
        let relative_spread = if values.len() < 3 {
            0.0
        } else {
            0.5 * (quartile(0.75) - quartile(0.25)) / common.abs().max(1e-12)
        };
        Some(Constancy { parameter: info.name, parts, relative_spread })
    }
}
