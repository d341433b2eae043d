//! The baseline discrepancy: the error of a model on recordings on which it was validated.

use crate::data::{Roles, Split};
use crate::error::DiagnoseError;
use crate::fit::Member;
use crate::search::{Candidates, refit, search};
use crate::settings::DiagnosisSettings;

/// Candidates and error level of baseline recordings. A model that misses something small everywhere misses it in the
/// data under diagnosis as well; that counts as no fault.
pub(crate) struct Baseline {
    /// Candidates that the baseline recordings show; part of the model from there on.
    pub(crate) members: Vec<Member>,
    /// Root-mean-square errors of the fitted channels that are left then.
    pub(crate) rms: Vec<f64>,
    /// Names of the recordings.
    pub(crate) recordings: Vec<String>,
}

impl Baseline {
    /// Learns the discrepancy from experiments whose roles leave no test set.
    pub(crate) fn learn<C: Candidates + ?Sized>(
        system: &C,
        roles: &Roles,
        noise: &[f64],
        settings: &DiagnosisSettings,
        done: &(dyn Fn(f64) + Sync),
    ) -> Result<Self, DiagnoseError> {
        let most = settings.search.max_causes.max(settings.verdict.baseline_causes);
        let found = search(&roles.split(system, noise, settings), most, done).ok_or_else(|| {
            DiagnoseError::TooLittle("the model diverges on the baseline recordings".into())
        })?;
        let whole = Split::fit_all(roles.whole(system, noise, settings));
        let refitted = refit::refit(&whole, &found);
        // Validation rows have no nuisances of their own: the errors of both, as in the data to come.
        let chosen = refitted.as_ref().map_or(&found.best, |s| &s.chosen);
        let left = chosen.fit.errors.and(&chosen.validation);
        let best = refitted.as_ref().map_or(&found.best, |s| &s.whole);
        Ok(Self {
            members: best.hypothesis().members.clone(),
            rms: left.mean().into_iter().map(f64::sqrt).collect(),
            recordings: whole.train.names(),
        })
    }
}
