//! Recordings that are fitted, and recordings that only judge.

use crate::fit::{ChannelErrors, Hypothesis, Local, Problem};
use pam_effects::simulation::Diverged;

/// A problem to fit and one to judge by.
#[derive(Debug, Clone)]
pub struct Split<'a> {
    /// What is fitted.
    pub train: Problem<'a>,
    /// What judges.
    pub held: Problem<'a>,
    /// Whether both are parts of the same trials, which then share what is uncertain of them.
    pub same_trials: bool,
}

impl<'a> Split<'a> {
    /// Everything is fitted and nothing judges: for names that are chosen already.
    #[must_use]
    pub fn fit_all(train: Problem<'a>) -> Self {
        let held = Problem { trials: Vec::new(), windows: Vec::new(), ..train.clone() };
        Self { train, held, same_trials: false }
    }

    /// A fitted hypothesis as it stands before the held-out trials: effects and the model's numbers as
    /// fitted, everything of the trials as measured.
    #[must_use]
    pub fn for_held<'e>(&self, fitted: &Hypothesis<'e>) -> Hypothesis<'e> {
        let mut h = fitted.clone();
        if !self.same_trials {
            h.locals = vec![Local::default(); self.held.len()];
        }
        h
    }

    /// Errors on the held-out rows.
    ///
    /// # Errors
    /// [`Diverged`].
    pub fn held_errors(&self, fitted: &Hypothesis<'_>) -> Result<ChannelErrors, Diverged> {
        self.held.errors(&self.for_held(fitted))
    }
}
