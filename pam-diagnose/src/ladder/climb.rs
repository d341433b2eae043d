//! The fits of all rungs.

use super::table::{Ladder, Rung, RungError};
use crate::diagnosis::Prepared;
use crate::error::DiagnoseError;
use crate::fit::{Fit, Hypothesis, Member, Problem};
use crate::noise::Noise;
use crate::search::Candidates;
use crate::test_set::TestSet;
use pam_core::parallel;
use std::f64::consts::LN_2;

/// A rung before it is fitted: candidates of the system that act together.
#[derive(Debug, Clone, PartialEq)]
pub struct RungModel {
    /// Id.
    pub id: String,
    /// What it is.
    pub description: String,
    /// Its candidates.
    pub candidates: Vec<usize>,
}

/// Combinations of starting values of a rung with several candidates.
const MOST_STARTS: usize = 24;
/// Fits that are followed to the end.
const FOLLOWED: usize = 3;

/// Fits every rung to training and validation data together, and measures it on the test set.
///
/// # Errors
/// [`DiagnoseError`] if the system itself cannot be simulated, or no start of a rung can.
pub fn climb(
    prepared: &Prepared<'_>,
    name: &str,
    models: &[RungModel],
    done: &(dyn Fn(f64) + Sync),
) -> Result<Ladder, DiagnoseError> {
    let Prepared { system, roles, settings, seed, .. } = prepared;
    let mut whole = roles.whole(*system, &Noise::white(&prepared.noise), settings);
    let iterations = settings.search.iterations;
    let base = whole.fit(whole.base(), iterations)?;
    let mut fits = vec![base];
    for (k, model) in models.iter().enumerate() {
        let fit = fitted(&whole, model, &fits)?;
        fits.push(fit);
        done((k + 1) as f64 / (2 * models.len() + 1) as f64);
    }
    // One noise for all: the one beside the rung that describes the data best.
    let best = shortest(&whole, &fits);
    if let Some(noise) = Noise::learned(&whole, &fits[best].hypothesis, &prepared.prior) {
        whole.noise = noise;
        whole.rows_per_observation = whole.correlated_rows(&fits[best].hypothesis)?;
        let mut again: Vec<Fit> = vec![whole.fit(fits[0].hypothesis.clone(), iterations)?];
        for (k, (model, before)) in models.iter().zip(&fits[1..]).enumerate() {
            let own = whole.fit(before.hypothesis.clone(), iterations)?;
            let from_others = fitted(&whole, model, &again)?;
            again.push(if own.cost < from_others.cost { own } else { from_others });
            let share = (models.len() + k + 1) as f64 / (2 * models.len() + 1) as f64;
            done(share);
        }
        fits = again;
    }
    let test = roles.test(*system, &whole.noise, settings).opened(&fits[0].hypothesis)?;
    let lengths: Vec<f64> = fits.iter().map(|fit| bits(&whole, fit)).collect();
    let least = lengths.iter().copied().fold(f64::INFINITY, f64::min);
    let none = RungModel {
        id: "none".into(),
        description: "the model without any of them".into(),
        candidates: Vec::new(),
    };
    let all = [none].into_iter().chain(models.iter().cloned());
    let rungs = all
        .zip(fits.iter().zip(&lengths))
        .map(|(model, (fit, length))| {
            rung(&whole, &test, &fits[0].hypothesis, fit, model, length - least, *seed)
        })
        .collect::<Result<Vec<Rung>, _>>()?;
    let shortest = shortest(&whole, &fits);
    done(1.0);
    Ok(Ladder { name: name.to_owned(), rungs, shortest })
}

/// The description length of a fit, bits, up to a constant of the rows.
fn bits(problem: &Problem<'_, dyn Candidates + '_>, fit: &Fit) -> f64 {
    let rows = fit.errors.rows.max(2) as f64;
    let parameters = fit.hypothesis.parameters(problem.system).len() as f64;
    0.5 * (fit.cost + parameters * rows.ln()) / LN_2
}

/// The fit of the shortest description; the first of equal ones.
fn shortest(problem: &Problem<'_, dyn Candidates + '_>, fits: &[Fit]) -> usize {
    let lengths: Vec<f64> = fits.iter().map(|fit| bits(problem, fit)).collect();
    (0..fits.len()).min_by(|&a, &b| lengths[a].total_cmp(&lengths[b])).unwrap_or(0)
}

fn rung(
    whole: &Problem<'_, dyn Candidates + '_>,
    test: &TestSet<'_, dyn Candidates + '_>,
    base: &Hypothesis,
    fit: &Fit,
    model: RungModel,
    bits: f64,
    seed: u64,
) -> Result<Rung, DiagnoseError> {
    let parameters = fit.hypothesis.parameters(whole.system);
    let intervals = whole.intervals(fit)?;
    let named = parameters.iter().zip(intervals).map(|(p, mut interval)| {
        interval.ci95 = interval.ci95.map(|end| end.clamp(p.info.range[0], p.info.range[1]));
        (p.info.name, interval)
    });
    let (errors, chi_square) = if test.problem().is_empty() {
        (Vec::new(), None)
    } else {
        let reduction = test.error_reduction(base, &fit.hypothesis, seed);
        let outputs = whole.system.outputs();
        let each = reduction.channels.iter().map(|c| RungError {
            channel: c.key.clone(),
            unit: outputs
                .iter()
                .find(|o| o.key == c.key)
                .map_or_else(String::new, |o| o.unit.clone()),
            rmse: c.rmse_after,
            reduction_ci95: c.ci95,
        });
        let chi_square = test.chi_square(&fit.hypothesis);
        (each.collect(), chi_square.is_finite().then_some(chi_square))
    };
    Ok(Rung {
        parameters: named.collect(),
        at_limit: fit.at_limit.clone(),
        description_length_bits: bits,
        chi_square: fit.errors.chi_square(),
        test_chi_square: chi_square,
        test: errors,
        id: model.id,
        description: model.description,
    })
}

/// The best fit of a rung: from its own starting values, and from the values of all rungs before it.
fn fitted(
    whole: &Problem<'_, dyn Candidates + '_>,
    model: &RungModel,
    before: &[Fit],
) -> Result<Fit, DiagnoseError> {
    let settings = &whole.settings.search;
    let base = whole.base();
    let with = |values: &[Vec<f64>], from: &Hypothesis| {
        let members = model.candidates.iter().zip(values).map(|(c, v)| Member::always(*c, v));
        Hypothesis { members: members.collect(), ..from.clone() }
    };
    let own = combinations(whole.system, &model.candidates);
    let mut starts: Vec<Hypothesis> = own.iter().map(|values| with(values, &base)).collect();
    if let Some(first) = own.first() {
        for fit in before.iter().filter(|f| !f.hypothesis.members.is_empty()) {
            for absent in [true, false] {
                let values = continued(whole.system, &model.candidates, first, fit, absent);
                starts.push(with(&values, &fit.hypothesis));
            }
        }
    }
    let fits = parallel::map_each(starts, |start| {
        whole.fit_to(start, settings.tried_iterations, settings.converged_drop)
    });
    let (mut going, mut failed) = (Vec::new(), None);
    for fit in fits {
        match fit {
            Ok(fit) => going.push(fit),
            Err(error) => failed = Some(error),
        }
    }
    going.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    going.truncate(FOLLOWED);
    let further = parallel::map_each(going, |fit| whole.fit_further(fit, settings.iterations));
    let best = further.into_iter().flatten().min_by(|a, b| a.cost.total_cmp(&b.cost));
    best.ok_or_else(|| {
        failed.unwrap_or_else(|| {
            DiagnoseError::TooLittle(format!("the rung `{}` has no starting values", model.id))
        })
    })
}

/// Starting values of several candidates in all combinations.
fn combinations(system: &dyn Candidates, candidates: &[usize]) -> Vec<Vec<Vec<f64>>> {
    let mut all: Vec<Vec<Vec<f64>>> = vec![Vec::new()];
    for &candidate in candidates {
        let starts = system.starts(candidate);
        all = all
            .iter()
            .flat_map(|known| {
                starts.iter().map(move |own| [known.as_slice(), std::slice::from_ref(own)].concat())
            })
            .take(MOST_STARTS)
            .collect();
    }
    all
}

/// Values of candidates with those of a fit where the names of parameters are the same; others are absent, or as they start.
fn continued(
    system: &dyn Candidates,
    candidates: &[usize],
    start: &[Vec<f64>],
    fit: &Fit,
    absent: bool,
) -> Vec<Vec<f64>> {
    let fitted = fit.hypothesis.parameters(system);
    let known = |candidate: usize, name: &str| {
        let members = &fit.hypothesis.members;
        let mut same = fitted.iter().filter(|p| p.info.name == name);
        let own = same.clone().find(|p| members[p.member].candidate == candidate);
        let p = own.or_else(|| same.next())?;
        Some(members[p.member].values[p.value])
    };
    let of = |(candidate, start): (&usize, &Vec<f64>)| {
        let mut values = start.clone();
        for (value, info) in values.iter_mut().zip(system.candidate(*candidate).parameters) {
            match (known(*candidate, info.name), info.off) {
                (Some(fitted), _) => *value = fitted,
                (None, Some(off)) if absent => *value = off,
                (None, _) => {}
            }
        }
        values
    };
    candidates.iter().zip(start).map(of).collect()
}
