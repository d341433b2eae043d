//! The steps from what the named causes leave to a correction and a law.

use super::design::Design;
use super::library::{extensions, library};
use super::picture::Along;
use super::refine::{Proposal, Tried, preferred, proposals, refine};
use super::result::{Law, RankedLaw};
use super::select::Scores;
use crate::error::DiagnoseError;
use crate::fit::{Fit, Hypothesis, Member, Problem};
use crate::noise::Noise;
use crate::remainder::{
    Correction, Dyn, Ground, Learned, Remainder, RemainderOutcome, dependence, learn, learn_again,
};
use crate::terms::{Definition, Factor, Term, TermSpace};
use crate::verdict::Verdict;
use pam_core::units::significant;

/// What is left, and what the system gets to explain it.
pub(crate) struct Rest {
    pub(crate) remainder: Remainder,
    /// What is added to the system, with values; nothing without a confirmed correction.
    pub(crate) added: Vec<(Definition, Vec<f64>)>,
    /// Named causes that stay, with their values beside it.
    pub(crate) named: Vec<Member>,
    /// Nuisances that all experiments share.
    pub(crate) shared: Vec<f64>,
}

impl Rest {
    /// The verdict with what was learned, and the sentence for its reasons; `None` if nothing became part of the model.
    pub(crate) fn verdict(&self, before: Verdict) -> Option<(Verdict, String)> {
        let after = match before {
            Verdict::Explained => Verdict::PartlyExplained,
            Verdict::NothingFound => Verdict::Unexplained,
            other => other,
        };
        (!self.added.is_empty()).then(|| (after, self.reason()))
    }

    /// The sentence for the reasons of a verdict.
    fn reason(&self) -> String {
        let what = match self.remainder.outcome {
            RemainderOutcome::Law => "a law",
            _ => "a smooth correction",
        };
        format!("{what} that is in no list removes a further part of the error of the test set")
    }
}

/// Terms of one block of the library: as many as one simulation differentiates by.
const BLOCK: usize = 8;
/// Laws of the ranking that are reported.
const RANKED: usize = 12;
/// Drop of minus two times the logarithm of the posterior probability that makes another round worth it.
const WORTH: f64 = 6.0;

fn diverges() -> DiagnoseError {
    DiagnoseError::TooLittle("the correction diverges on the recordings".into())
}

/// Learns what the named causes leave and looks for a law in it.
pub(crate) fn rest(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    verdict: Verdict,
    done: &(dyn Fn(f64) + Sync),
) -> Result<Rest, DiagnoseError> {
    let none = |outcome, sentence: &str| Rest {
        remainder: Remainder::none(outcome, sentence),
        added: Vec::new(),
        named: ground.named.clone(),
        shared: Vec::new(),
    };
    if !is_left(space, ground, verdict)? {
        let sentence = "The training and validation data hold nothing beside the named causes that could be learned.";
        return Ok(none(RemainderOutcome::NothingLeft, sentence));
    }
    let Some(learned) = learn(space, ground, &|share| done(0.3 * share))? else {
        let sentence = "No smooth correction removes a part of the error of the validation data that chance does not.";
        return Ok(none(RemainderOutcome::NotLearned, sentence));
    };
    let about = About::of(space, ground, &learned)?;
    done(0.5);
    let ground = Ground { noise: about.noise.clone(), ..ground.clone() };
    let tried = search(space, &ground, &about, &|share| done(0.5 + 0.4 * share))?;
    let law = preferred(&tried, &ground);
    let found = concluded(space, &ground, &learned, &about, &tried, law)?;
    done(1.0);
    Ok(found)
}

/// Whether some channel of the validation or training rows has more than the first estimate of its noise.
fn is_left(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    verdict: Verdict,
) -> Result<bool, DiagnoseError> {
    let settings = &ground.settings.remainder;
    let most = match verdict {
        Verdict::Explained | Verdict::NothingFound => settings.doubt_ratio.powi(2),
        _ => settings.nothing_ratio.powi(2),
    };
    space.with(&[], |system| {
        let Some(rows) = ground.rows(system, &ground.start(system)) else { return Ok(true) };
        let base = Hypothesis { members: ground.named.clone(), ..rows.whole.base() };
        let fit = rows.whole.fit(base, ground.settings.remainder.iterations)?;
        Ok(fit.errors.mean().iter().any(|m| *m > most))
    })
}

/// The correction on all open rows, and what the terms of the library do about it.
struct About {
    /// The noise beside the correction.
    noise: Noise,
    rows_per_observation: f64,
    /// Mean whitened squares of the open rows.
    chi: Vec<f64>,
    /// Named causes and coefficients.
    fit: Hypothesis,
    depends_on: Vec<crate::remainder::Dependence>,
    library: Vec<Term>,
    /// Sums of terms that do nearly what the correction does.
    sums: Vec<Vec<Term>>,
}

impl About {
    fn of(
        space: &dyn TermSpace,
        ground: &Ground<'_>,
        learned: &Learned,
    ) -> Result<Self, DiagnoseError> {
        let settings = &ground.settings.remainder;
        let library = library(&learned.families(space.places()), space.variables(), space.places());
        let mut definitions = learned.definitions(space);
        let first = ground.listed + definitions.len();
        definitions.extend(blocks(space, &library));
        space.with(&definitions, |system| {
            let mut rows = ground.rows(system, &learned.hypothesis).ok_or_else(diverges)?;
            let start =
                Hypothesis { locals: rows.whole.base().locals, ..learned.hypothesis.clone() };
            let fit = rows.whole.fit(start, 2)?;
            let noise =
                Noise::learned(&rows.whole, &fit.hypothesis, &ground.prior).ok_or_else(diverges)?;
            rows.set_noise(&noise, &fit.hypothesis).ok_or_else(diverges)?;
            let fit = rows.whole.fit(fit.hypothesis, settings.iterations)?;
            let rows_per_observation = rows.whole.correlated_rows(&fit.hypothesis)?;
            let problem = &rows.whole;
            let design = Design::at(problem, &fit.hypothesis)?;
            let terms: Vec<&Term> = learned.terms.iter().flatten().collect();
            let fixed = design.own.len() - terms.len();
            let depends_on = dependence(
                &design,
                &design.blocks(|i| problem.rows_per_short_block(i)),
                fixed,
                &terms,
                learned.deviation,
                space.variables(),
                settings.folds,
            );
            let h = &fit.hypothesis;
            let sums =
                sums(space, ground, (problem, h), &design, &library, first, rows_per_observation);
            let chi = fit.errors.mean();
            let fit = fit.hypothesis;
            Ok(Self { noise, rows_per_observation, chi, fit, depends_on, library, sums })
        })
    }
}

/// The library as definitions, a few terms in each.
fn blocks(space: &dyn TermSpace, terms: &[Term]) -> Vec<Definition> {
    let (variables, places) = (space.variables(), space.places());
    let of = |(k, block): (usize, &[Term])| {
        Definition::flexible(&format!("block{k}"), block, f64::INFINITY, variables, places)
    };
    terms.chunks(BLOCK).enumerate().map(of).collect()
}

/// The best sums of terms of each length about a hypothesis, with coefficients.
fn sums(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    (problem, hypothesis): (&Problem<'_, Dyn<'_>>, &Hypothesis),
    design: &Design,
    terms: &[Term],
    first: usize,
    rows_per_observation: f64,
) -> Vec<Vec<Term>> {
    let settings = &ground.settings.remainder;
    let candidates: Vec<(usize, Vec<f64>)> = terms
        .chunks(BLOCK)
        .enumerate()
        .map(|(k, block)| (first + k, vec![0.0; block.len()]))
        .collect();
    let found = design.columns(problem, hypothesis, &candidates);
    let empty = |block: &[Term]| vec![vec![0.0; design.target.len()]; block.len()];
    let columns: Vec<Vec<f64>> = found
        .into_iter()
        .zip(terms.chunks(BLOCK))
        .flat_map(|(own, block)| own.unwrap_or_else(|| empty(block)))
        .collect();
    let price = |t: &Term| 2.0 * t.description_length(space.variables(), space.places());
    let prices: Vec<f64> = terms.iter().map(price).collect();
    let least = vec![1.0; design.channels()];
    let all = Scores { design, rows_per_observation, least }.beam(
        &columns,
        &prices,
        settings.terms,
        settings.beam,
    );
    let mut chosen = Vec::new();
    for length in 1..=settings.terms {
        let own = all.iter().filter(|s| s.columns.len() == length).take(settings.refined);
        chosen.extend(own.map(|s| {
            let with = |(k, c): (&usize, &f64)| {
                let term = &terms[*k];
                Term { coefficient: c * term.coefficient, ..term.clone() }
            };
            s.columns.iter().zip(&s.coefficients).map(with).collect::<Vec<Term>>()
        }));
    }
    chosen
}

/// Laws from the screening about the correction, and about the best law so far.
fn search(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    about: &About,
    done: &(dyn Fn(f64) + Sync),
) -> Result<Vec<Tried>, DiagnoseError> {
    let settings = &ground.settings.remainder;
    let rpo = about.rows_per_observation;
    let mut known = proposals(space, ground, &about.sums, &[]);
    let mut tried = refine(space, ground, &known, rpo)?;
    for round in 0..settings.rounds {
        done(round as f64 / settings.rounds as f64);
        let Some(best) = preferred(&tried, ground) else { break };
        let as_good =
            |(own, least): (&f64, &f64)| *own < least.max(1.0) * (1.0 + settings.notable_rise);
        if best.chi.iter().zip(&about.chi).all(as_good) {
            break;
        }
        let before = tried.first().map_or(f64::INFINITY, |t| t.total);
        let sums = again(space, ground, &best, about)?;
        let more: Vec<Proposal> = proposals(space, ground, &sums, &known);
        tried.extend(refine(space, ground, &more, rpo)?);
        tried.sort_by(|a, b| a.total.total_cmp(&b.total));
        known.extend(more);
        if tried.first().is_none_or(|t| t.total > before - WORTH) {
            break;
        }
    }
    Ok(tried)
}

/// Sums of terms about a law, with products of its terms.
fn again(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    law: &Tried,
    about: &About,
) -> Result<Vec<Vec<Term>>, DiagnoseError> {
    let (variables, places) = (space.variables(), space.places());
    let mut terms = about.library.clone();
    terms.extend(extensions(&law.terms, variables, places));
    let mut definitions = vec![Definition::law("law", "", &law.terms, variables, places)];
    definitions.extend(blocks(space, &terms));
    space.with(&definitions, |system| {
        let start = Hypothesis { members: law.named.clone(), ..ground.start(system) };
        let mut rows = ground.rows(system, &start).ok_or_else(diverges)?;
        rows.set_rows_per_observation(about.rows_per_observation);
        let start = Hypothesis { members: law.named.clone(), ..rows.whole.base() };
        let start = start.with(ground.listed, &law.values);
        let fit = rows.whole.fit(start, ground.settings.remainder.iterations)?;
        let h = &fit.hypothesis;
        let design = Design::at(&rows.whole, h)?;
        let (problem, rpo) = ((&rows.whole, h), about.rows_per_observation);
        Ok(sums(space, ground, problem, &design, &terms, ground.listed + 1, rpo))
    })
}

/// The fits of named causes, correction and law to all open rows, beside the test set.
fn concluded(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    learned: &Learned,
    about: &About,
    tried: &[Tried],
    law: Option<Tried>,
) -> Result<Rest, DiagnoseError> {
    let (variables, places) = (space.variables(), space.places());
    let settings = ground.settings;
    // What a law stands for that replaces named causes: the correction with them.
    let whole = match &law {
        Some(l) if l.named.len() < ground.named.len() => {
            let ground = Ground { named: l.named.clone(), ..ground.clone() };
            learn_again(space, &ground, learned)?
        }
        _ => None,
    };
    let corrections = learned.definitions(space);
    let mut definitions = corrections.clone();
    let of_law =
        law.as_ref().map(|l| Definition::law("found_law", "", &l.terms, variables, places));
    definitions.extend(of_law.clone());
    space.with(&definitions, |system| {
        let mut rows = ground.rows(system, &about.fit).ok_or_else(diverges)?;
        rows.set_rows_per_observation(about.rows_per_observation);
        let open = &rows.whole;
        let iterations = settings.search.iterations;
        let named = Hypothesis { members: ground.named.clone(), ..open.base() };
        let base = open.fit(named, iterations)?;
        let locals = open.base().locals;
        let start = Hypothesis { locals: locals.clone(), ..about.fit.clone() };
        let corrected = open.fit(start, settings.remainder.iterations)?;
        let test = ground.roles.test(system, &ground.noise, settings).opened(&base.hypothesis)?;
        let has_test = !test.problem().is_empty();
        let share = |of: &Fit| {
            let (from, to, best) = if has_test {
                let chi = |f: &Fit| test.chi_square(&f.hypothesis);
                (chi(&base), chi(of), chi(&corrected))
            } else {
                let chi = |f: &Fit| f.errors.chi_square();
                (chi(&base), chi(of), chi(&corrected))
            };
            (from - to) / (from - best).max(f64::MIN_POSITIVE)
        };
        let gain = |to: &Fit| test.error_reduction(&base.hypothesis, &to.hypothesis, ground.seed);
        let is_confirmed = |to: &Fit| {
            !has_test
                || (test.is_reduced(&base.hypothesis, &to.hypothesis)
                    && gain(to).overall.ci95[0] > 0.0)
        };
        let fitted = match &law {
            Some(l) => {
                let members = Hypothesis { members: l.named.clone(), ..open.base() };
                let start = members.with(ground.listed + corrections.len(), &l.values);
                Some((l, open.fit(start, iterations)?))
            }
            None => None,
        };
        // Of what the correction removes from the open rows; the test set decides nothing but whether it is confirmed.
        let of_open = |to: &Fit| {
            let (from, best) = (base.errors.chi_square(), corrected.errors.chi_square());
            (from - to.errors.chi_square()) / (from - best).max(f64::MIN_POSITIVE)
        };
        let stands = |(_, fit): &(&Tried, Fit)| {
            of_open(fit) > settings.remainder.law_share && is_confirmed(fit)
        };
        let fitted = fitted.filter(stands);
        let confirmed = is_confirmed(&corrected);
        let terms = learned.fitted(&corrected.hypothesis);
        let law_terms = fitted.as_ref().zip(of_law.as_ref()).map(|((l, fit), definition)| {
            let values = fit.hypothesis.members.last().map_or(&[][..], |m| &m.values);
            definition.with_values(&l.terms, values)
        });
        // With the law, what it stands for.
        let stood_for = whole.as_ref().filter(|_| law_terms.is_some());
        let shown = stood_for.map_or_else(|| terms.clone(), |w| w.fitted(&w.hypothesis));
        let along = Along::of(space, &open.experiments, &shown, law_terms.as_deref());
        let pictures = along.as_ref().map_or_else(Vec::new, |a| {
            a.pictures(variables, &places[a.place], &about.depends_on, law_terms.as_deref())
        });
        let values_of = |h: &Hypothesis, count: usize| -> Vec<Vec<f64>> {
            h.members[h.members.len() - count..].iter().map(|m| m.values.clone()).collect()
        };
        let coefficients = values_of(&corrected.hypothesis, corrections.len());
        let held: Vec<Definition> =
            corrections.iter().zip(&coefficients).map(|(d, v)| d.starting_at(v)).collect();
        let correction = Correction {
            acts: acts(&terms, space),
            terms: largest(&terms, space),
            prior_deviation: learned.deviation,
            depends_on: about.depends_on.clone(),
            validation_share: learned.drop.share,
            p_value: learned.drop.p_value,
            error_reduction: gain(&corrected),
            confirmed,
            pictures,
            file: space.file(&held),
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
            shared: base.hypothesis.shared.clone(),
        };
        let similarity = along.as_ref().and_then(Along::similarity).unwrap_or(0.0);
        if let (Some((l, fit)), Some(definition), Some(terms)) = (fitted, of_law, law_terms) {
            let h = &fit.hypothesis;
            let values = h.members.last().map(|m| m.values.clone()).unwrap_or_default();
            let own = open.intervals(&fit)?;
            let first = own.len() - values.len();
            let names = definition.parameters.iter().map(|p| p.name.clone());
            let parameters: Vec<_> = names.zip(own[first..].iter().copied()).collect();
            let beside: Vec<String> =
                l.named.iter().map(|m| system.candidate(m.candidate).id.to_owned()).collect();
            let error_reduction = gain(&fit);
            let share_of_correction = share(&fit);
            let expression = definition.expression();
            let described = definition
                .describe(&format!("law found in recordings: {expression}"))
                .starting_at(&values);
            let header = header(&parameters, share_of_correction, &error_reduction);
            found.remainder.sentence = format!(
                "A law stands for it: {expression}, which carries {:.0} % of what a smooth correction removes.",
                100.0 * share_of_correction
            );
            found.remainder.outcome = RemainderOutcome::Law;
            found.remainder.law = Some(Law {
                expression,
                variables: variable_names(&terms, space),
                remembers: terms.iter().any(Term::remembers),
                parameters,
                beside,
                share_of_correction,
                similarity,
                bands: test.bands(open, h),
                error_reduction,
                file: header + &space.file(std::slice::from_ref(&described)),
            });
            found.named = h.members[..h.members.len() - 1].to_vec();
            found.shared = h.shared.clone();
            found.added = vec![(described, values)];
        } else if confirmed {
            found.remainder.outcome = RemainderOutcome::Correction;
            found.remainder.sentence = format!(
                "A smooth correction removes {:.0} % of the error of the test set, and no short law does: there is none of up to \
                 {} terms of the library that carries {:.0} % of it.",
                100.0 * correction.error_reduction.overall.error_reduction,
                settings.remainder.terms,
                100.0 * settings.remainder.law_share
            );
            let members = &corrected.hypothesis.members;
            found.named = members[..members.len() - corrections.len()].to_vec();
            found.shared = corrected.hypothesis.shared.clone();
            found.added = held.into_iter().zip(coefficients).collect();
        } else {
            found.remainder.sentence =
                "The test set does not confirm the smooth correction that the validation data allow."
                    .to_owned();
        }
        found.remainder.correction = Some(correction);
        Ok(found)
    })
}

/// Comments of a law's file: intervals and what it gains.
fn header(
    parameters: &[(String, crate::fit::Interval)],
    share: f64,
    gain: &crate::test_set::ErrorReduction,
) -> String {
    let n = |v: f64| significant(v, 4);
    let mut out = format!(
        "# It removes {:.0} % of the error of the test set [{:.0}, {:.0}], {:.0} % of what a smooth correction removes.\n",
        100.0 * gain.overall.error_reduction,
        100.0 * gain.overall.ci95[0],
        100.0 * gain.overall.ci95[1],
        100.0 * share
    );
    for (name, i) in parameters {
        let [low, high] = i.ci95;
        out += &format!("# {name} = {} [{}, {}]\n", n(i.value), n(low), n(high));
    }
    out
}

fn acts(terms: &[Term], space: &dyn TermSpace) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for t in terms {
        let name = &space.places()[t.place].name;
        if !all.contains(name) {
            all.push(name.clone());
        }
    }
    all
}

/// The terms with the largest coefficients.
fn largest(terms: &[Term], space: &dyn TermSpace) -> Vec<(String, f64)> {
    let (variables, places) = (space.variables(), space.places());
    let mut all: Vec<(String, f64)> = terms
        .iter()
        .map(|t| {
            let place = &places[t.place];
            let size = t.coefficient * t.size(variables) / place.size;
            (format!("{}: {}", place.id, product(t, space)), size)
        })
        .collect();
    all.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    all
}

/// The factors of a term as an expression.
fn product(term: &Term, space: &dyn TermSpace) -> String {
    let variables = space.variables();
    let of = |f: &Factor| {
        let text = &variables[f.variable].text;
        let argument = match f.lag {
            None => text.clone(),
            Some(lag) => {
                format!("low_pass({}, {} s)", lag.of.text(text, ""), significant(lag.time_s, 3))
            }
        };
        f.function.text(&argument, &significant(f.scale, 3))
    };
    let parts: Vec<String> = term.factors.iter().map(of).collect();
    if parts.is_empty() { "1".to_owned() } else { parts.join(" * ") }
}

/// A law with its numbers.
fn written(terms: &[Term], space: &dyn TermSpace) -> String {
    let one = |t: &Term| {
        let (c, product) = (significant(t.coefficient, 4), product(t, space));
        format!("{}: {c} * {product}", space.places()[t.place].id)
    };
    terms.iter().map(one).collect::<Vec<_>>().join("; ")
}

fn variable_names(terms: &[Term], space: &dyn TermSpace) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    for k in terms.iter().flat_map(Term::variables) {
        for name in &space.variables()[k].names {
            if !all.contains(name) {
                all.push(name.clone());
            }
        }
    }
    all
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
