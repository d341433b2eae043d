//! From the screening to the chosen set.

use super::candidates::Candidates;
use super::refit::in_other_shapes;
use super::rows::Rows;
use super::scored::Scored;
use crate::fit::Hypothesis;
use crate::linearised::{Imitators, Products, Subset, all_starts};
use crate::rejection::NullTest;
use pam_core::parallel;

/// Result of a search.
#[derive(Debug, Clone)]
pub struct Findings {
    /// The system without candidates.
    pub base: Scored,
    /// Every candidate with the share of the whitened squared residual that it would explain alone, to first order; best
    /// first.
    pub screened: Vec<(usize, f64)>,
    /// The best starting values of each candidate, to first order.
    pub starts: Vec<(usize, Vec<f64>)>,
    /// The most promising candidates alone, fitted, best first.
    pub singles: Vec<Scored>,
    /// The chosen set; the base if nothing earned its place.
    pub best: Scored,
    /// The sets in the neighbourhood of the chosen one that were fitted: with a member more, less, or exchanged.
    pub others: Vec<Scored>,
    /// The chosen set without each of its members.
    pub without: Vec<Option<Scored>>,
    /// How much candidates explain by chance; absent if there is nothing to simulate.
    pub null_test: Option<NullTest>,
}

/// Logarithm of the odds below which two sets are the same answer.
pub(crate) const TIE: f64 = 1.0;

/// Searches for the set of at most `most` candidates that explains best what the base leaves; `None` if the base cannot be
/// simulated. `done` is called with the finished share of the work.
///
/// Where no candidate explains more than chance ([`NullTest`]), nothing is fitted or chosen.
pub fn search<C: Candidates + ?Sized>(
    rows: &mut Rows<'_, C>,
    most: usize,
    seed: u64,
    done: &(dyn Fn(f64) + Sync),
) -> Option<Findings> {
    let settings = rows.whole.settings.search;
    let iterations = settings.iterations;
    let whole = rows.learn_beside(&rows.whole.base())?;
    let all = all_starts(rows.whole.system);
    let linearised = Products::at(&rows.whole, &whole.hypothesis, &all)?.beside();
    let starts = linearised.best_starts(settings.starts);
    let imitators = linearised.imitators(settings.imitated_share, settings.imitators);
    let (null_test, base) = parallel::join(
        || NullTest::of(&linearised, &rows.whole.settings.rejection, seed),
        || rows.fitted(rows.choosing.train.base(), iterations),
    );
    let base = base?;
    done(0.1);
    let first_order = linearised.singles();
    let pairs = if most > 1 { linearised.pairs() } else { Vec::new() };
    let share = |drop: f64| (drop / linearised.residual.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    let screened = first_order.iter().map(|s| (s.starts[0].candidate, share(s.drop))).collect();
    let none = Findings {
        screened,
        starts: starts.clone(),
        singles: Vec::new(),
        best: base.clone(),
        others: Vec::new(),
        without: Vec::new(),
        null_test,
        base,
    };
    let level = 1.0 - rows.whole.settings.rejection.null_quantile;
    // A cause may be hidden by nuisances that went far from their priors, which no block of rows shows.
    let strained = rows.whole.prior_strain(&whole.hypothesis) > 1.0;
    let by_chance = !strained && none.null_test.as_ref().is_some_and(|t| t.p_value > level);
    let promising =
        first_order.iter().chain(&pairs).any(|s| rows.is_promising(s, linearised.residual));
    if most == 0 || by_chance || !promising {
        done(1.0);
        return Some(none);
    }
    let from = none.base.hypothesis();
    let singles = rows.fit_subsets(
        from,
        &first_order.iter().take(settings.singles).collect::<Vec<_>>(),
        None,
    );
    done(0.3);
    let mut sets = singles.clone();
    let pairs: Vec<_> = pairs.iter().take(settings.pairs).collect();
    sets.extend(rows.fit_subsets(from, &pairs, singles.first()));
    sets.push(none.base.clone());
    // Beside the best set so far the noise is learned anew; only then the odds decide.
    let mut best = rows.best_of(&sets)?.clone();
    done(0.5);
    let mut found = Findings { singles, ..none };
    for round in 0..settings.rounds {
        if best.members() == 0 {
            break;
        }
        // A set beside which the noise cannot be learned, or with which a fit diverges, is the best that can be had.
        let tried = (starts.as_slice(), &imitators);
        let Some(next) = improved(rows, &mut found, &mut best, &mut sets, tried, most) else {
            break;
        };
        done(0.5 + 0.5 * (round + 1) as f64 / settings.rounds as f64);
        let same = next.hypothesis().set() == best.hypothesis().set();
        best = next;
        if same {
            break;
        }
        found.without = Vec::new();
    }
    done(1.0);
    found.best = best;
    found.others = sets;
    Some(found)
}

/// The set that is preferred in the neighbourhood of the best one, all of them fitted with the noise beside it; `None` if one
/// of these steps diverges.
fn improved<C: Candidates + ?Sized>(
    rows: &mut Rows<'_, C>,
    found: &mut Findings,
    best: &mut Scored,
    sets: &mut Vec<Scored>,
    tried: (&[(usize, Vec<f64>)], &Imitators),
    most: usize,
) -> Option<Scored> {
    let settings = rows.whole.settings.search;
    rows.learn_beside(best.hypothesis())?;
    let again = |s: &Scored| rows.fitted(s.hypothesis().clone(), settings.iterations);
    let (base, fitted) = parallel::join(|| again(&found.base), || again(best));
    found.base = base?;
    // Values that are no longer what the names say are no better than none.
    *best = fitted.unwrap_or_else(|| found.base.clone());
    let rivals = sets.iter().filter(|s| s.members() > 0).take(settings.rivals);
    let rivals = rivals.map(|s| s.hypothesis().clone()).collect();
    *sets = rows.fit_all(rivals, Some(best));
    let near = neighbours(rows, best, &found.base, tried, most)?;
    found.without = near.without;
    sets.extend(near.sets);
    sets.extend([best.clone(), found.base.clone()]);
    *sets = distinct(rows, std::mem::take(sets));
    rows.preferred(sets)
}

/// The best of each set of candidates, best first.
fn distinct<C: Candidates + ?Sized>(rows: &Rows<'_, C>, mut sets: Vec<Scored>) -> Vec<Scored> {
    let per_observation = rows.whole.rows_per_observation;
    sets.sort_by(|a, b| a.total(per_observation).total_cmp(&b.total(per_observation)));
    let mut known = std::collections::HashSet::new();
    sets.retain(|s| known.insert(s.hypothesis().set()));
    sets
}

/// Sets that differ from a fitted one by a member.
struct Neighbours {
    /// With a member more, less, exchanged for another, or exchanged for two.
    sets: Vec<Scored>,
    /// Without each member.
    without: Vec<Option<Scored>>,
}

fn neighbours<C: Candidates + ?Sized>(
    rows: &Rows<'_, C>,
    best: &Scored,
    base: &Scored,
    (starts, imitators): (&[(usize, Vec<f64>)], &Imitators),
    most: usize,
) -> Option<Neighbours> {
    let settings = rows.whole.settings.search;
    let members = best.members();
    let products = Products::at(&rows.choosing.train, best.hypothesis(), starts)?;
    // Sets that may come near the present one, which is `worth` so much more than what they are added to.
    let near = |all: Vec<Subset<'_>>, residual: f64, worth: f64, from: &Hypothesis, count| {
        let is_near = |s: &&Subset<'_>| {
            let explained = (s.drop / residual.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            let left = residual * (1.0 - explained).powf(settings.nonlinear_power);
            let gain = rows.first_order_cost(residual) - rows.first_order_cost(left);
            let more = s.starts.len() as isize + from.members.len() as isize - members as isize;
            // A larger set has to be better to matter, another of the same size only nearly as good.
            let slack = if more > 0 { -rows.least_price() } else { rows.confusable_cost() };
            gain + slack > worth
        };
        let subsets = all.iter().filter(is_near).take(count);
        subsets.map(|subset| subset.beside(from)).collect::<Vec<Hypothesis>>()
    };
    let additions = || {
        if members >= most {
            return Vec::new();
        }
        let beside = products.beside();
        let all = beside.singles();
        let starts = near(all, beside.residual, 0.0, best.hypothesis(), settings.additions);
        rows.fit_all(starts, Some(best))
    };
    // Another shape of a member may leave nothing for a further cause to explain.
    let in_shapes = |place| in_other_shapes(rows.whole.system, best.hypothesis(), place);
    let shapes = || rows.fit_all((0..members).flat_map(in_shapes).collect(), Some(best));
    let exchanges = |place: usize| {
        let less = if members == 1 { Some(base.clone()) } else { rows.fitted_without(best, place) };
        let worth = less.as_ref().map_or(0.0, |l| l.fit.cost - best.fit.cost);
        let linearised = products.in_place_of(place);
        let rest = best.hypothesis().without(place);
        let residual = linearised.residual;
        let mut others = near(linearised.singles(), residual, worth, &rest, settings.exchanges);
        // Where a response is far from linear, the screening cannot tell a member from those that do nearly the same.
        for (candidate, values) in imitators.of(best.hypothesis().members[place].candidate) {
            let is_known = |h: &Hypothesis| h.contains(*candidate);
            if !is_known(&rest) && !others.iter().any(is_known) {
                others.push(rows.at_best_amplitude(rest.with(*candidate, values)));
            }
        }
        // The linear screening keeps one shape of each candidate, which need not be the best one in place of this member.
        let shapes_of = |h: &Hypothesis| {
            let place = h.members.iter().position(|m| !rest.contains(m.candidate));
            place.map_or_else(Vec::new, |place| in_other_shapes(rows.whole.system, h, place))
        };
        let shapes: Vec<Hypothesis> = others.iter().flat_map(shapes_of).collect();
        others.extend(shapes);
        let mut sets = rows.fit_all(others, Some(best));
        if members < most {
            let pairs = linearised.pairs();
            let pairs = near(pairs, residual, worth, &rest, settings.exchanges_for_two);
            sets.extend(rows.fit_all(pairs, Some(best)));
        }
        sets.extend(less.clone());
        (sets, less)
    };
    // All at the same time, so that no thread waits for the last fits of each.
    let ((mut sets, of_shapes), of_places) =
        parallel::join(|| parallel::join(additions, shapes), || parallel::map(members, exchanges));
    sets.extend(of_shapes);
    let mut without = Vec::new();
    for (of_place, less) in of_places {
        sets.extend(of_place);
        without.push(less);
    }
    Some(Neighbours { sets, without })
}

impl<C: Candidates + ?Sized> Rows<'_, C> {
    /// Whether a set of the screening would reach the odds that a cause needs, to first order: by `−R ln(1 − d/R)` for a
    /// drop `d` of the whitened squared residual `R`, whose variance is not known, and the price of its parameters. Every
    /// row counts: where the residual is correlated because the base model is not right, the fits will tell.
    pub(crate) fn is_promising(&self, subset: &Subset<'_>, residual: f64) -> bool {
        let rows: usize = (0..self.whole.len()).map(|i| self.whole.rows(i)).sum();
        let parameters: usize = subset.starts.iter().map(|s| s.directions.len() - 1).sum();
        let candidates = self.whole.system.candidate_len().max(1) as f64;
        let price = parameters as f64 * (rows.max(2) as f64).ln()
            + 2.0 * subset.starts.len() as f64 * candidates.ln();
        let weighted = residual * self.whole.rows_per_observation;
        let share = (subset.drop / residual.max(f64::MIN_POSITIVE)).min(1.0 - 1e-12);
        0.5 * (-weighted * (-share).ln_1p() - price) > self.needed_log_odds()
    }

    /// The cost of the training rows that leave such a weighted squared residual ([`Problem::cost`]): itself, or beyond
    /// one per row and channel its logarithm.
    ///
    /// [`Problem::cost`]: crate::fit::Problem::cost
    fn first_order_cost(&self, residual: f64) -> f64 {
        let train = &self.choosing.train;
        let rows: usize = (0..train.len()).map(|i| train.rows(i)).sum();
        let noise = (rows * train.noise.channels()) as f64 / train.rows_per_observation;
        if residual > noise { noise * (1.0 + (residual / noise).ln()) } else { residual }
    }

    /// The least price of a further member: of one parameter, and of the choice.
    fn least_price(&self) -> f64 {
        let rows: usize = (0..self.whole.len()).map(|i| self.whole.rows(i)).sum();
        let candidates = self.whole.system.candidate_len().max(1) as f64;
        (rows.max(2) as f64).ln() + 2.0 * candidates.ln()
    }

    /// The set of the best odds. A set that fits worse and is better by its price alone must be so with the weight of the rows beside the
    /// other one as well: what it leaves is correlated over many rows just because it does not fit.
    fn best_of<'s>(&self, sets: &'s [Scored]) -> Option<&'s Scored> {
        let mut best = sets.first()?;
        for other in &sets[1..] {
            let cheaper = other.misfit > best.misfit && best.log_odds(other) > 0.0;
            if other.log_odds(best) > 0.0 && !cheaper {
                best = other;
            }
        }
        Some(best)
    }

    /// The set of the best odds, or the smallest one against which its odds are not enough for further causes.
    pub(super) fn preferred(&self, sets: &[Scored]) -> Option<Scored> {
        let best = self.best_of(sets)?;
        let needed = self.needed_log_odds();
        let mut smaller: Vec<&Scored> =
            sets.iter().filter(|s| s.members() < best.members()).collect();
        smaller.sort_by_key(|s| s.members());
        let enough = smaller.into_iter().find(|s| best.log_odds(s) < needed);
        let chosen = enough.unwrap_or(best);
        // Of indistinguishable sets, the one that comes first in the list of candidates.
        let tied = |s: &&Scored| {
            s.members() == chosen.members()
                && s.hypothesis().set() < chosen.hypothesis().set()
                && chosen.log_odds(s) < TIE
        };
        Some(
            sets.iter().filter(tied).min_by_key(|s| s.hypothesis().set()).unwrap_or(chosen).clone(),
        )
    }
}
