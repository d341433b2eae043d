//! Losses of one's own without their derivatives.

use super::TrajectoryLoss;
use pam_autodiff::Chunk;
use pam_data::{Channel, Recording};

/// The errors of one sample with their derivatives: mm, mm/s, kPa, kPa.
pub type SampleErrors = [Chunk<4>; 4];

/// `mean_k φ(e_k)` for a function `φ` of the errors `e = predicted − measured` of one sample in the channels
/// `[x, ẋ, P_f, P_e]` (mm, mm/s, kPa, kPa). Its cotangents are exact, by dual numbers.
///
/// ```
/// use num_dual::DualNum;
/// use crate::loss::{SampleErrors, pointwise};
///
/// // A logarithm of hyperbolic cosine for the displacement, little weight for the rest.
/// let loss = pointwise(|[x, v, pf, pe]: SampleErrors| {
///     x.cosh().ln() + (v * v + pf * pf + pe * pe) * 1e-3
/// });
/// # let _: &dyn crate::TrajectoryLoss = &loss;
/// ```
pub fn pointwise<F>(function: F) -> Pointwise<F>
where
    F: Fn(SampleErrors) -> Chunk<4> + Sync,
{
    Pointwise { function }
}

/// See [`pointwise`].
#[derive(Debug, Clone, Copy)]
pub struct Pointwise<F> {
    function: F,
}

impl<F> TrajectoryLoss for Pointwise<F>
where
    F: Fn(SampleErrors) -> Chunk<4> + Sync,
{
    fn value_and_cotangents(
        &self,
        measured: &Recording,
        predicted: &[[f64; 4]],
        cotangents: &mut [[f64; 4]],
    ) -> f64 {
        let scale = 1.0 / predicted.len().max(1) as f64;
        let channels = Channel::ALL.map(|c| measured.channel(c));
        let mut sum = 0.0;
        for (k, (p, w)) in predicted.iter().zip(cotangents).enumerate() {
            let errors = std::array::from_fn(|c| Chunk::variable(p[c] - channels[c][k], c));
            let value = (self.function)(errors);
            sum += value.value;
            *w = value.derivatives.map(|d| scale * d);
        }
        scale * sum
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{assert_cotangents, noisy, random_recording};
    use super::super::{SquaredError, TrajectoryLoss};
    use super::*;
    use num_dual::DualNum;

    #[test]
    fn cotangents_are_the_derivative() {
        assert_cotangents(&pointwise(|[x, v, pf, pe]| x.cosh().ln() + v * v + (pf * pe).tanh()), 8);
    }

    #[test]
    fn squares_are_the_squared_error() {
        let weights = [3.0, 2.0, 1.0, 0.5];
        let own = pointwise(move |e: SampleErrors| {
            let terms = e.iter().zip(weights).map(|(e, w)| *e * *e * w);
            terms.reduce(|a, b| a + b).expect("four channels")
        });
        let measured = random_recording(17, 1);
        let predicted = noisy(&measured, 2);
        let (mut a, mut b) = ([[0.0; 4]; 17], [[0.0; 4]; 17]);
        let value = own.value_and_cotangents(&measured, &predicted, &mut a);
        let known = SquaredError { weights };
        let expected = known.value_and_cotangents(&measured, &predicted, &mut b);
        assert!((value - expected).abs() < 1e-12 * expected);
        for (a, b) in a.as_flattened().iter().zip(b.as_flattened()) {
            assert!((a - b).abs() < 1e-12 * b.abs().max(1e-3));
        }
    }
}
