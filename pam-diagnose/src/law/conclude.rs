//! The fits to all open rows, and what the test set says of them.

use super::data::Data;
use super::design::Design;
use super::find::{About, Renewed, Rest, UNCONFIRMED, diverges};
use super::fitted::{FittedLaw, is_more_probable};
use super::picture::Along;
use super::prune::pruned;
use super::refine::{Tried, preferred, says_one_of};
use super::result::RankedLaw;
use super::written::{acts, largest, written};
use crate::diagnosis::{Explainable, total};
use crate::error::DiagnoseError;
use crate::fit::{Fit, Hypothesis, Member, Problem};
use crate::remainder::{
    Correction, Dyn, Ground, Learned, Remainder, RemainderOutcome, dependence, learn_again,
};
use crate::terms::{Definition, Term, TermSpace};
use crate::test_set::{ErrorReduction, TestSet};
use crate::verdict::share;

/// Laws of the ranking that are reported.
const RANKED: usize = 12;

/// The fits that are compared on the test set, which is open now.
pub(super) struct Final<'s> {
    pub(super) test: TestSet<'s, Dyn<'s>>,
    /// The system without any cause.
    plain: Fit,
    /// The named causes.
    base: Fit,
    /// The named causes with the correction.
    corrected: Fit,
    /// Of [`RemainderSettings`](crate::settings::RemainderSettings).
    clear_evidence: f64,
    seed: u64,
}

impl Final<'_> {
    fn has_test(&self) -> bool {
        !self.test.problem().is_empty()
    }

    /// Normalised χ² of the test set, or of the open rows without one.
    pub(super) fn chi_square(&self, fit: &Fit) -> f64 {
        if self.has_test() {
            self.test.chi_square(&fit.hypothesis)
        } else {
            fit.errors.chi_square()
        }
    }

    /// Errors with the named causes, and with a fit.
    fn error_reduction(&self, to: &Fit) -> ErrorReduction {
        self.test.error_reduction(&self.base.hypothesis, &to.hypothesis, self.seed)
    }

    /// Whether the test set proves that the error is smaller than with the named causes; `reduction` is that of the fit.
    fn is_confirmed(&self, to: &Fit, reduction: &ErrorReduction) -> bool {
        !self.has_test()
            || self
                .test
                .compared(&self.base.hypothesis, &to.hypothesis)
                .is_some_and(|c| c.confirms_learned(&reduction.overall, self.clear_evidence))
    }

    /// The drop of a χ² by a fit relative to that by the correction; 1 where the correction does not lower it.
    pub(super) fn share_of_correction(&self, to: &Fit, chi_square: impl Fn(&Fit) -> f64) -> f64 {
        let (from, best) = (chi_square(&self.base), chi_square(&self.corrected));
        if best < from { (from - chi_square(to)) / (from - best) } else { 1.0 }
    }

    /// The result of the extended system in place of that of the named causes.
    fn renewed(&self, open: &Problem<'_, Dyn<'_>>, to: &Fit) -> Renewed {
        let (system, h) = (open.system, &to.hypothesis);
        // What all recordings share, such as the timing of the force, is the same before and after.
        let start = Hypothesis { shared: h.shared.clone(), ..self.plain.hypothesis.clone() }
            .without_locals(system, open.len());
        let (before, after) = (self.chi_square(&self.plain), self.chi_square(to));
        let removed = share(before, after, after.min(1.0));
        let (bands, anomalies) = self.test.bands_and_anomalies(open, h);
        Renewed {
            error_reduction: self.test.error_reduction(&start, h, self.seed),
            bands,
            anomalies,
            traces: self.test.traces(&start, h),
            explainable: Explainable { any_correction: removed, named: removed },
        }
    }
}

/// The fits of named causes, correction and law to all open rows, beside the test set. A law without some of the named causes
/// is compared with a correction that stands without them as well.
pub(super) fn concluded(
    data: &Data<'_>,
    learned: &Learned,
    about: &About,
    tried: &[Tried],
) -> Result<Rest, DiagnoseError> {
    let (space, ground) = data.whole;
    let law = allowed(space, ground, tried)?;
    let law = law.map(|law| pruned(space, ground, about, law));
    let Some(l) = law.as_ref().filter(|l| l.named.len() < ground.named.len()) else {
        return ended(space, ground, learned, about, tried, law.as_ref());
    };
    let of_whole = ground.beside(l.named.clone());
    let chosen = data.chosen.1.beside(data.in_chosen(&l.named));
    let less = Data { whole: (space, &of_whole), chosen: (data.chosen.0, &chosen), ..*data };
    if let Some(correction) = learn_again(less.chosen.0, &chosen, learned)? {
        let correction = correction.in_whole(&less);
        let about = About::of(space, &of_whole, &correction)?;
        let found = ended(space, &of_whole, &correction, &about, tried, Some(l))?;
        if found.remainder.outcome == RemainderOutcome::Law {
            return Ok(found);
        }
    }
    ended(space, ground, learned, about, tried, None)
}

/// The preferred one of the laws that may take the place of the named causes which do not stand beside them. A longer law that
/// holds one of those, or its smooth picture, is no better name for it, unless the rest of it beside the named causes is clearly
/// less probable; a law all of whose terms are named already is none.
fn allowed(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    tried: &[Tried],
) -> Result<Option<Tried>, DiagnoseError> {
    space.with(&[], |system| {
        let id = |m: &Member| system.candidate(m.candidate).id;
        let beside: Vec<&str> = ground.named.iter().map(id).collect();
        let rivals: Vec<&str> = ground.rivals.iter().map(id).collect();
        let named = [beside.clone(), rivals.clone()].concat();
        let even = 2.0 * ground.settings.verdict.confusable_odds.ln();
        let rest_does = |law: &Tried| {
            let says = |t: &&Term| says_one_of(space, t, &beside);
            let rest: Vec<&Term> = law.terms.iter().filter(|t| !says(t)).collect();
            let is_rest = |t: &&Tried| {
                t.named.len() == ground.named.len()
                    && t.terms.len() == rest.len()
                    && t.terms.iter().all(|t| rest.iter().any(|r| r.is_like(t)))
            };
            tried.iter().find(is_rest).is_some_and(|t| t.total < law.total + even)
        };
        let may = |law: &&Tried| {
            let gone = named.len().saturating_sub(law.named.len());
            let says = |names: &[&str]| law.terms.iter().any(|t| says_one_of(space, t, names));
            gone == 0
                || law.terms.len() <= gone
                || !(says(&rivals) || (says(&beside) && rest_does(law)))
        };
        let left: Vec<Tried> = tried.iter().filter(may).cloned().collect();
        let restates = |law: &Tried| {
            let listed = |t: &Term| space.listed(t).is_some_and(|id| named.contains(&id));
            law.terms.iter().all(listed)
        };
        Ok(preferred(&left, ground).filter(|law| !restates(law)))
    })
}

/// The fits of named causes, correction and perhaps a law to all open rows, beside the test set.
pub(super) fn ended(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    learned: &Learned,
    about: &About,
    tried: &[Tried],
    law: Option<&Tried>,
) -> Result<Rest, DiagnoseError> {
    let (variables, places) = (space.variables(), space.places());
    let settings = ground.settings;
    let corrections = learned.definitions(space);
    let of_law = law.map(|l| Definition::law("found_law", "", &l.terms, variables, places));
    let definitions: Vec<Definition> = corrections.iter().chain(&of_law).cloned().collect();
    space.with(&definitions, |system| {
        let mut rows = ground.rows(system, &about.fit).ok_or_else(diverges)?;
        rows.set_rows_per_observation(about.rows_per_observation);
        let open = &rows.whole;
        let iterations = settings.search.iterations;
        let named = Hypothesis { members: ground.named.clone(), ..open.base() };
        let base = open.fit(named, iterations)?;
        let plain = if ground.named.is_empty() {
            base.clone()
        } else {
            open.fit(open.base(), iterations)?
        };
        let corrected = open.fit(about.fit.clone(), settings.remainder.iterations)?;
        let test = ground.roles.test(system, &ground.noise, settings).opened(&base.hypothesis)?;
        let clear_evidence = settings.remainder.clear_evidence;
        let last = Final { test, plain, base, corrected, clear_evidence, seed: ground.seed };
        // A law that diverges on the open rows is none.
        let at = ground.listed + corrections.len();
        let fit = law.and_then(|l| l.fitted_to(open, at, iterations).ok());
        let fitted = match law.zip(of_law.as_ref()).zip(fit) {
            Some(((l, definition), fit)) => {
                // A law replaces the correction if it achieves most of the correction's error reduction on the open rows, or if its
                // posterior probability is at least that of the correction, which has more parameters. The test set only confirms it.
                let of_open = last.share_of_correction(&fit, |f| f.errors.chi_square());
                let as_probable =
                    total(open, &fit) + 2.0 * l.length <= total(open, &last.corrected);
                let stands = (of_open > settings.remainder.law_share || as_probable)
                    && is_more_probable(ground, open, l, &fit)?;
                let reduction = stands.then(|| last.error_reduction(&fit));
                reduction
                    .filter(|reduction| last.is_confirmed(&fit, reduction))
                    .map(|reduction| FittedLaw::new(l, definition, fit, reduction))
            }
            None => None,
        };
        let design = Design::at(open, &about.fit)?;
        let learned_terms: Vec<&Term> = learned.terms.iter().flatten().collect();
        let depends_on = dependence(
            &design,
            &design.blocks(|i| open.rows_per_short_block(i)),
            design.own.len() - learned_terms.len(),
            &learned_terms,
            learned.deviation,
            variables,
            settings.remainder.folds,
        );
        let terms = learned.fitted(&last.corrected.hypothesis);
        let law_terms = fitted.as_ref().map(|l| l.terms.as_slice());
        let along = Along::of(space, &open.experiments, &terms, law_terms);
        let pictures = along.as_ref().map_or_else(Vec::new, |a| {
            a.pictures(variables, &places[a.place], &depends_on, law_terms)
        });
        let members = &last.corrected.hypothesis.members;
        let (named, coefficients) = members.split_at(members.len() - corrections.len());
        let held: Vec<(Definition, Vec<f64>)> = corrections
            .iter()
            .zip(coefficients)
            .map(|(d, m)| (d.starting_at(&m.values), m.values.clone()))
            .collect();
        let definitions: Vec<Definition> = held.iter().map(|(d, _)| d.clone()).collect();
        let reduction = last.error_reduction(&last.corrected);
        let correction = Correction {
            acts: acts(&terms, space),
            terms: largest(&terms, space),
            prior_deviation: learned.deviation,
            depends_on,
            validation_share: learned.drop.share,
            p_value: learned.drop.p_value,
            confirmed: last.is_confirmed(&last.corrected, &reduction),
            error_reduction: reduction,
            pictures,
            file: space.file(&definitions),
        };
        let mut found = Rest {
            remainder: Remainder {
                outcome: RemainderOutcome::NotLearned,
                sentence: String::new(),
                correction: None,
                law: None,
                ranking: ranking(tried, space, ground, system),
            },
            added: Vec::new(),
            named: ground.named.clone(),
            shared: last.base.hypothesis.shared.clone(),
            renewed: None,
        };
        if let Some(law) = fitted {
            let similarity = along.as_ref().and_then(Along::similarity).unwrap_or(0.0);
            let (result, definition) = law.result(space, ground, open, &last, similarity)?;
            let h = &law.fit.hypothesis;
            found.remainder.sentence = if correction.confirmed {
                format!(
                    "The law {} accounts for {:.0} % of the squared error that a smooth correction removes.",
                    result.expression,
                    100.0 * result.share_of_correction
                )
            } else {
                format!(
                    "The law {} removes {:.0} % of the error of the test set, which the smooth correction does not.",
                    result.expression,
                    100.0 * result.error_reduction.overall.error_reduction
                )
            };
            found.remainder.outcome = RemainderOutcome::Law;
            found.remainder.law = Some(result);
            found.named = h.members[..h.members.len() - 1].to_vec();
            found.shared.clone_from(&h.shared);
            found.added = vec![(definition, law.values.clone())];
            found.renewed = Some(last.renewed(open, &law.fit));
        } else if correction.confirmed {
            found.remainder.outcome = RemainderOutcome::Correction;
            found.remainder.sentence = format!(
                "A smooth correction removes {:.0} % of the error of the test set, and no short law does: there is none of up to \
                 {} terms of the library that carries {:.0} % of it.",
                100.0 * correction.error_reduction.overall.error_reduction,
                settings.remainder.terms,
                100.0 * settings.remainder.law_share
            );
            found.named = named.to_vec();
            found.shared.clone_from(&last.corrected.hypothesis.shared);
            found.added = held;
            found.renewed = Some(last.renewed(open, &last.corrected));
        } else {
            found.remainder.sentence = UNCONFIRMED.to_owned();
        }
        found.remainder.correction = Some(correction);
        Ok(found)
    })
}

fn ranking(
    tried: &[Tried],
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    system: &Dyn<'_>,
) -> Vec<RankedLaw> {
    let best = tried.first().map_or(0.0, |t| t.total);
    let mut all: Vec<&Tried> = tried.iter().take(RANKED).collect();
    // The one that is preferred stands among them.
    if let Some(p) = preferred(tried, ground)
        && let Some(own) = tried.iter().find(|t| t.total == p.total)
        && !all.iter().any(|t| t.total == own.total)
    {
        all.push(own);
    }
    all.into_iter()
        .map(|t| RankedLaw {
            expression: written(&t.terms, space),
            beside: t.named.iter().map(|m| system.candidate(m.candidate).id.to_owned()).collect(),
            description_length: t.length,
            parameters: t.values.len(),
            validation: t.validation,
            log_odds: 0.5 * (best - t.total),
        })
        .collect()
}
