//! Laws through the simulation.

use crate::error::DiagnoseError;
use crate::fit::{Fit, Hypothesis, Member, Problem};
use crate::remainder::{Dyn, Ground};
use crate::search::Scored;
use crate::terms::{Definition, Factor, Function, Term, TermParameter, TermSpace};
use pam_core::parallel;

/// Terms to be fitted, beside some of the named causes.
#[derive(Debug, Clone)]
pub(crate) struct Proposal {
    pub(crate) terms: Vec<Term>,
    pub(crate) named: Vec<Member>,
}

/// A law that was fitted to the training rows.
#[derive(Debug, Clone)]
pub(crate) struct Tried {
    /// Its terms with fitted numbers.
    pub(crate) terms: Vec<Term>,
    /// Named causes beside it, with their values.
    pub(crate) named: Vec<Member>,
    /// Values of the parameters of its definition.
    pub(crate) values: Vec<f64>,
    /// Minus two times the logarithm of its posterior probability, up to a constant.
    pub(crate) total: f64,
    /// Length of its description, nats.
    pub(crate) length: f64,
    /// Mean whitened squares of the channels on training and validation rows.
    pub(crate) chi: Vec<f64>,
    /// Normalised χ² of the validation rows.
    pub(crate) validation: f64,
    /// Share of the squared error of training and validation rows beside the named causes that it removes.
    removed: f64,
    /// Prior cost of the nuisances.
    prior_cost: f64,
}

impl Tried {
    /// Whether it has some of another law's terms, and all others of that one carry next to nothing of what it removes.
    fn does_without(&self, longer: &Self, least: f64) -> bool {
        let is_held = |t: &Term| longer.terms.iter().any(|u| u.is_like(t));
        // A sine and a cosine of one period are one wave.
        let factors = || longer.terms.iter().flat_map(|t| &t.factors);
        let is_wave =
            |t: &Term| t.factors.iter().any(|f| factors().any(|g| g.is_other_phase_of(f)));
        longer.terms.iter().all(|t| self.terms.iter().any(|u| u.is_like(t)) || !is_wave(t))
            && self.terms.len() < longer.terms.len()
            && self.named.len() == longer.named.len()
            && self.terms.iter().all(is_held)
            && longer.removed - self.removed < least * longer.removed
    }
}

/// The laws of a search.
#[derive(Debug, Default)]
pub(super) struct Searched {
    /// Proposals that were fitted to the end.
    pub(super) known: Vec<Proposal>,
    /// Fitted laws, best first.
    pub(super) tried: Vec<Tried>,
}

/// Iterations of the nuisances alone.
const NUISANCE_ITERATIONS: usize = 3;

impl Tried {
    /// Whether another law is the same but for numbers. Laws stand beside all named causes or beside none.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        self.named.len() == other.named.len()
            && self.terms.len() == other.terms.len()
            && self.terms.iter().zip(&other.terms).all(|(a, b)| a.is_like(b))
    }

    /// The law, as a candidate of a problem, fitted to its rows: first the nuisances, which would otherwise move the law away from the
    /// values that it has, then everything.
    pub(super) fn fitted_to(
        &self,
        problem: &Problem<'_, Dyn<'_>>,
        candidate: usize,
        iterations: usize,
    ) -> Result<Fit, DiagnoseError> {
        let base = Hypothesis { members: self.named.clone(), ..problem.base() };
        let mut start = base.with(candidate, &self.values);
        start.fixed = start.members.len();
        let nuisances = problem.fit(start, NUISANCE_ITERATIONS)?.hypothesis;
        problem.fit(Hypothesis { fixed: 0, ..nuisances }, iterations)
    }
}

/// Ratio of two scales or times below which two proposals are one.
const SAME_SCALE: f64 = 2.0;
/// Laws that are followed after the first iteration, and how many more they get at once; the last of them get the rest.
const FOLLOWED: [[usize; 2]; 2] = [[28, 1], [14, 3]];
/// Multiples of the coefficients of the screening from which a fit may start; it starts from the first one whose cost is below that
/// without the law, because the linearised estimate can be several times too large.
const START_SHARES: [f64; 3] = [1.0, 0.5, 0.2];
/// Laws that are fitted to the end.
const FITTED: usize = 6;
/// Laws of one term that are always kept, with the named causes and without them: while their time constant is far off, longer sums
/// that imitate them fit better.
const SHORT: usize = 3;

impl Proposal {
    /// Whether another one is the same but for numbers that a fit would make the same.
    fn is_like(&self, other: &Self) -> bool {
        let near = |a: f64, b: f64| a.max(b) < SAME_SCALE * a.min(b);
        let same = |f: &Factor, g: &Factor| {
            f.is_like(g)
                && (!f.function.has_scale() || near(f.scale, g.scale))
                && f.lag.zip(g.lag).is_none_or(|(l, m)| near(l.number(), m.number()))
        };
        let term = |t: &Term, u: &Term| {
            t.is_like(u) && t.factors.iter().all(|f| u.factors.iter().any(|g| same(f, g)))
        };
        let holds = |a: &Self, b: &Self| a.terms.iter().all(|t| b.terms.iter().any(|u| term(t, u)));
        self.named.len() == other.named.len()
            && self.terms.len() == other.terms.len()
            && holds(self, other)
            && holds(other, self)
    }
}

/// Proposals from sets of terms: each without the named causes and with them.
pub(super) fn proposals(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    sets: &[Vec<Term>],
    known: &[Proposal],
) -> Vec<Proposal> {
    let both = |terms: &Vec<Term>| {
        let is_short = terms.len() < ground.settings.remainder.terms;
        let with = (!ground.named.is_empty() && is_short).then(|| ground.named.clone());
        [Vec::new()].into_iter().chain(with).map(|named| (terms.clone(), named)).collect::<Vec<_>>()
    };
    with_dry_variants(space, sets.iter().flat_map(both), known)
}

/// Proposals of terms beside causes, and the same with dry friction in place of its smooth picture. Those that are like known ones
/// are left out.
pub(super) fn with_dry_variants(
    space: &dyn TermSpace,
    sets: impl IntoIterator<Item = (Vec<Term>, Vec<Member>)>,
    known: &[Proposal],
) -> Vec<Proposal> {
    let mut all: Vec<Proposal> = Vec::new();
    let family = |t: &Term| space.places()[t.place].family;
    for (terms, named) in sets {
        let dry: Vec<Term> = terms.iter().map(|t| dry_variant(space, t)).collect();
        let is_dry = dry != terms;
        for terms in [terms].into_iter().chain(is_dry.then_some(dry)) {
            // An effect with memory acts in one way.
            let is_one = terms.windows(2).all(|t| family(&t[0]) == family(&t[1]));
            let proposal = Proposal { terms, named: named.clone() };
            let is_known = known.iter().chain(&all).any(|p| p.is_like(&proposal));
            if (is_one || !proposal.terms.iter().any(Term::remembers)) && !is_known {
                all.push(proposal);
            }
        }
    }
    all
}

/// The term as a level of dry friction, if it is the smooth picture of one.
pub(crate) fn dry_variant(space: &dyn TermSpace, term: &Term) -> Term {
    let Some((dry, velocity)) = space.places()[term.place].dry else { return term.clone() };
    let turned =
        |f: &Factor| f.function == Function::Saturated && f.variable == velocity && f.lag.is_none();
    let Some(at) = term.factors.iter().position(turned) else { return term.clone() };
    let mut level = Term { place: dry, coefficient: -term.coefficient, ..term.clone() };
    level.factors.remove(at);
    level
}

/// Whether a term is equivalent to one of these listed causes, either itself or the dry friction that it approximates.
pub(super) fn says_one_of(space: &dyn TermSpace, term: &Term, named: &[&str]) -> bool {
    let ids = [space.listed(term), space.listed(&dry_variant(space, term))];
    ids.into_iter().flatten().any(|id| named.contains(&id))
}

/// Of the best laws without the named causes, what they say beside these: a law that holds one of them is a shorter one beside it.
pub(super) fn beside_named(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    searched: &Searched,
) -> Result<Vec<Proposal>, DiagnoseError> {
    space.with(&[], |system| {
        let id = |m: &Member| system.candidate(m.candidate).id;
        let named: Vec<&str> = ground.named.iter().map(id).collect();
        let mut all: Vec<Proposal> = Vec::new();
        for law in searched.tried.iter().filter(|t| t.named.is_empty()).take(FITTED) {
            let says = |t: &&Term| says_one_of(space, t, &named);
            let terms: Vec<Term> = law.terms.iter().filter(|t| !says(t)).cloned().collect();
            let proposal = Proposal { terms, named: ground.named.clone() };
            let is_known = searched.known.iter().chain(&all).any(|p| p.is_like(&proposal));
            if (1..law.terms.len()).contains(&proposal.terms.len()) && !is_known {
                all.push(proposal);
            }
        }
        Ok(all)
    })
}

/// Fits proposals to the training rows and scores them on training and validation rows. After a few iterations only the most
/// promising ones go on; the others may be proposed again, from a better start.
pub(super) fn refine(
    space: &dyn TermSpace,
    ground: &Ground<'_>,
    proposals: Vec<Proposal>,
    rows_per_observation: f64,
    searched: &mut Searched,
) -> Result<(), DiagnoseError> {
    let (variables, places) = (space.variables(), space.places());
    let define = |(k, p): (usize, &Proposal)| {
        Definition::law(&format!("law{}", k + 1), "", &p.terms, variables, places)
    };
    let definitions: Vec<Definition> = proposals.iter().enumerate().map(define).collect();
    let length_of = |p: &Proposal| {
        let terms = p.terms.iter().map(|t| t.description_length(variables, places));
        terms.sum::<f64>() + p.named.len() as f64 * (ground.choices.max(1) as f64).ln()
    };
    let iterations = ground.settings.remainder.law_iterations;
    space.with(&definitions, |system| {
        let Some(mut rows) = ground.rows(system, &ground.start(system)) else {
            return Ok(());
        };
        rows.set_rows_per_observation(rows_per_observation);
        let train = &rows.choosing.train;
        let base = |named: &[Member]| Hypothesis { members: named.to_vec(), ..train.base() };
        let cost = |h: &Hypothesis| Some(train.cost(h, &train.errors(h).ok()?));
        // Proposals stand beside all named causes or beside none.
        let [beside_none, beside_all] = [&[][..], &ground.named].map(|named| cost(&base(named)));
        let start = |k: usize| {
            let named = &proposals[k].named;
            let without = if named.is_empty() { beside_none? } else { beside_all? };
            let base = base(named);
            let at = |share: f64| {
                let value = |p: &TermParameter| match p.absent {
                    Some(absent) => absent + share * (p.start - absent),
                    None => p.start,
                };
                let values: Vec<f64> = definitions[k].parameters.iter().map(value).collect();
                base.with(ground.listed + k, &values)
            };
            let helps = |h: &Hypothesis| cost(h).is_some_and(|cost| cost < without);
            let starts = || START_SHARES.into_iter().map(at);
            let start = starts().find(helps).or_else(|| starts().next_back())?;
            train.fit(start, 1).ok().map(|fit| (k, fit))
        };
        let mut going: Vec<(usize, Fit)> =
            parallel::map(proposals.len(), start).into_iter().flatten().collect();
        let mut done: Vec<(usize, Fit)> = Vec::new();
        let prospect = |(k, fit): &(usize, Fit)| fit.may_reach() + 2.0 * length_of(&proposals[*k]);
        let known: usize = 1 + FOLLOWED.iter().map(|f| f[1]).sum::<usize>();
        let last = [FITTED, iterations.saturating_sub(known)];
        for [followed, more] in FOLLOWED.into_iter().chain([last]) {
            going.sort_by(|a, b| prospect(a).total_cmp(&prospect(b)));
            let rest = going.split_off(followed.min(going.len()));
            for left in rest {
                let of = |k: usize| (proposals[k].named.len(), proposals[k].terms.len());
                let alike = going.iter().filter(|(k, _)| of(*k) == of(left.0)).count();
                let is_short = proposals[left.0].terms.len() == 1;
                if is_short && alike < SHORT { &mut going } else { &mut done }.push(left);
            }
            going = parallel::map_each(going, |(k, fit)| {
                let further = train.fit_further(fit.clone(), more);
                (k, further.unwrap_or(fit))
            });
        }
        searched.known.extend(going.iter().map(|(k, _)| proposals[*k].clone()));
        done.extend(going);
        let named = Hypothesis { members: ground.named.clone(), ..train.base() };
        let named = train.fit(named, ground.settings.remainder.iterations)?;
        let without = rows.choosing.validation_errors(&named.hypothesis)?.and(&named.errors);
        let without = without.chi_square();
        let tried = parallel::map_each(done, |(k, fit)| {
            let scored: Scored = rows.scored(fit)?;
            let mut named = scored.hypothesis().members.clone();
            let values = named.pop()?.values;
            let terms = definitions[k].with_values(&proposals[k].terms, &values);
            let length = length_of(&proposals[k]);
            let choice =
                2.0 * scored.members() as f64 * (system.candidate_len().max(1) as f64).ln();
            let errors = scored.fit.errors.and(&scored.validation);
            Some(Tried {
                removed: 1.0 - errors.chi_square() / without,
                total: scored.total(rows_per_observation) - choice + 2.0 * length,
                prior_cost: train.prior_cost(scored.hypothesis()),
                chi: errors.mean(),
                validation: scored.validation.chi_square(),
                terms,
                named,
                values,
                length,
            })
        });
        searched.tried.extend(tried.into_iter().flatten());
        searched.tried.sort_by(|a, b| a.total.total_cmp(&b.total));
        Ok(())
    })
}

/// Of laws that leave nearly as little in every channel as the one of the best odds, without moving the nuisances further, those
/// with the fewest numbers; laws without a term that carries next to nothing are as good. A factor more takes no number: what their
/// variables and functions are, the odds decide, and where these are even, the shorter description.
pub(crate) fn preferred(tried: &[Tried], ground: &Ground<'_>) -> Option<Tried> {
    let best = tried.first()?;
    let settings = ground.settings;
    let as_good = |t: &&Tried| {
        let mut channels = t.chi.iter().zip(&best.chi);
        let rise = settings.remainder.notable_rise;
        let leaves_as_little = channels.all(|(own, least)| own - least < rise * least.max(1.0))
            && t.prior_cost - best.prior_cost < settings.intervals.equal_cost;
        leaves_as_little || t.does_without(best, settings.remainder.term_share)
    };
    let numbers =
        |t: &Tried| t.values.len() + t.named.iter().map(|m| m.values.len()).sum::<usize>();
    let good: Vec<&Tried> = tried.iter().filter(as_good).collect();
    let fewest = good.iter().map(|t| numbers(t)).min()?;
    let good = || good.iter().filter(|t| numbers(t) == fewest);
    let least = good().map(|t| t.total).min_by(f64::total_cmp)?;
    let even = 2.0 * settings.verdict.confusable_odds.ln();
    let shortest = good()
        .filter(|t| t.total < least + even)
        .min_by(|a, b| a.length.total_cmp(&b.length).then(a.total.total_cmp(&b.total)));
    shortest.map(|t| (*t).clone())
}
