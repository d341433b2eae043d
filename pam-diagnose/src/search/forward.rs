//! Sets grow in a beam.

use super::backward;
use super::candidates::Candidates;
use super::extend::{alone, beside};
use super::scored::{Scored, fit_base};
use crate::data::Split;

/// What a search found.
#[derive(Debug, Clone)]
pub struct Findings {
    /// The system without candidates.
    pub base: Scored,
    /// Every candidate alone, best first.
    pub singles: Vec<Scored>,
    /// The chosen set; the base if nothing earned its place.
    pub best: Scored,
    /// Sets that came close, best first.
    pub others: Vec<Scored>,
}

/// Searches for the set of at most `most` candidates that explains best what the base leaves; `None` if the base
/// cannot be simulated. `done` is called with the finished share of the work.
///
/// Sets grow in a beam of the best of each size, so that a candidate that only shows together with another is found.
/// Each growth must earn its place on the validation rows, and in the end each member must still be worth it.
pub fn search<C: Candidates + ?Sized>(
    split: &Split<'_, C>,
    most: usize,
    done: &(dyn Fn(f64) + Sync),
) -> Option<Findings> {
    let settings = &split.train.settings.search;
    let noise = &split.train.noise;
    let base = fit_base(split)?;
    done(0.05);
    let singles = alone(split, base.hypothesis());
    done(0.3);
    let mut best = base.clone();
    let mut others = singles.clone();
    let mut beam: Vec<Scored> = singles.iter().take(settings.beam_width).cloned().collect();
    if let Some(first) = beam.first()
        && first.earns(&best, noise, settings, 1.0)
    {
        best = first.clone();
    }
    for size in 2..=most {
        // A pair may show what neither shows alone; beyond that, only a set that grew grows on.
        let grown = best.members() + 1 == size;
        let sufficient = best.chi_square(noise) < settings.sufficient_chi_square;
        if !(grown || size == 2) || sufficient || beam.is_empty() {
            break;
        }
        let mut next: Vec<Scored> = Vec::new();
        for set in &beam {
            for scored in beside(split, set.hypothesis(), &singles, settings.followed) {
                let candidates = scored.hypothesis().set();
                match next.iter_mut().find(|s| s.hypothesis().set() == candidates) {
                    Some(known) if scored.total < known.total => *known = scored,
                    Some(_) => {}
                    None => next.push(scored),
                }
            }
        }
        next.sort_by(|a, b| a.total.total_cmp(&b.total));
        let Some(top) = next.first().cloned() else { break };
        let near_noise = best.chi_square(noise) < settings.near_noise_chi_square;
        let strict = if near_noise { settings.near_noise_factor } else { 1.0 };
        let factor = strict * (top.members() - best.members()) as f64;
        let earned = top.earns(&best, noise, settings, factor);
        if earned || !near_noise {
            others.extend(next.iter().cloned());
        }
        if !earned {
            break;
        }
        best = top;
        beam = next.into_iter().take(settings.beam_width).collect();
        done(0.3 + 0.6 * size as f64 / most as f64);
    }
    best = backward::significant(split, backward::shrink(split, best));
    others.sort_by(|a, b| a.total.total_cmp(&b.total));
    done(1.0);
    Some(Findings { base, singles, best, others })
}
