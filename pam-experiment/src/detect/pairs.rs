//! Which effects a diagnosis distinguishes.

use super::DetectOptions;
use super::ray::Ray;
use super::result::{Limits, Pair};
use pam_core::parallel;
use pam_diagnose::joint::{Signature, SignatureSpan, Signatures};
use pam_effects::effects::AnyEffect;
use statrs::distribution::{ContinuousCDF, Normal};

/// Multiple of the limit from which trials count for confusions: a little less than the limit, which they themselves have found.
const AT_LIMIT: f64 = 0.8;

/// The directions of an effect at values: by its parameters, and by switching it on.
pub(crate) fn span_of(
    signatures: &Signatures<'_>,
    candidate: usize,
    values: &[f64],
) -> Vec<Signature> {
    let mut all = signatures.tangents(candidate, values).unwrap_or_default();
    all.extend(signatures.of(candidate, values));
    all
}

/// A magnitude at which an effect shows plainly: its limit, or its starting value.
pub(crate) fn reference(limits: &Limits, ray: &Ray) -> f64 {
    limits
        .named
        .or(limits.listed)
        .or(limits.familywise)
        .map_or_else(|| ray.first_magnitude(), |l| l.magnitude)
}

/// Every effect at its limit beside the span of every other one at its own.
pub(super) fn pairs(
    signatures: &Signatures<'_>,
    ways: &[(&'static dyn AnyEffect, Ray)],
    limits: &[Limits],
    options: &DetectOptions,
) -> Vec<Pair> {
    let a = signatures.acceptance();
    let z = Normal::standard().inverse_cdf(options.power);
    let spans: Vec<Vec<Signature>> = parallel::map(ways.len(), |k| {
        let ray = &ways[k].1;
        span_of(signatures, ray.candidate, &ray.values(reference(&limits[k], ray)))
    });
    let mut candidates: Vec<usize> = ways.iter().map(|w| w.1.candidate).collect();
    candidates.dedup();
    // The ways of one effect span it together.
    let whole: Vec<(usize, SignatureSpan)> = parallel::map_each(candidates, |candidate| {
        let own = ways.iter().zip(&spans).filter(|(w, _)| w.1.candidate == candidate);
        let all: Vec<Signature> = own.flat_map(|(_, s)| s.clone()).collect();
        (candidate, SignatureSpan::of(&all))
    });
    let of_way = |k: usize| -> Vec<Pair> {
        let ray = &ways[k].1;
        let Some(limit) = limits[k].named else { return Vec::new() };
        let Some(s) = signatures.of(ray.candidate, &ray.values(limit.magnitude)) else {
            return Vec::new();
        };
        let size = s.square();
        let others = whole.iter().filter(|(candidate, _)| *candidate != ray.candidate);
        others
            .map(|(candidate, span)| {
                let other = options.diagnosis.candidates[*candidate].info();
                let own = (s.beside(span).square() / size).clamp(0.0, 1.0);
                let price = a.price(ray.parameters) - a.price(other.parameters.len());
                let cost = a.rows_per_observation * (2.0 * a.confusable_odds.ln() + price);
                let needed = (z + (z * z + cost.max(0.0)).sqrt()).powi(2);
                let told = (1.0 - own < a.confusable_share)
                    .then(|| (needed / (own * size)).sqrt().max(1.0));
                Pair {
                    effect: ray.label(),
                    other: other.id.to_owned(),
                    cosine: (1.0 - own).sqrt(),
                    distinguished_from: told,
                    tried: limits[k].tried.as_ref().and_then(|t| t.confusions(other.id, AT_LIMIT)),
                }
            })
            .collect()
    };
    parallel::map(ways.len(), of_way).into_iter().flatten().collect()
}
