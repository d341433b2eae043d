//! The limit of an effect from trials at chosen magnitudes.
//!
//! The probability that an effect of magnitude `m` is named is modelled as `Φ(a m/L − a + z)` between a share of chance hits and of
//! lapses, where `L` is the limit and `z` the quantile of its power; the prior of `ln L` is Gaussian about an expected limit. The
//! next magnitude is where the posterior expects the effect to be named in rather more than half of the cases: there an outcome
//! tells most (Watson and Pelli 1983, *QUEST: a Bayesian adaptive psychometric method*).

use statrs::distribution::{ContinuousCDF, Normal};

/// Standard deviation of the prior of `ln L` about the expected limit: a factor of 2.5.
const PRIOR_DEVIATION: f64 = 0.9;
/// Steps of `ln L` on each side of the expected limit,
const STEPS: i32 = 100;
/// and the length of a step: up to a factor of 20.
const STEP: f64 = 0.03;
/// Steepness `a` of the probability that an effect is named: an effect of 0.68 of the limit is named in every second case.
const STEEPNESS: f64 = 4.0;
/// Share of chance hits, and of lapses.
const LAPSES: f64 = 0.03;
/// Probability at which the next magnitude is aimed.
const AIM: f64 = 0.7;

/// The posterior of a detection limit after some trials.
///
/// ```
/// use pam_experiment::detect::LimitPosterior;
/// // Whatever is larger than 0.8 is named.
/// let mut limit = LimitPosterior::about(2.0, 0.9);
/// for _ in 0..12 {
///     let magnitude = limit.next_magnitude();
///     limit.learn(magnitude, magnitude > 0.8);
/// }
/// assert!((0.7..1.3).contains(&limit.quantile(0.5)));
/// ```
#[derive(Debug, Clone)]
pub struct LimitPosterior {
    log_limits: Vec<f64>,
    log_density: Vec<f64>,
    /// Quantile of the normal distribution at the power of the limit.
    z: f64,
}

impl LimitPosterior {
    /// Nothing but an expected magnitude at the limit, and the power that defines it.
    #[must_use]
    pub fn about(expected: f64, power: f64) -> Self {
        let steps = (-STEPS..=STEPS).map(|k| f64::from(k) * STEP);
        let (log_limits, log_density) =
            steps.map(|s| (expected.ln() + s, -0.5 * (s / PRIOR_DEVIATION).powi(2))).unzip();
        Self { log_limits, log_density, z: Normal::standard().inverse_cdf(power) }
    }

    /// Learns from a trial at a magnitude.
    pub fn learn(&mut self, magnitude: f64, named: bool) {
        let normal = Normal::standard();
        for (log_limit, density) in self.log_limits.iter().zip(&mut self.log_density) {
            let ratio = magnitude / log_limit.exp();
            let own = normal.cdf(STEEPNESS * (ratio - 1.0) + self.z);
            let probability = LAPSES + (1.0 - 2.0 * LAPSES) * own;
            *density += if named { probability.ln() } else { (1.0 - probability).ln() };
        }
    }

    /// The magnitude that the limit is below with this probability.
    #[must_use]
    pub fn quantile(&self, share: f64) -> f64 {
        let most = self.log_density.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let weights: Vec<f64> = self.log_density.iter().map(|d| (d - most).exp()).collect();
        let all: f64 = weights.iter().sum();
        let mut below = 0.0;
        for (log_limit, weight) in self.log_limits.iter().zip(&weights) {
            below += weight;
            if below >= share * all {
                return log_limit.exp();
            }
        }
        self.log_limits.last().map_or(f64::NAN, |l| l.exp())
    }

    /// The magnitude of the next trial.
    #[must_use]
    pub fn next_magnitude(&self) -> f64 {
        let offset = Normal::standard().inverse_cdf(AIM) - self.z;
        self.quantile(0.5) * (1.0 + offset / STEEPNESS)
    }
}
