//! Ladders of terms of a field.

use super::candidate::Candidate;
use super::diagnose::{Setup, with_setup};
use super::options::FieldOptions;
use super::system::FieldSystem;
use crate::diagnosis::Prepared;
use crate::error::DiagnoseError;
use crate::ladder::{Ladder, RungModel, climb};
use pam_core::ParametricField;
use pam_solvers::Input;
use pam_train::field::{FieldError, FieldProblem};

/// A rung of a ladder of a field: terms that are there together.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldRung {
    /// Id.
    pub id: String,
    /// What it is.
    pub description: String,
    /// Names of its candidates.
    pub candidates: Vec<String>,
}

impl FieldRung {
    /// A rung of candidates by their names.
    #[must_use]
    pub fn new(id: &str, description: &str, candidates: &[&str]) -> Self {
        Self {
            id: id.to_owned(),
            description: description.to_owned(),
            candidates: candidates.iter().map(|c| (*c).to_owned()).collect(),
        }
    }
}

/// Fits every rung to the experiments of a problem, with the rows, priors and noise of
/// [`diagnose_field`](super::diagnose_field). Baseline experiments do not count.
///
/// # Errors
/// [`DiagnoseError`] as for [`diagnose_field`](super::diagnose_field), or if a rung names a candidate that there is not.
pub fn field_ladder<F, I>(
    problem: &FieldProblem<'_, F, I>,
    candidates: &[Candidate],
    name: &str,
    rungs: &[FieldRung],
    options: &FieldOptions,
) -> Result<Ladder, DiagnoseError>
where
    F: ParametricField + Sync,
    I: Input<f64> + Sync,
{
    let find = |rung: &FieldRung, candidate: &String| {
        candidates.iter().position(|c| c.name == *candidate).ok_or_else(|| {
            let known: Vec<&str> = candidates.iter().map(|c| c.name.as_str()).collect();
            FieldError::Shape(format!(
                "rung `{}`: there is no candidate `{candidate}`; there are {}",
                rung.id,
                known.join(", ")
            ))
        })
    };
    let models = rungs
        .iter()
        .map(|rung| {
            let candidates: Result<Vec<usize>, FieldError> =
                rung.candidates.iter().map(|c| find(rung, c)).collect();
            Ok(RungModel {
                id: rung.id.clone(),
                description: rung.description.clone(),
                candidates: candidates?,
            })
        })
        .collect::<Result<Vec<RungModel>, DiagnoseError>>()?;
    with_setup(problem, candidates, options, |setup| {
        let Setup { problem, settings, roles, noise, prior, experiments, .. } = setup;
        let system = FieldSystem::new(problem, experiments, candidates, options);
        let prepared = Prepared {
            system: &system,
            roles: &roles,
            noise,
            prior,
            baseline_discrepancy: Vec::new(),
            baseline: None,
            settings: &settings,
            seed: options.seed,
        };
        climb(&prepared, name, &models, &|_| {})
    })
}
