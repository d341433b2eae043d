//! What a diagnosis of a field leaves, learned.

use super::candidate::Candidate;
use super::diagnose::{FieldDiagnosis, Setup, with_setup};
use super::options::FieldOptions;
use super::terms::FieldTerms;
use crate::error::DiagnoseError;
use crate::law::{Data, NOTHING_LEFT, rest};
use crate::noise::Noise;
use crate::remainder::{
    Budget, Ground, Remainder, RemainderOutcome, is_replaceable, named_and_settled, nothing_left,
};
use pam_core::ParametricField;
use pam_solvers::Input;
use pam_train::field::FieldProblem;
use std::sync::Arc;

/// Learns what the named causes of a diagnosis leave of a field's error: a smooth correction of the rate of one of its states,
/// through the simulation, and a short law in its place if there is one ([`remainder`](crate::remainder),
/// [`law`](crate::law)).
///
/// Problem, candidates and options are those of the [`diagnose_field`](super::diagnose_field) that made the diagnosis. The
/// result has [`remainder`](crate::Diagnosis::remainder), whose definitions [`Terms::read`](pam_expression::Terms) reads; a
/// verdict of `explained` becomes `partly_explained`, one of `nothing_found` `unexplained`, if the test set confirms them.
///
/// # Errors
/// [`DiagnoseError`] as of the diagnosis.
pub fn learn_remainder_field<F, I>(
    problem: &FieldProblem<'_, F, I>,
    candidates: &[Candidate],
    options: &FieldOptions,
    mut found: FieldDiagnosis,
) -> Result<FieldDiagnosis, DiagnoseError>
where
    F: ParametricField + Sync,
    I: Input<f64> + Sync,
{
    if nothing_left(&found, &options.settings.remainder) {
        found.remainder = Some(Remainder::none(RemainderOutcome::NothingLeft, NOTHING_LEFT));
        return Ok(found);
    }
    with_setup(problem, candidates, options, |setup| {
        let Setup { problem, settings, roles, noise, mut prior, experiments, .. } = setup;
        prior.discrepancy.add(&found.model.discrepancy);
        let causes = || found.causes.iter().chain(&found.minor);
        let listed: Vec<Candidate> =
            causes().map(|c| candidates[c.member.candidate].clone()).collect();
        let (named, settled) = named_and_settled(&found);
        let plain = found.model.plain.clone();
        let space = FieldTerms::new(problem, experiments, listed, plain, options);
        let ground = Ground {
            roles: &roles,
            noise: Noise::white(&noise),
            prior,
            listed: named.len(),
            named,
            settled,
            rivals: Vec::new(),
            margin: 0.0,
            replaceable: is_replaceable(&found),
            choices: candidates.len(),
            settings: &settings,
            seed: options.seed,
            budget: Budget::unlimited(Arc::default()),
        };
        let rest = rest(&Data::whole(&space, &ground), found.verdict, &|_| {})?;
        rest.put_into(&mut found);
        Ok(found)
    })
}
