//! The steps from the error that remains after the named causes to a correction and a law.

use super::conclude::{concluded, ended};
use super::data::Data;
use super::design::Design;
use super::library::{extensions, library};
use super::refine::{Searched, Tried, beside_named, preferred, proposals, refine};
use super::result::{Replaced, TAKEN};
use super::screen::{Screened, blocks, columns, sums};
use super::vary::vary;
use crate::diagnosis::{Diagnosis, Explainable};
use crate::error::DiagnoseError;
use crate::fit::{Hypothesis, Member};
use crate::noise::Noise;
use crate::remainder::{
    Ground, Learned, Remainder, RemainderOutcome, learn, most_left, validation_errors,
};
use crate::terms::{Definition, Term, TermSpace};
use crate::test_set::{ErrorReduction, Trace};
use crate::verdict::{Anomaly, Cause, ChannelBand, Refused, Verdict};

/// What is left, and what the system gets to explain it.
pub(crate) struct Rest {
    pub(crate) remainder: Remainder,
    /// What is added to the system, with values; nothing without a confirmed correction.
    pub(crate) added: Vec<(Definition, Vec<f64>)>,
    /// Named causes that stay, with their values beside it.
    pub(crate) named: Vec<Member>,
    /// Nuisances that all experiments share.
    pub(crate) shared: Vec<f64>,
    /// Errors of the extended system, if anything is added.
    pub(crate) renewed: Option<Renewed>,
}

/// The parts of a diagnosis that the extended system changes.
pub(crate) struct Renewed {
    pub(crate) error_reduction: ErrorReduction,
    pub(crate) bands: Vec<ChannelBand>,
    pub(crate) anomalies: Vec<Anomaly>,
    pub(crate) traces: Vec<Trace>,
    pub(crate) explainable: Explainable,
}

impl Rest {
    /// Puts what was learned into a diagnosis. Causes in whose place a law stands are no longer named, and errors and bands are
    /// those of the extended system.
    pub(crate) fn put_into<M>(self, found: &mut Diagnosis<M>) {
        if let Some(renewed) = self.renewed {
            let stays = |place: usize| self.named.iter().any(|m| m.candidate == place);
            let (causes, mut gone) = divided(std::mem::take(&mut found.causes), 0, &stays);
            let first = causes.len() + gone.len();
            let (minor, more) = divided(std::mem::take(&mut found.minor), first, &stays);
            gone.extend(more);
            (found.causes, found.minor) = (causes, minor);
            for c in gone.into_iter().rev() {
                let replaced = self.remainder.law.iter().flat_map(|l| &l.replaces);
                let reason = replaced.into_iter().find(|r| r.effect == c.effect);
                let reason = reason.map_or_else(|| TAKEN.to_owned(), Replaced::reason);
                if found.refused.first().is_none_or(|r| r.effect != c.effect) {
                    let (effect, inclusion) = (c.effect, c.inclusion);
                    found.refused.insert(0, Refused { effect, inclusion, reason });
                }
            }
            found.verdict = match found.verdict {
                Verdict::ModelInadequate => Verdict::ModelInadequate,
                _ if found.causes.is_empty() => Verdict::Unexplained,
                Verdict::Explained => Verdict::PartlyExplained,
                other => other,
            };
            let what = match &self.remainder.law {
                Some(law) => law.subject(),
                None => "an unlisted smooth correction".to_owned(),
            };
            found.reasons =
                vec![format!("{what} removes a further part of the error of the test set")];
            let outside = renewed.bands.iter().filter(|b| b.outside).map(|b| {
                let output = found.outputs.iter().find(|o| o.key == b.channel);
                format!(
                    "an error remains in the {}: {:.2} times its noise (at most {:.2} by chance)",
                    output.map_or(&b.channel, |o| &o.name),
                    b.ratio,
                    b.upper
                )
            });
            let causes = found.causes.iter().map(|c| c.stability_test.sentence(&c.effect));
            let more = outside.chain(renewed.anomalies.iter().map(|a| a.description.clone()));
            found.reasons.extend(more.chain(causes).filter(|r| !r.is_empty()));
            (found.late_fault, found.untested_change) = (None, None);
            let Renewed { error_reduction, bands, anomalies, traces, explainable } = renewed;
            found.error_reduction = error_reduction;
            found.explainable = explainable;
            (found.bands, found.anomalies, found.traces) = (bands, anomalies, traces);
        }
        found.remainder = Some(self.remainder);
    }
}

/// Causes that stay and those that go; the members of the search are numbered in the order of the causes.
fn divided(
    causes: Vec<Cause>,
    first: usize,
    stays: &dyn Fn(usize) -> bool,
) -> (Vec<Cause>, Vec<Cause>) {
    let (own, gone): (Vec<_>, Vec<_>) =
        causes.into_iter().enumerate().partition(|(k, _)| stays(first + k));
    let plain = |all: Vec<(usize, Cause)>| all.into_iter().map(|(_, c)| c).collect();
    (plain(own), plain(gone))
}

/// Sentence of the report for a correction that predicts worse than the causes it would replace.
const NO_BETTER: &str = "No smooth correction leaves as little of the validation data as the causes that a law would replace.";

/// Sentence of the report for a correction that the test set refuses.
pub(super) const UNCONFIRMED: &str =
    "The test set does not confirm the smooth correction that the validation data allow.";

/// Sentence of the report if the search for causes has used up the budget.
const NOT_BEGUN: &str = "No smooth correction was fitted.";

/// Sentence that is added if the budget ends the search before it finds a law.
const SPENT: &str =
    " The search ended early, after the work that the setting remainder.most_simulations allows.";

/// What is said where nothing is left.
pub(crate) const NOTHING_LEFT: &str =
    "The training and validation data hold nothing beside the named causes that could be learned.";

/// Drop of minus two times the logarithm of the posterior probability that makes another round worth it.
pub(super) const WORTH: f64 = 6.0;

pub(super) fn diverges() -> DiagnoseError {
    DiagnoseError::TooLittle("the correction diverges on the recordings".into())
}

/// Fits the error that remains after the named causes and searches for a law. If there is none, a law may stand for causes that come
/// and go or change their values, and then for all of them. It takes their place if it is more probable on the open rows, by
/// clear odds if it takes that of causes which hold. One recording, whose end is all that confirms either, is not asked twice.
pub(crate) fn rest(
    data: &Data<'_>,
    verdict: Verdict,
    done: &(dyn Fn(f64) + Sync),
) -> Result<Rest, DiagnoseError> {
    let ((_, ground), (_, chosen)) = (data.whole, data.chosen);
    let one_recording = ground.roles.is_one_recording();
    let some_change = ground.settled.len() < ground.named.len();
    let mut others = Vec::new();
    if some_change && verdict != Verdict::Explained && !one_recording {
        others.push([ground, chosen].map(Ground::beside_settled));
    }
    if ground.replaceable && others.iter().all(|[whole, _]| !whole.named.is_empty()) {
        others.push([ground, chosen].map(Ground::beside_none));
    }
    let is_law = |found: &Rest| found.remainder.outcome == RemainderOutcome::Law;
    let count = 1.0 + others.len() as f64;
    let attempt = |k: usize, data: &Data<'_>| {
        rest_beside(data, verdict, &|share| done((k as f64 + share) / count))
    };
    let mut found = attempt(0, data)?;
    if is_law(&found) {
        return Ok(found);
    }
    if ground.budget.is_spent() && found.remainder.outcome != RemainderOutcome::NothingLeft {
        found.remainder.sentence += SPENT;
        return Ok(found);
    }
    for (k, [whole, chosen]) in others.iter().enumerate() {
        let fewer = Data { whole: (data.whole.0, whole), chosen: (data.chosen.0, chosen), ..*data };
        let other = attempt(k + 1, &fewer)?;
        if is_law(&other) {
            return Ok(other);
        }
    }
    Ok(found)
}

fn rest_beside(
    data: &Data<'_>,
    verdict: Verdict,
    done: &(dyn Fn(f64) + Sync),
) -> Result<Rest, DiagnoseError> {
    let none = |outcome, sentence: &str| Rest {
        remainder: Remainder::none(outcome, sentence),
        added: Vec::new(),
        named: data.whole.1.named.clone(),
        shared: Vec::new(),
        renewed: None,
    };
    let (space, ground) = data.chosen;
    if !is_left(space, ground, verdict)? {
        let (whole, of_whole) = data.whole;
        if data.is_whole || !data.is_short || !is_left(whole, of_whole, verdict)? {
            return Ok(none(RemainderOutcome::NothingLeft, NOTHING_LEFT));
        }
        return rest_beside(&Data::whole(whole, of_whole), verdict, done);
    }
    if ground.budget.is_spent() {
        return Ok(none(RemainderOutcome::NotLearned, NOT_BEGUN));
    }
    let Some(learned) = learn(space, ground, &|share| done(0.3 * share))? else {
        let sentence = "No smooth correction removes a part of the error of the validation data that chance does not.";
        return Ok(none(RemainderOutcome::NotLearned, sentence));
    };
    // In other recordings, a smooth correction may go astray where the law that it stands for does not.
    let one_recording = data.whole.1.roles.is_one_recording();
    if one_recording && !reaches_rivals(space, ground, &learned)? {
        return Ok(none(RemainderOutcome::NotLearned, NO_BETTER));
    }
    done(0.4);
    let (whole, of_whole) = data.whole;
    let in_whole = learned.in_whole(data);
    // The rest of the same recording is asked whether it confirms the correction, as it was learned and as it is with all rows,
    // before a law is searched for in its place.
    if one_recording && !confirmed_as_learned(whole, of_whole, &in_whole)? {
        return Ok(none(RemainderOutcome::NotLearned, UNCONFIRMED));
    }
    let about_whole = About::of(whole, of_whole, &in_whole)?;
    let of_whole = Ground { noise: about_whole.noise.clone(), ..of_whole.clone() };
    if one_recording {
        let found = ended(whole, &of_whole, &in_whole, &about_whole, &[], None)?;
        if found.remainder.outcome != RemainderOutcome::Correction || of_whole.budget.is_spent() {
            return Ok(found);
        }
    }
    let of_chosen;
    let about = if data.is_whole {
        &about_whole
    } else {
        of_chosen = About::of(space, ground, &learned)?;
        &of_chosen
    };
    let ground = Ground { noise: about.noise.clone(), ..ground.clone() };
    let screen = Screen::of(space, &ground, &learned, about)?;
    done(0.5);
    let mut tried = search(space, &ground, (about, &screen), &|share| done(0.5 + 0.4 * share))?;
    // Laws that were selected on pieces are judged on all recordings.
    tried.iter_mut().for_each(|t| t.named = data.in_whole(&t.named));
    let data = Data { whole: (whole, &of_whole), chosen: (space, &ground), ..*data };
    let found = concluded(&data, &in_whole, &about_whole, &tried)?;
    done(1.0);
    Ok(found)
}

/// Whether the correction predicts the validation rows about as well as the causes that a law would replace. If it does not, no
/// short law will: a law rarely predicts much better than a smooth correction.
fn reaches_rivals(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    learned: &Learned,
) -> Result<bool, DiagnoseError> {
    if ground.rivals.is_empty() {
        return Ok(true);
    }
    let rivals = Ground { named: ground.rivals.clone(), ..ground.clone() };
    let Some(errors) = validation_errors(space, &rivals)? else { return Ok(true) };
    Ok(learned.deviance - errors.deviance() < ground.settings.remainder.much_worse)
}

/// Whether the correction, with its learned coefficients, significantly reduces the error on the test set.
fn confirmed_as_learned(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    learned: &Learned,
) -> Result<bool, DiagnoseError> {
    space.with(&learned.definitions(space), |system| {
        let test = ground.roles.test(system, &ground.noise, ground.settings);
        // The comparison fits the nuisances of both to the test rows.
        let with =
            |members: &[Member]| Hypothesis { members: members.to_vec(), ..test.problem().base() };
        let [before, after] =
            [&ground.named, &learned.hypothesis.members].map(|members| with(members));
        let compared = test.compared(&before, &after);
        let clear = ground.settings.remainder.clear_evidence;
        Ok(compared.is_some_and(|c| c.reduced || c.evidence > clear))
    })
}

/// Whether some channel of the validation or training rows has more than the first estimate of its noise.
fn is_left(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    verdict: Verdict,
) -> Result<bool, DiagnoseError> {
    let most = most_left(verdict, &ground.settings.remainder).powi(2);
    space.with(&[], |system| {
        let Some(rows) = ground.rows(system, &ground.start(system)) else { return Ok(true) };
        let base = Hypothesis { members: ground.named.clone(), ..rows.whole.base() };
        let fit = rows.whole.fit(base, ground.settings.remainder.iterations)?;
        Ok(fit.errors.mean().iter().any(|m| *m > most))
    })
}

/// The correction on all open rows.
pub(super) struct About {
    /// The noise beside the correction.
    pub(super) noise: Noise,
    pub(super) rows_per_observation: f64,
    /// Mean whitened squares of the open rows.
    chi: Vec<f64>,
    /// Named causes and coefficients.
    pub(super) fit: Hypothesis,
    /// Rows that were one observation when they were fitted.
    fitted_with: f64,
}

impl About {
    pub(super) fn of(
        space: &dyn TermSpace,
        ground: &Ground<'_>,
        learned: &Learned,
    ) -> Result<Self, DiagnoseError> {
        space.with(&learned.definitions(space), |system| {
            let mut rows = ground.rows(system, &learned.hypothesis).ok_or_else(diverges)?;
            let fit = rows.whole.fit(rows.whole.with_base_locals(&learned.hypothesis), 2)?;
            let noise =
                Noise::learned(&rows.whole, &fit.hypothesis, &ground.prior).ok_or_else(diverges)?;
            rows.set_noise(&noise, &fit.hypothesis).ok_or_else(diverges)?;
            let fit = rows.whole.fit(fit.hypothesis, ground.settings.remainder.iterations)?;
            Ok(Self {
                noise,
                rows_per_observation: rows.whole.correlated_rows(&fit.hypothesis)?,
                chi: fit.errors.mean(),
                fit: fit.hypothesis,
                fitted_with: rows.whole.rows_per_observation,
            })
        })
    }
}

/// Linearised fit of the library's terms to the residual of the correction.
struct Screen {
    library: Vec<Term>,
    /// The sensitivities to the terms of the library, and the residual.
    screened: Screened,
    /// Sums of terms that reproduce most of the effect of the correction.
    sums: Vec<Vec<Term>>,
}

impl Screen {
    /// `ground` has the noise beside the correction.
    fn of(
        space: &dyn TermSpace,
        ground: &Ground<'_>,
        learned: &Learned,
        about: &About,
    ) -> Result<Self, DiagnoseError> {
        let families = learned.families(space.places());
        let mut library = library(&families, space.variables(), space.places());
        library.extend(learned.waves(space));
        let mut definitions = learned.definitions(space);
        let first = ground.listed + definitions.len();
        definitions.extend(blocks(space, &library));
        space.with(&definitions, |system| {
            let mut rows = ground.rows(system, &about.fit).ok_or_else(diverges)?;
            rows.set_rows_per_observation(about.fitted_with);
            let problem = &rows.whole;
            let design = Design::at(problem, &about.fit)?;
            let columns = columns((problem, &about.fit), &design, &library, first);
            let rpo = about.rows_per_observation;
            let sums = sums(space, ground, &design, &library, &columns, rpo);
            Ok(Self { library, screened: Screened { target: design.target, columns }, sums })
        })
    }
}

/// Laws from the screening about the correction, and about the best law so far.
fn search(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    (about, screen): (&About, &Screen),
    done: &(dyn Fn(f64) + Sync),
) -> Result<Vec<Tried>, DiagnoseError> {
    let settings = &ground.settings.remainder;
    let rpo = about.rows_per_observation;
    let mut searched = Searched::default();
    refine(space, ground, proposals(space, ground, &screen.sums, &[]), rpo, &mut searched)?;
    if !ground.budget.is_spent() {
        vary(space, ground, about, &mut searched)?;
    }
    let beside = beside_named(space, ground, &searched)?;
    refine(space, ground, beside, rpo, &mut searched)?;
    for round in 0..settings.rounds {
        if ground.budget.is_spent() {
            break;
        }
        done(round as f64 / settings.rounds as f64);
        let Some(best) = preferred(&searched.tried, ground) else { break };
        let as_good =
            |(own, least): (&f64, &f64)| *own < least.max(1.0) * (1.0 + settings.notable_rise);
        if best.chi.iter().zip(&about.chi).all(as_good) {
            break;
        }
        let total = |s: &Searched| s.tried.first().map_or(f64::INFINITY, |t| t.total);
        let before = total(&searched);
        let sums = again(space, ground, &best, (about, screen))?;
        let more = proposals(space, ground, &sums, &searched.known);
        refine(space, ground, more, rpo, &mut searched)?;
        if total(&searched) > before - WORTH {
            break;
        }
    }
    Ok(searched.tried)
}

/// Sums of terms about a law, with products of its terms.
fn again(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    law: &Tried,
    (about, screen): (&About, &Screen),
) -> Result<Vec<Vec<Term>>, DiagnoseError> {
    let (variables, places) = (space.variables(), space.places());
    let mut terms = screen.screened.beside(&law.terms, &screen.library);
    terms.extend(extensions(&law.terms, variables, places));
    let mut definitions = vec![Definition::law("law", "", &law.terms, variables, places)];
    definitions.extend(blocks(space, &terms));
    space.with(&definitions, |system| {
        let start = Hypothesis { members: law.named.clone(), ..ground.start(system) };
        let Some(mut rows) = ground.rows(system, &start) else { return Ok(Vec::new()) };
        rows.set_rows_per_observation(about.rows_per_observation);
        let iterations = ground.settings.remainder.iterations;
        let Ok(fit) = law.fitted_to(&rows.whole, ground.listed, iterations) else {
            return Ok(Vec::new());
        };
        let h = &fit.hypothesis;
        let design = Design::at(&rows.whole, h)?;
        let columns = columns((&rows.whole, h), &design, &terms, ground.listed + 1);
        Ok(sums(space, ground, &design, &terms, &columns, about.rows_per_observation))
    })
}
