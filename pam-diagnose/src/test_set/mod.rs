//! The test set: rows that no fit, search or rejection of a name has read.
//!
//! A [`TestSet`] does not give its rows away. It answers only for hypotheses that are final: their errors, the error
//! reduction, the share that a flexible model explains, and trajectories for figures.

mod error_reduction;
mod trace;

pub use error_reduction::{ChannelReduction, ErrorReduction, GroupReduction, OverallReduction};
pub use trace::Trace;

use crate::fit::{Hypothesis, Problem};
use crate::search::Candidates;
use crate::verdict::ExplainableReference;

/// The test rows.
#[derive(Debug)]
pub struct TestSet<'a, C: ?Sized> {
    problem: Problem<'a, C>,
}

impl<'a, C: Candidates + ?Sized> TestSet<'a, C> {
    pub(crate) fn new(problem: Problem<'a, C>) -> Self {
        Self { problem }
    }

    /// Normalised χ² of a hypothesis with the nuisances of the test experiments at the prior mean; infinite if the
    /// simulation fails.
    pub(crate) fn chi_square(&self, hypothesis: &Hypothesis) -> f64 {
        let errors = self.problem.errors(&self.unfitted(hypothesis));
        errors.map_or(f64::INFINITY, |e| e.chi_square(&self.problem.noise))
    }

    /// Normalised χ² that a flexible model reaches which learned the residual of a hypothesis on the open rows.
    pub(crate) fn explainable(
        &self,
        open: &Problem<'_, C>,
        hypothesis: &Hypothesis,
    ) -> Option<f64> {
        let here = self.unfitted(hypothesis);
        ExplainableReference::learn((open, hypothesis), (&self.problem, &here))
            .map(|r| r.errors.chi_square(&self.problem.noise))
    }

    fn unfitted(&self, hypothesis: &Hypothesis) -> Hypothesis {
        Hypothesis { locals: self.problem.base().locals, ..hypothesis.clone() }
    }
}
