//! Sets shrink.

use super::candidates::Candidates;
use super::scored::{Scored, refit_without};
use crate::data::Split;
use crate::rejection::insignificant;
use pam_core::parallel;

/// Drops members that are not worth their place once the others are there.
pub(super) fn shrink<C: Candidates + ?Sized>(split: &Split<'_, C>, mut best: Scored) -> Scored {
    let settings = &split.train.settings.search;
    loop {
        if best.members() < 2 {
            return best;
        }
        let without: Vec<Scored> = parallel::map(best.members(), |place| {
            refit_without(split, &best, place, settings.drop_iterations)
        })
        .into_iter()
        .flatten()
        .collect();
        let dropped = without
            .into_iter()
            .filter(|less| !best.earns(less, &split.train.noise, settings, 1.0))
            .min_by(|a, b| a.total.total_cmp(&b.total));
        match dropped {
            Some(less) => best = less,
            None => return best,
        }
    }
}

/// Drops members whose intervals do not exclude that they are absent.
pub(super) fn significant<C: Candidates + ?Sized>(
    split: &Split<'_, C>,
    mut best: Scored,
) -> Scored {
    let iterations = split.train.settings.search.insignificant_iterations;
    while let Some(place) = insignificant(&split.train, &best.fit) {
        match refit_without(split, &best, place, iterations) {
            Some(less) => best = shrink(split, less),
            None => break,
        }
    }
    best
}
