//! Predictions before and after, for figures.

use super::TestSet;
use crate::fit::Hypothesis;
use crate::search::Candidates;

/// A test recording with both predictions, on the grid points.
#[derive(Debug, Clone)]
pub struct Trace {
    /// Its name.
    pub name: String,
    /// Time in the recording, s.
    pub time_s: Vec<f64>,
    /// Excitation; empty without one.
    pub excitation: Vec<f64>,
    /// Measured channels.
    pub measured: Vec<Vec<f64>>,
    /// Predicted before.
    pub before: Vec<Vec<f64>>,
    /// Predicted after.
    pub after: Vec<Vec<f64>>,
}

impl<C: Candidates + ?Sized> TestSet<'_, C> {
    /// Both predictions of every experiment, with the nuisances of the test recordings at the prior mean; experiments on which one of them
    /// cannot be simulated are left out.
    #[must_use]
    pub fn traces(&self, before: &Hypothesis, after: &Hypothesis) -> Vec<Trace> {
        let problem = &self.problem;
        let [before, after] =
            [before, after].map(|h| h.without_locals(problem.system, problem.len()));
        (0..problem.len())
            .filter_map(|i| {
                let (e, window) = (problem.experiments[i], problem.windows[i].clone());
                let cut = |series: &[f64]| -> Vec<f64> {
                    series.get(window.clone()).map(<[f64]>::to_vec).unwrap_or_default()
                };
                let run = |h: &Hypothesis| -> Option<Vec<Vec<f64>>> {
                    Some(problem.simulate(h, i).ok()?.iter().map(|c| cut(c)).collect())
                };
                let outputs = 0..problem.system.outputs().len();
                Some(Trace {
                    name: problem.system.name(e).to_owned(),
                    time_s: window
                        .clone()
                        .map(|k| problem.system.start_s(e) + problem.system.time_s(e, k))
                        .collect(),
                    excitation: cut(&problem.system.excitation(e)),
                    measured: outputs.map(|c| cut(problem.system.measured(e, c))).collect(),
                    before: run(&before)?,
                    after: run(&after)?,
                })
            })
            .collect()
    }
}
