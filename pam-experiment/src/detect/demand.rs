//! What a diagnosis asks of the signature of an effect, and the magnitude at which it is met.

use super::power::needed_noncentrality;
use super::ray::Ray;
use super::result::Limit;
use pam_diagnose::joint::{Signature, Signatures};
use pam_numerics::statistics::{
    chi_square_quantile, mean, standard_deviation, t_quantile, t_quantile_95,
};
use statrs::distribution::{ContinuousCDF, Normal};

/// Relative accuracy of the noncentrality at a limit.
const ACCURACY: f64 = 0.02;
/// Simulations until a limit is given up.
const TRIES: usize = 40;
/// Largest factor from one tried magnitude to the next.
const FACTOR: f64 = 8.0;
/// Share of the first magnitude that is next to nothing.
const NOTHING: f64 = 1e-6;
/// Least one until the limit lies between two of them.
const LEAST_STEP: f64 = 1.5;

/// What a test asks of a signature.
pub(crate) struct Demand<'s, 'a> {
    pub(crate) signatures: &'s Signatures<'a>,
    /// Directions of the test against chance; it is left out without any.
    pub(crate) directions: &'s [Signature],
    pub(crate) seed: u64,
    pub(crate) parameters: usize,
    pub(crate) power: f64,
    pub(crate) level: f64,
    /// Half-widths of the intervals of its parameters that errors of the model on baseline recordings give it; zero without these.
    pub(crate) apparent: &'s [f64],
}

/// Which limit.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    Familywise,
    Listed,
    Named,
}

impl Demand<'_, '_> {
    fn normal(&self) -> f64 {
        Normal::standard().inverse_cdf(self.power)
    }

    /// Quantile of the largest of all candidates by chance (Bonferroni).
    fn by_chance(&self) -> f64 {
        let candidates = self.signatures.acceptance().candidates.max(1) as f64;
        chi_square_quantile(1.0 - self.level / candidates, self.parameters as f64)
    }

    /// The noncentrality at which a drop exceeds so much; `drop ≈ λ + 2√λ z`.
    fn exceeding(&self, drop: f64) -> f64 {
        let z = self.normal();
        (z + (z * z + drop).sqrt()).powi(2)
    }

    /// The noncentrality of a signature over the needed one: the limit is where it is one.
    pub(crate) fn excess(&self, kind: Kind, s: &Signature) -> f64 {
        let a = self.signatures.acceptance();
        let (p, size) = (self.parameters, s.square());
        let chance = needed_noncentrality(self.by_chance(), p as f64, self.power);
        if kind == Kind::Familywise {
            return size / chance;
        }
        let odds = a.rows_per_observation * (a.price(p) + 2.0 * a.log_odds);
        let listed = needed_noncentrality(odds, p as f64, self.power).max(chance);
        // The test against chance: what the signs of blocks make of the same residual grows with it.
        let mut listed = size / listed;
        if !self.directions.is_empty() {
            let by_signs = self.signatures.by_chance(s, self.directions, self.seed);
            listed = listed.min((size.sqrt() - self.normal()).max(0.0).powi(2) / by_signs);
        }
        if kind == Kind::Listed {
            return listed;
        }
        let rows = a.rows as f64;
        let all = rows * a.channels as f64;
        let of_residual = self.exceeding(a.minor_of_residual / (1.0 - a.minor_of_residual) * all);
        let channels = self.signatures.channel_squares(s);
        let rise = self.exceeding(a.minor_rise * rows);
        let largest = channels.into_iter().fold(0.0, f64::max);
        // Nuisances that imitate the effect are far from their priors.
        let priors = self.signatures.prior_squares(s);
        let strain = priors.iter().sum::<f64>() / self.exceeding(a.most_prior_square);
        let not_minor = (size / of_residual).max(largest / rise).max(strain);
        listed.min(not_minor).min(self.proven(s, &priors))
    }

    /// Expected test statistic of the confirmation over its critical value, squared; the mean over recordings. The statistic is the
    /// largest of three Student's t over blocks: of the gains, of the relative gains, and of the score (the product of residual
    /// and change of the prediction), which scatters half as much and is tested at a stricter level.
    /// Instead, the nuisances of a recording may be so much nearer to their `priors` with the effect that this confirms it.
    fn proven(&self, s: &Signature, priors: &[f64]) -> f64 {
        let blocks = self.signatures.test_block_squares(s);
        let a = self.signatures.acceptance();
        let rows = a.rows as f64 / blocks.iter().map(Vec::len).sum::<usize>().max(1) as f64;
        let noise = 2.0 * rows * a.channels as f64;
        let clear = self.exceeding(a.clear_prior_cost);
        let ratio = |(own, prior): (&Vec<f64>, &f64)| {
            let n = own.len() as f64;
            if n < 2.0 {
                return 1.0;
            }
            let student = |gains: &[f64], scatter: &[f64]| {
                let scatter = scatter.iter().sum::<f64>() / n;
                let variance = standard_deviation(gains).powi(2) * n / (n - 1.0) + scatter;
                mean(gains) / (variance / n).sqrt()
            };
            let needed = |quantile: f64| quantile + self.normal();
            let relative: Vec<f64> = own.iter().map(|b| b / (b + noise)).collect();
            let of_relative: Vec<f64> = own.iter().map(|b| 4.0 * b / (b + noise).powi(2)).collect();
            let scatter: Vec<f64> = own.iter().map(|b| 4.0 * b).collect();
            let of_gains = student(own, &scatter).max(student(&relative, &of_relative))
                / needed(t_quantile_95(n - 1.0));
            // The score confirms only where the error falls as well.
            let of_score = (student(own, own) / needed(t_quantile(1.0 - a.score_p_value, n - 1.0)))
                .min(own.iter().sum::<f64>().sqrt() / (2.0 * self.normal()));
            of_gains.max(of_score).powi(2).max(prior / clear)
        };
        blocks.iter().zip(priors).map(ratio).sum::<f64>() / blocks.len().max(1) as f64
    }

    /// The value of the effect over that at which its interval leaves out zero with the wanted power, squared as a noncentrality.
    /// [`apparent`](Self::apparent) is both the half-width of that interval and 1.96 standard deviations of the estimate.
    fn beyond_apparent(&self, ray: &Ray, magnitude: f64) -> f64 {
        let needed = 1.0 + self.normal() / Normal::standard().inverse_cdf(0.975);
        let over = ray.over(self.apparent, magnitude) / needed;
        if over.is_nan() { f64::INFINITY } else { over * over }
    }

    /// The magnitude at which the excess is one; the weakest one of the range if it is exceeded there.
    pub(super) fn limit(
        &self,
        ray: &Ray,
        nothing: Option<&Signature>,
        kind: Kind,
    ) -> Option<Limit> {
        let (mut low, mut high): (f64, f64) = (0.0, f64::INFINITY);
        let mut m = ray.first_magnitude();
        for tried in 0..TRIES {
            let s = signature(self.signatures, ray, m, nothing);
            let excess = match &s {
                Some(s) if s.square() > 0.0 => {
                    let own = self.excess(kind, s);
                    if kind == Kind::Named { own.min(self.beyond_apparent(ray, m)) } else { own }
                }
                Some(_) => 0.0,
                // So large that the simulation diverges.
                None => f64::INFINITY,
            };
            let noncentrality = s.map_or(f64::NAN, |s| s.square());
            let found = Limit { value: ray.value(m), magnitude: m, noncentrality };
            let settled = high / low < 1.0 + ACCURACY;
            if excess.is_finite() && ((excess - 1.0).abs() < ACCURACY || settled) {
                return ray.admits(m).then_some(found);
            }
            if excess < 1.0 {
                low = m
            } else {
                high = m
            }
            if excess < 1.0 && !ray.admits(m) && ray.is_beyond(m) {
                return None;
            }
            if excess > 1.0 && ray.is_weakest(m) {
                return Some(found);
            }
            // As the root of the noncentrality, or further where the test against chance does not follow it.
            let step = excess.max(1e-12).sqrt().recip().clamp(1.0 / FACTOR, FACTOR);
            let step = match (low > 0.0, high.is_finite()) {
                (false, true) => step.min(LEAST_STEP.recip()),
                (true, false) => step.max(LEAST_STEP),
                _ => step,
            };
            let next = m * step;
            let inside = next > low && next < high && tried % 3 != 2;
            m = if inside { next } else { between(low, high, m) };
            m = ray.not_below_weakest(m);
        }
        None
    }
}

/// The signature of an effect of next to nothing: with dry friction, however small, the simulation takes other steps.
pub(crate) fn of_nothing(signatures: &Signatures<'_>, ray: &Ray) -> Option<Signature> {
    signatures.of(ray.candidate, &ray.values(NOTHING * ray.first_magnitude()))
}

/// The signature of an effect at a magnitude, less the one of [next to nothing](of_nothing).
pub(crate) fn signature(
    signatures: &Signatures<'_>,
    ray: &Ray,
    magnitude: f64,
    nothing: Option<&Signature>,
) -> Option<Signature> {
    let s = signatures.of(ray.candidate, &ray.values(magnitude))?;
    Some(match nothing {
        Some(nothing) => s.less(nothing),
        None => s,
    })
}

fn between(low: f64, high: f64, m: f64) -> f64 {
    match (low > 0.0, high.is_finite()) {
        (true, true) => (low * high).sqrt(),
        (false, true) => high / FACTOR,
        (true, false) => low * FACTOR,
        (false, false) => m * FACTOR,
    }
}
