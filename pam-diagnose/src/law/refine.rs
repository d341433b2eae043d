//! Laws through the simulation.

use crate::error::DiagnoseError;
use crate::fit::{Hypothesis, Member};
use crate::remainder::Ground;
use crate::search::{Candidates, Scored};
use crate::terms::{Definition, Term, TermSpace};
use pam_core::parallel;

/// A law that was fitted to the training rows.
#[derive(Debug, Clone)]
pub(crate) struct Tried {
    /// Its terms with fitted numbers.
    pub(crate) terms: Vec<Term>,
    /// Named causes beside it, with their values.
    pub(crate) named: Vec<Member>,
    /// Values of the definition's parameters.
    pub(crate) values: Vec<f64>,
    pub(crate) scored: Scored,
    /// Minus two times the logarithm of its posterior probability, up to a constant.
    pub(crate) total: f64,
    /// Length of its description, nats.
    pub(crate) length: f64,
    /// Mean whitened squares of the channels on training and validation rows.
    pub(crate) chi: Vec<f64>,
}

/// Length of the description of a named cause: one of a list.
fn listed_length(listed: usize) -> f64 {
    (listed.max(1) as f64).ln()
}

/// A set of terms to be fitted, with or without the named causes.
#[derive(Debug, Clone)]
pub(crate) struct Proposal {
    pub(crate) terms: Vec<Term>,
    pub(crate) named: Vec<Member>,
}

/// Fits proposals to the training rows and scores them on the validation rows.
pub(crate) fn refine<T: TermSpace>(
    space: &T,
    ground: &Ground<'_>,
    proposals: &[Proposal],
    rows_per_observation: f64,
    iterations: usize,
) -> Result<Vec<Tried>, DiagnoseError> {
    let (variables, places) = (space.variables(), space.places());
    let definitions: Vec<Definition> = proposals
        .iter()
        .enumerate()
        .map(|(k, p)| Definition::law(&format!("law{}", k + 1), "", &p.terms, variables, places))
        .collect();
    space.with(&definitions, |system| {
        let start = ground.start(system);
        let Some(mut rows) = ground.rows(system, &start) else { return Ok(Vec::new()) };
        rows.set_rows_per_observation(rows_per_observation);
        let tried = parallel::map(proposals.len(), |k| {
            let proposal = &proposals[k];
            let values: Vec<f64> = definitions[k].parameters.iter().map(|p| p.start).collect();
            let base = Hypothesis { members: proposal.named.clone(), ..rows.choosing.train.base() };
            let h = base.with(ground.listed + k, &values);
            let scored = rows.fitted(h, iterations)?;
            let mut named = scored.hypothesis().members.clone();
            let values = named.pop()?.values;
            let terms = definitions[k].with_values(&proposal.terms, &values);
            let length = terms
                .iter()
                .map(|t| t.description_length(variables, places))
                .sum::<f64>()
                + proposal.named.len() as f64 * listed_length(28);
            let members = scored.members() as f64;
            let choice = 2.0 * members * (system.candidate_len().max(1) as f64).ln();
            let total = scored.total(rows_per_observation) - choice + 2.0 * length;
            let chi = scored.fit.errors.and(&scored.validation).mean();
            Some(Tried { terms, named, values, scored, total, length, chi })
        });
        let mut tried: Vec<Tried> = tried.into_iter().flatten().collect();
        tried.sort_by(|a, b| a.total.total_cmp(&b.total));
        Ok(tried)
    })
}

/// Rise of the mean square of a channel, relative to it or to the noise, that is too little for more words.
const NOTABLE_RISE: f64 = 0.1;

/// Of laws that leave nearly as much in every channel as the one of the best odds, the shortest.
pub(crate) fn preferred(tried: &[Tried]) -> Option<&Tried> {
    let best = tried.first()?;
    let as_good = |t: &&Tried| {
        let mut channels = t.chi.iter().zip(&best.chi);
        channels.all(|(own, least)| own - least < NOTABLE_RISE * least.max(1.0))
    };
    tried.iter().filter(as_good).min_by(|a, b| {
        (a.length + 0.5 * price(a)).total_cmp(&(b.length + 0.5 * price(b)))
    })
}

/// Nats for the values of a law's numbers.
fn price(t: &Tried) -> f64 {
    4.0 * t.values.len() as f64
}
