//! Adams' implicit method for the second-order equation, on equal steps.
//!
//! The rate `N = u̇` at the new point and at the eight points before it makes a polynomial of degree eight. Its integrals over
//! the last step give the change of velocity, `H Σ b_i N_{n−i}`, and that of displacement, `H² Σ a_i N_{n−i}` (Hairer, Nørsett
//! and Wanner 1993, III.1 and III.10); integrals up to a part of the step give the states in between.

/// Rates before the new one.
pub(crate) const HISTORY: usize = 8;
/// Rates of the polynomial.
pub(crate) const RATES: usize = HISTORY + 1;

/// Weights of the rates, the newest first: in the displacement (of the squared step) and in the velocity (of the step).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Weights {
    pub(crate) displacement: [f64; RATES],
    pub(crate) velocity: [f64; RATES],
}

/// The method.
#[derive(Debug, Clone)]
pub(crate) struct Adams {
    /// Weights of the rates before the new one, the newest first, in its extrapolation.
    pub(crate) extrapolation: [f64; HISTORY],
    /// At the end of a step.
    pub(crate) end: Weights,
    /// Local error estimate per unit of difference between the new rate and its extrapolation: the difference of the methods
    /// with and without the oldest rate, in displacement (times the squared step) and in velocity (times the step).
    pub(crate) error: [f64; 2],
}

impl Adams {
    pub(crate) fn new() -> Self {
        // Up to sign the binomials: the difference of order eight vanishes.
        let mut extrapolation = [0.0; HISTORY];
        let mut binomial = 1.0;
        for (k, weight) in extrapolation.iter_mut().enumerate() {
            binomial *= (HISTORY - k) as f64 / (k + 1) as f64;
            *weight = if k % 2 == 0 { binomial } else { -binomial };
        }
        let end = Weights::at(1.0);
        // The difference has weight one at the new rate, so the weights there of both orders differ by the error.
        let lower = weights(1.0, HISTORY);
        let error = [
            (end.displacement[0] - lower.displacement[0]).abs(),
            (end.velocity[0] - lower.velocity[0]).abs(),
        ];
        Self { extrapolation, end, error }
    }
}

impl Weights {
    /// At a share of the step.
    pub(crate) fn at(share: f64) -> Self {
        weights(share, RATES)
    }
}

/// Weights of the first `rates` ones, for the polynomial through them.
fn weights(share: f64, rates: usize) -> Weights {
    let mut result = Weights { displacement: [0.0; RATES], velocity: [0.0; RATES] };
    for i in 0..rates {
        // Π_{j≠i} (θ + j)/(j − i), with θ from the new point in steps; −1 is the point before. Shifted to start there,
        // s = θ + 1: factors s + (j − 1).
        let mut product = [0.0; RATES + 1];
        product[0] = 1.0;
        let mut divisor = 1.0;
        for (degree, j) in (0..rates).filter(|&j| j != i).enumerate() {
            for power in (0..=degree + 1).rev() {
                let below = if power > 0 { product[power - 1] } else { 0.0 };
                product[power] = below + (j as f64 - 1.0) * product[power];
            }
            divisor *= j as f64 - i as f64;
        }
        // ∫ s^p = s^{p+1}/(p+1), ∫∫ = s^{p+2}/((p+1)(p+2)).
        let mut power = share;
        for (p, c) in product[..rates].iter().enumerate() {
            let c = c / divisor * power / (p + 1) as f64;
            result.velocity[i] += c;
            result.displacement[i] += c * share / (p + 2) as f64;
            power *= share;
        }
    }
    result
}
