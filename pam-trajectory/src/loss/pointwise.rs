//! Custom losses whose derivatives are computed automatically.

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
/// use pam_trajectory::loss::{SampleErrors, pointwise};
///
/// // A logarithm of hyperbolic cosine for the displacement, little weight for the rest.
/// let loss = pointwise(|[x, v, pf, pe]: SampleErrors| {
///     x.cosh().ln() + (v * v + pf * pf + pe * pe) * 1e-3
/// });
/// # let _: &dyn pam_trajectory::TrajectoryLoss = &loss;
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
