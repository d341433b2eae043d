//! Predictions before and after, for figures.

use crate::fit::{Hypothesis, Problem};
use pam_effects::simulation::Trajectory;

/// A held-out recording with both predictions, on the grid of the simulation.
#[derive(Debug, Clone)]
pub struct Trace {
    /// Its name.
    pub name: String,
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Force, N.
    pub force_n: Vec<f64>,
    /// Measured channels: mm, mm/s, kPa, kPa.
    pub measured: [Vec<f64>; 4],
    /// Predicted before.
    pub before: [Vec<f64>; 4],
    /// Predicted after.
    pub after: [Vec<f64>; 4],
}

/// Both predictions of every trial of a problem; those on which one diverges are left out.
pub(super) fn traces<'e>(
    problem: &Problem<'_>,
    before: &Hypothesis<'e>,
    after: &Hypothesis<'e>,
) -> Vec<Trace> {
    (0..problem.len())
        .filter_map(|i| {
            let (t, window) = (problem.trials[i], problem.windows[i].clone());
            let run = |h: &Hypothesis<'e>| {
                let mut out = Trajectory::default();
                problem.simulate(h, i, &mut out).ok()?;
                Some(out.channels.map(|c| c[window.clone()].to_vec()))
            };
            let force = t.record.force.values_mn();
            Some(Trace {
                name: t.record.source.name.clone(),
                time_s: window
                    .clone()
                    .map(|k| t.record.source.start_s + k as f64 * t.record.step_s)
                    .collect(),
                force_n: window.clone().map(|k| force[2 * k] / pam_core::units::MN_PER_N).collect(),
                measured: [0, 1, 2, 3].map(|c| t.record.measured[c][window.clone()].to_vec()),
                before: run(before)?,
                after: run(after)?,
            })
        })
        .collect()
}
