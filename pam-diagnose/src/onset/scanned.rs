//! The scan at a hypothesis: edges that may reach the odds, and their test against chance.

use super::cells::CellProducts;
use super::scan::{Edge, OnsetTest, Scan, Scored, touched};
use super::schedule::{Acts, Pattern};
use crate::fit::{Hypothesis, Problem};
use crate::search::{Candidates, Rows};

/// The scan at a hypothesis.
pub(super) struct Scanned {
    pub(super) test: Option<OnsetTest>,
    /// Edges that may reach the odds, the best first.
    pub(super) promising: Vec<Scored>,
    /// Edges from which each was chosen.
    pub(super) choices: f64,
    products: CellProducts,
}

impl Scanned {
    pub(super) fn by_chance(&self, probability: f64) -> bool {
        self.test.is_none_or(|t| t.p_value > 1.0 - probability)
    }
}

/// The scan at a fitted hypothesis over the edges that `may_be`; the logarithm of the odds of a promising one is at least
/// `needed`.
pub(super) fn scanned<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    at: &Hypothesis,
    starts: &[(usize, Vec<f64>)],
    needed: f64,
    may_be: Option<&dyn Fn(&Edge) -> bool>,
    seed: u64,
) -> Option<Scanned> {
    let settings = &problem.settings.onset;
    let every = vec![true; problem.len()];
    let asked = match may_be {
        Some(may_be) => touched(&CellProducts::cells_of(problem), settings, may_be),
        None => every.clone(),
    };
    let (may_be, of_each) = (may_be.unwrap_or(&|_| true), may_be.is_none());
    let mut products = CellProducts::at(problem, at, starts, &asked)?;
    if asked != every {
        // The comparison with an effect at all times needs every experiment; it is made only where something is promising.
        let scan = Scan::new(&products, settings, may_be);
        let reached = promising(problem, &scan, (products.square, of_each), needed, false);
        if reached.is_empty() {
            let choices = scan.edges_per_direction() as f64;
            return Some(Scanned { test: None, promising: reached, choices, products });
        }
        products = CellProducts::at(problem, at, starts, &every)?;
    }
    Some(judged(problem, products, (may_be, of_each), needed, seed))
}

/// The scan of these products.
fn judged<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    products: CellProducts,
    (may_be, of_each): (&dyn Fn(&Edge) -> bool, bool),
    needed: f64,
    seed: u64,
) -> Scanned {
    let settings = &problem.settings.onset;
    let scan = Scan::new(&products, settings, may_be);
    let choices = scan.edges_per_direction() as f64;
    let promising = promising(problem, &scan, (products.square, of_each), needed, true);
    // The draws take longer than the scan; where nothing is promising, they decide nothing.
    let test = if promising.is_empty() { None } else { scan.test(settings, seed) };
    Scanned { test, promising, choices, products }
}

/// Edges of a scan of residuals with this `square` that may reach the odds, the best first: better than without the candidate,
/// and, if it is asked for, better than with it at all times.
fn promising<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    scan: &Scan<'_>,
    (square, of_each): (f64, bool),
    needed: f64,
    than_always: bool,
) -> Vec<Scored> {
    let choices = scan.edges_per_direction() as f64;
    scan.best(of_each)
        .into_iter()
        .filter(|s| {
            let times = match s.edge.pattern {
                Pattern::Each => s.edge.times_s.len(),
                Pattern::Shared | Pattern::Once => 1,
            };
            let own = problem.system.candidate(s.direction.candidate).parameters.len();
            let of_times = times as f64 * (log_rows(problem) + 2.0 * choices.ln());
            let of_own = own as f64 * log_rows(problem)
                + 2.0 * (problem.system.candidate_len().max(1) as f64).ln();
            let weighted = square * problem.rows_per_observation;
            let odds = |drop: f64, price: f64| {
                let share = (drop / square.max(f64::MIN_POSITIVE)).min(1.0 - 1e-12);
                0.5 * (-weighted * (-share).ln_1p() - price)
            };
            odds(s.drop, of_own + of_times) > needed
                && (!than_always || odds(s.contrast, of_times) > needed)
        })
        .collect()
}

fn log_rows<C: Candidates + ?Sized>(problem: &Problem<'_, C>) -> f64 {
    let rows: usize = (0..problem.len()).map(|i| problem.rows(i)).sum();
    (rows.max(2) as f64).ln()
}

/// The logarithm of the odds that a set with a time must reach against one without.
pub(super) fn needed<C: Candidates + ?Sized>(rows: &Rows<'_, C>) -> f64 {
    rows.needed_log_odds().max(rows.whole.settings.onset.odds.ln())
}

/// The curves of the first member of a set that begins or ends.
pub(super) fn curves<C: Candidates + ?Sized>(
    rows: &Rows<'_, C>,
    scans: &[Scanned],
    set: &Hypothesis,
) -> Vec<(String, Vec<(f64, f64)>)> {
    let Some(member) = set.members.iter().find(|m| m.schedule.is_some()) else {
        return Vec::new();
    };
    let ends = |a: &Acts| matches!(a, Acts::Within(c, _) if !c.onset);
    let begins = !member.schedule.as_ref().is_some_and(|s| s.acts.iter().any(ends));
    let system = rows.whole.system;
    scans
        .iter()
        .map(|s| {
            let scan = Scan::new(&s.products, &rows.whole.settings.onset, &|_| true);
            scan.curve(member.candidate, begins)
        })
        .filter(|curves| curves.iter().any(|c| !c.is_empty()))
        .max_by(|a, b| highest(a).total_cmp(&highest(b)))
        .into_iter()
        .flatten()
        .zip(&rows.whole.experiments)
        .map(|(curve, &e)| {
            let start_s = system.start_s(e);
            let at = |(t, drop): (f64, f64)| (start_s + t, drop);
            (system.name(e).to_owned(), curve.into_iter().map(at).collect())
        })
        .collect()
}

fn highest(curves: &[Vec<(f64, f64)>]) -> f64 {
    curves.iter().flatten().map(|p| p.1).fold(0.0, f64::max)
}
