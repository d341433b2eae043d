//! A law that is fitted to all open rows.

use super::conclude::Final;
use super::refine::Tried;
use super::result::{Law, Replaced};
use super::written::{header, variable_names};
use crate::diagnosis::total;
use crate::error::DiagnoseError;
use crate::fit::{Fit, Hypothesis, Member, Problem};
use crate::rejection::{ParameterStability, StabilityTest, correlation};
use crate::remainder::{Dyn, Ground};
use crate::terms::{Definition, Term, TermSpace, VariableKind};
use crate::test_set::ErrorReduction;
use pam_numerics::statistics::mean;

/// Correlation from which values of recordings go with a variable.
const CLEAR_CORRELATION: f64 = 0.8;

/// A candidate that is always there with one value, beside the causes that stay.
fn replaced(
    ground: &Ground<'_>,
    open: &Problem<'_, Dyn<'_>>,
    kept: &[Member],
    member: &Member,
) -> Result<Replaced, DiagnoseError> {
    let info = open.system.candidate(member.candidate);
    let start = Hypothesis { members: kept.to_vec(), ..open.base() };
    let fit = open
        .fit(start.with(member.candidate, member.own()), ground.settings.search.tried_iterations)?;
    let intervals = open.intervals(&fit)?;
    let first = intervals.len() - info.parameters.len();
    let influences = open.influences(&fit)?;
    Ok(Replaced {
        effect: info.id.to_owned(),
        stability: ParameterStability::of(open, &fit.hypothesis, kept.len(), &intervals[first..]),
        stability_test: StabilityTest::of(open, &fit, &influences, first..intervals.len()),
    })
}

/// Whether a fitted law has a higher posterior probability on the open rows than the causes that it would replace, by at least
/// [`Ground::margin`].
pub(super) fn is_more_probable(
    ground: &Ground<'_>,
    open: &Problem<'_, Dyn<'_>>,
    law: &Tried,
    fit: &Fit,
) -> Result<bool, DiagnoseError> {
    if ground.rivals.is_empty() {
        return Ok(true);
    }
    let rivals = Hypothesis { members: ground.rivals.clone(), ..open.base() };
    let rivals = open.fit(rivals, ground.settings.search.iterations)?;
    // A listed cause costs the logarithm of the number of candidates in the diagnosis, a law its description length.
    let members = |f: &Fit| 2.0 * f.hypothesis.members.len() as f64;
    let here = (open.system.candidate_len().max(1) as f64).ln();
    let of_law = total(open, fit) - members(fit) * here + 2.0 * law.length;
    let choices = (ground.choices.max(1) as f64).ln();
    let of_rivals = total(open, &rivals) + members(&rivals) * (choices - here);
    Ok(of_law + ground.margin < of_rivals)
}

/// A law that is fitted to all open rows.
pub(super) struct FittedLaw<'l> {
    law: &'l Tried,
    definition: &'l Definition,
    pub(super) fit: Fit,
    /// Errors on the test set with the named causes, and with the law.
    error_reduction: ErrorReduction,
    /// Values of its parameters.
    pub(super) values: Vec<f64>,
    /// Its terms with them.
    pub(super) terms: Vec<Term>,
}

impl<'l> FittedLaw<'l> {
    pub(super) fn new(
        law: &'l Tried,
        definition: &'l Definition,
        fit: Fit,
        error_reduction: ErrorReduction,
    ) -> Self {
        let values = fit.hypothesis.members.last().map(|m| m.values.clone()).unwrap_or_default();
        let terms = definition.with_values(&law.terms, &values);
        Self { law, definition, fit, error_reduction, values, terms }
    }

    /// The causes that were named and do not stand beside it.
    fn replaces(
        &self,
        space: &dyn TermSpace,
        ground: &Ground<'_>,
        open: &Problem<'_, Dyn<'_>>,
    ) -> Vec<Replaced> {
        let kept = &self.fit.hypothesis.members[..self.law.named.len()];
        let mut gone: Vec<&Member> = Vec::new();
        for m in ground.named.iter().chain(&ground.rivals) {
            let id = |m: &Member| open.system.candidate(m.candidate).id.to_owned();
            let known = kept.iter().chain(gone.iter().copied()).any(|other| id(other) == id(m));
            if !known {
                gone.push(m);
            }
        }
        let mut all: Vec<Replaced> =
            gone.into_iter().filter_map(|m| replaced(ground, open, kept, m).ok()).collect();
        for between in all.iter_mut().filter_map(|r| r.stability_test.between.as_mut()) {
            if between.grows_with.is_none() {
                between.grows_with = self.goes_with(space, open, &between.values);
            }
        }
        all
    }

    /// The slow variable of the law with which values of the recordings go, and whether they grow with it.
    fn goes_with(
        &self,
        space: &dyn TermSpace,
        open: &Problem<'_, Dyn<'_>>,
        values: &[(String, f64)],
    ) -> Option<(String, bool)> {
        let slow = self.terms.iter().flat_map(Term::variables).find(|&k| {
            let kind = space.variables()[k].kind;
            !matches!(kind, VariableKind::Moving | VariableKind::Turning)
        })?;
        let mean_of = |name: &str| {
            let own = open.experiments.iter().find(|&&e| open.system.name(e) == name)?;
            Some(mean(&space.series(*own)[slow]))
        };
        let means: Vec<f64> =
            values.iter().map(|(name, _)| mean_of(name)).collect::<Option<_>>()?;
        let values: Vec<f64> = values.iter().map(|v| v.1).collect();
        let r = correlation(&means, &values);
        (r.abs() > CLEAR_CORRELATION).then(|| (space.variables()[slow].name.clone(), r > 0.0))
    }

    /// The law as it is reported, and its definition.
    pub(super) fn result(
        &self,
        space: &dyn TermSpace,
        ground: &Ground<'_>,
        open: &Problem<'_, Dyn<'_>>,
        last: &Final<'_>,
        similarity: f64,
    ) -> Result<(Law, Definition), DiagnoseError> {
        let own = open.intervals(&self.fit)?;
        let first = own.len() - self.values.len();
        let names = self.definition.parameters.iter().map(|p| p.name.clone());
        let parameters: Vec<_> = names.zip(own[first..].iter().copied()).collect();
        let error_reduction = self.error_reduction.clone();
        let share_of_correction = last.share_of_correction(&self.fit, |f| last.chi_square(f));
        let expression = self.definition.expression();
        let definition = self
            .definition
            .clone()
            .describe(&format!("law found in recordings: {expression}"))
            .starting_at(&self.values);
        let header = header(&parameters, share_of_correction, &error_reduction);
        let beside =
            self.law.named.iter().map(|m| open.system.candidate(m.candidate).id.to_owned());
        let law = Law {
            variables: variable_names(&self.terms, space),
            remembers: self.terms.iter().any(Term::remembers),
            listed: self
                .terms
                .iter()
                .map(|t| space.listed(t))
                .collect::<Option<Vec<_>>>()
                .unwrap_or_default(),
            beside: beside.collect(),
            replaces: self.replaces(space, ground, open),
            bands: last.test.bands(open, &self.fit.hypothesis),
            file: header + &space.file(std::slice::from_ref(&definition)),
            expression,
            parameters,
            share_of_correction,
            similarity,
            error_reduction,
        };
        Ok((law, definition))
    }
}
