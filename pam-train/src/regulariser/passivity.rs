//! Lower limits of damping and stiffness.

use super::Regulariser;
use pam_autodiff::batch::BatchNetwork;
use pam_core::settings::{SettingsError, require, require_weights};
use pam_trajectory::engine::NetworkJoint;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use serde::{Deserialize, Serialize};

/// Ranges `[lowest, highest]` of the inputs of a force.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OperatingBox {
    /// Air mass of the flexor, g.
    pub mass_flexor_g: [f64; 2],
    /// Air mass of the extensor, g.
    pub mass_extensor_g: [f64; 2],
    /// Displacement x, mm.
    pub displacement_mm: [f64; 2],
    /// Velocity ẋ, mm/s.
    pub velocity_mm_s: [f64; 2],
}

impl OperatingBox {
    /// The ranges in the order of a network's inputs, `(m_f, m_e, x, ẋ)`.
    fn ranges(&self) -> [[f64; 2]; 4] {
        [self.mass_flexor_g, self.mass_extensor_g, self.displacement_mm, self.velocity_mm_s]
    }
}

/// A floor under one slope of the force.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SlopeFloor {
    /// Factor of the mean square below the floor, in the inverse square of the slope's unit; not
    /// negative.
    pub strength: f64,
    /// The floor, kg/s for damping and N/m (kg/s²) for stiffness; zero by default. A floor of `−B`
    /// under damping asks that the force and the auxiliary damping B together dissipate.
    #[serde(default)]
    pub floor: f64,
    /// Half the distance d of the difference quotient, mm/s for damping and mm for stiffness.
    pub half_width: f64,
}

/// Penalises slopes of the learned force below a floor, over points of a box:
///
/// ```text
/// strength · mean_k max(0, floor − q_k)²,   q_k = (f(z_k + d e) − f(z_k − d e)) / 2d
/// ```
///
/// with `e` the direction of ẋ (damping `∂f/∂ẋ`, without which the motion gains energy from nowhere)
/// or of x (stiffness `∂f/∂x`, without which the joint has no stable rest). 1 mN·s/mm is 1 kg/s and
/// 1 mN/mm is 1 N/m. Difference quotients stand for the slopes because they need no second derivative
/// of the network and see through the kinks of ReLU units.
///
/// Points are drawn uniformly from the box by the seed and are the same in every call; those of a
/// quotient may lie `d` outside.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Passivity {
    /// The box that points lie in.
    pub within: OperatingBox,
    /// Number of points.
    #[serde(default = "points")]
    pub points: usize,
    /// Seed of the points.
    #[serde(default)]
    pub seed: u64,
    /// Floor under the damping, if any.
    #[serde(default)]
    pub damping: Option<SlopeFloor>,
    /// Floor under the stiffness, if any.
    #[serde(default)]
    pub stiffness: Option<SlopeFloor>,
}

fn points() -> usize {
    512
}

/// Places of x and ẋ among the inputs.
const DISPLACEMENT: usize = 2;
const VELOCITY: usize = 3;

/// Quotients of one pass through the network.
const CHUNK: usize = 128;

impl Passivity {
    /// Checks ranges, number of points, strengths and half widths.
    ///
    /// # Errors
    /// [`SettingsError`] naming what is out of range.
    pub fn check(&self) -> Result<(), SettingsError> {
        require(self.points > 0, || "passivity needs at least one point".into())?;
        for range in self.within.ranges() {
            require(range.iter().all(|r| r.is_finite()) && range[0] <= range[1], || {
                format!("a range of passivity must go from low to high, got {range:?}")
            })?;
        }
        for own in self.damping.iter().chain(&self.stiffness) {
            require_weights("passivity", &[own.strength])?;
            require(own.half_width.is_finite() && own.half_width > 0.0, || {
                format!("half_width must be positive and finite, got {}", own.half_width)
            })?;
            require(own.floor.is_finite(), || format!("floor must be finite, got {}", own.floor))?;
        }
        Ok(())
    }

    /// The points `(m_f, m_e, x, ẋ)` at which slopes are looked at (g, g, mm, mm/s).
    #[must_use]
    pub fn sample(&self) -> Vec<[f64; 4]> {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let ranges = self.within.ranges();
        (0..self.points)
            .map(|_| ranges.map(|[low, high]| low + (high - low) * random.random::<f64>()))
            .collect()
    }
}

/// Penalty of one floor along input `axis`; adds its gradient.
fn penalty(
    network: &BatchNetwork<f64>,
    points: &[[f64; 4]],
    axis: usize,
    own: &SlopeFloor,
    gradient: &mut [f64],
) -> f64 {
    let (stride, out_stride) = (network.input_stride(), network.output_stride());
    let bias = network.fold(&[]);
    let rows = 2 * CHUNK.min(points.len());
    let mut block = network.block(rows);
    let mut sums = network.sums(rows);
    let mut input = vec![0.0; rows * stride];
    let mut out = vec![0.0; rows * out_stride];
    let mut cotangent = vec![0.0; rows];
    let mut input_cotangent = vec![0.0; rows * network.inputs()];
    let ones = vec![1.0; rows];
    let scale = own.strength / points.len() as f64;
    let per_force = 0.5 / own.half_width;
    let mut value = 0.0;
    for part in points.chunks(CHUNK) {
        let n = 2 * part.len();
        for (pair, point) in input.chunks_exact_mut(2 * stride).zip(part) {
            let (above, below) = pair.split_at_mut(stride);
            above[..4].copy_from_slice(point);
            below[..4].copy_from_slice(point);
            above[axis] += own.half_width;
            below[axis] -= own.half_width;
        }
        network.forward_into(n, &bias, &input, &mut out, &[], &mut block);
        let mut any = false;
        for (c, f) in cotangent[..n].chunks_exact_mut(2).zip(out.chunks_exact(2 * out_stride)) {
            let lack = (own.floor - per_force * (f[0] - f[out_stride])).max(0.0);
            value += scale * lack * lack;
            // ∂(lack²)/∂f = ∓2 lack/2d above and below.
            c[0] = -2.0 * scale * lack * per_force;
            c[1] = -c[0];
            any |= lack > 0.0;
        }
        if !any {
            continue;
        }
        let cotangent = &cotangent[..n];
        network.pull_back(n, cotangent, &mut input_cotangent, &[], &mut block);
        network.accumulate(n, &ones[..n], &input, cotangent, &[], &mut sums, &mut block);
        network.drain_into(&mut sums, &[], gradient, &mut []);
    }
    value
}

impl Regulariser for Passivity {
    fn value_and_gradient(&self, model: &NetworkJoint, weights_gradient: &mut [f64]) -> f64 {
        let network = BatchNetwork::<f64>::new(model.force.mlp(), 0);
        assert_eq!(weights_gradient.len(), network.parameter_len());
        let points = self.sample();
        [(VELOCITY, &self.damping), (DISPLACEMENT, &self.stiffness)]
            .into_iter()
            .filter_map(|(axis, own)| own.as_ref().map(|own| (axis, own)))
            .map(|(axis, own)| penalty(&network, &points, axis, own, weights_gradient))
            .sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_fill_the_box_and_follow_the_seed() {
        let within = OperatingBox {
            mass_flexor_g: [0.2, 1.0],
            mass_extensor_g: [-1.0, 0.5],
            displacement_mm: [-3.0, 3.0],
            velocity_mm_s: [-2.0, 2.0],
        };
        let damping = Some(SlopeFloor { strength: 2.0, floor: 0.0, half_width: 0.25 });
        let p = Passivity { within, points: 300, seed: 4, damping, stiffness: None };
        let points = p.sample();
        assert_eq!(points, p.sample());
        assert_ne!(points, Passivity { seed: 5, ..p }.sample());
        for (i, [low, high]) in p.within.ranges().into_iter().enumerate() {
            let column = || points.iter().map(|z| z[i]);
            assert!(column().all(|z| (low..=high).contains(&z)));
            let mean = column().sum::<f64>() / points.len() as f64;
            assert!((mean - 0.5 * (low + high)).abs() < 0.1 * (high - low));
        }
    }
}
