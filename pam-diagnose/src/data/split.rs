//! Training and validation rows.

use crate::error::DiagnoseError;
use crate::fit::{ChannelErrors, Hypothesis, Problem};
use crate::search::Candidates;

/// Rows to which hypotheses are fitted, and rows by which they are chosen.
#[derive(Debug)]
pub struct Split<'a, C: ?Sized> {
    /// The fitted rows.
    pub train: Problem<'a, C>,
    /// The validation rows.
    pub validation: Problem<'a, C>,
    /// Whether both are parts of the same experiments, which then share their nuisances.
    pub same_experiments: bool,
}

impl<'a, C: Candidates + ?Sized> Split<'a, C> {
    /// A fitted hypothesis on the validation rows: experiments that were not fitted have their nuisances at the prior
    /// mean.
    #[must_use]
    pub fn on_validation(&self, fitted: &Hypothesis) -> Hypothesis {
        if self.same_experiments {
            return fitted.clone();
        }
        self.validation.with_base_locals(fitted)
    }

    /// Errors on the validation rows.
    ///
    /// # Errors
    /// [`DiagnoseError`] if the simulation fails.
    pub fn validation_errors(&self, fitted: &Hypothesis) -> Result<ChannelErrors, DiagnoseError> {
        self.validation.errors(&self.on_validation(fitted))
    }
}
