//! The steps of a diagnosis.

use super::result::{Diagnosis, Explainable, Stage};
use crate::data::{Roles, Split, TestData};
use crate::error::DiagnoseError;
use crate::fit::{Hypothesis, Problem};
use crate::residual::ResidualSummary;
use crate::search::{Candidates, fit_base, search};
use crate::settings::DiagnosisSettings;
use crate::verdict::{Naming, ranking, share};

/// A system whose experiments have their roles.
#[derive(Debug)]
pub struct Prepared<'a, C: ?Sized> {
    /// The system with its candidates.
    pub system: &'a C,
    /// The role of each experiment.
    pub roles: &'a Roles,
    /// Standard deviation below which an error counts as noise, for each fitted channel: noise, joined by the baseline
    /// discrepancy.
    pub noise: Vec<f64>,
    /// Baseline recordings, if they were given.
    pub baseline: Option<Problem<'a, C>>,
    /// The settings.
    pub settings: &'a DiagnosisSettings,
    /// Seed of the null test and the bootstrap.
    pub seed: u64,
}

/// Diagnoses any system: searches with the training and validation data, refits and names with both, and measures on the
/// test set. `model` makes the system's own part of the result from the final hypothesis.
///
/// # Errors
/// [`DiagnoseError`] if the system without any cause cannot be simulated.
pub fn run<C: Candidates + ?Sized, M>(
    prepared: &Prepared<'_, C>,
    progress: &(dyn Fn(Stage, f64) + Sync),
    model: impl FnOnce(&Hypothesis) -> M,
) -> Result<Diagnosis<M>, DiagnoseError> {
    let Prepared { system, roles, noise, baseline, settings, seed } = prepared;
    let choosing = roles.split(*system, noise, settings);
    let whole = Split::fit_all(roles.whole(*system, noise, settings));
    let open = &whole.train;
    // The model alone must be able to run at all.
    open.errors(&open.base())?;
    let diverges =
        || DiagnoseError::TooLittle("the model diverges on the recordings to be fitted".into());
    let most = settings.search.max_causes;
    let found = search(&choosing, most, &|s| progress(Stage::Searching, s)).ok_or_else(diverges)?;
    progress(Stage::Judging, 0.0);
    let base = fit_base(&whole).ok_or_else(diverges)?;
    let named = Naming {
        choosing: &choosing,
        whole: &whole,
        found: &found,
        base: &base,
        baseline: baseline.as_ref(),
        seed: *seed,
    }
    .named()?;
    // Every decision is made. Only now is the test set opened.
    let test = roles.test(*system, noise, settings);
    let best = named.best.hypothesis();
    let start = base.hypothesis().at_prior_mean(*system, open.len());
    let (before, after) = (test.chi_square(base.hypothesis()), test.chi_square(best));
    let lowest = after.min(1.0);
    let any_correction = test
        .explainable(open, base.hypothesis())
        .map_or(0.0, |chi| share(before, chi.min(after), lowest));
    Ok(Diagnosis {
        verdict: named.verdict,
        causes: named.causes,
        ranking: ranking(&choosing, &found.base, &found.singles),
        residual: ResidualSummary::of(open, &start, best),
        error_reduction: test.error_reduction(&start, best, *seed),
        explainable: Explainable { any_correction, named: share(before, after, lowest) },
        null_test: named.null_test,
        validation: roles.validation_data.clone(),
        test: roles.test_data.clone().unwrap_or(TestData::Given { recordings: Vec::new() }),
        fitted: open.names(),
        model: model(best),
        noise: noise.clone(),
        outputs: system.outputs().to_vec(),
        excitation_label: system.excitation_label(),
        traces: test.traces(&start, best),
    })
}
