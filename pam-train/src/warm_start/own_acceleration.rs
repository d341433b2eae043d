//! The part of the acceleration that is no function of the force's inputs.
//!
//! In `F = m ẍ + f(x, ẋ, m_f, m_e)` with a free function f only that part of ẍ says something of m that
//! is no function of f's inputs. Steady sines leave little: on one ellipse of frequency ω, `ẍ = −ω² x`.
//! The regression of a partially linear model (Robinson 1988) makes this exact:
//!
//! ```text
//! e = ẍ − E[ẍ | x, ẋ, m_f, m_e],   r = F − m ẍ − f,   δ = Σ e r / Σ e²
//! ```
//!
//! Here the expectation is fitted by a network of f's own shape. Because e is orthogonal to what f can
//! become, errors of f enter the correction δ of m in second order only (Chernozhukov et al. 2018),
//! where a joint fit of m and f leaves to f whatever part of the inertia it got hold of first.

use super::derivative_matching::{DerivativeMatching, Point};
use crate::coordinates::{Coordinates, Frozen};
use pam_core::{SealedMasses, parallel};
use pam_surrogate::PointForces;
use pam_trajectory::engine::NetworkJoint;

/// e (mm/s²) and r (mN) of one point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Own {
    /// The acceleration beyond its expectation.
    pub acceleration: f64,
    /// The force that is left.
    pub residual_mn: f64,
}

/// e and r of points, with the mass and force that stand at `at`. The network of the expectation is
/// trained from that force on, by `matching`'s batches and rate.
#[must_use]
pub fn own_accelerations(
    matching: &DerivativeMatching,
    coordinates: &Coordinates,
    at: &[f64],
    points: &[Point],
    seed: u64,
) -> Vec<Own> {
    let model = coordinates.model(at);
    let square = |f: fn(&Point) -> f64| points.iter().map(|p| f(p) * f(p)).sum::<f64>();
    // The regression of the acceleration is that of a force without inertia, of the same size.
    let accelerations = square(|p| p.acceleration).max(f64::MIN_POSITIVE);
    let unit = (square(|p| p.force_mn).max(f64::MIN_POSITIVE) / accelerations).sqrt();
    let still = |p: &Point| Point { acceleration: 0.0, force_mn: unit * p.acceleration, ..*p };
    let mut undamped = coordinates.with_frozen(Frozen {
        network: false,
        mass: true,
        gas_coefficient: true,
        deformation: true,
        effects: true,
    });
    undamped.set_auxiliary_damping(0.0);
    let targets = points.iter().map(still).collect();
    let expected = undamped.model(&matching.regress(&undamped, at, targets, seed).at);

    let mass = model.physical().mass_kg;
    let damping = coordinates.auxiliary_damping_kg_s();
    let forces = forces_mn(&expected, points).into_iter().zip(forces_mn(&model, points));
    let own = |(p, (expected_mn, force_mn)): (&Point, (f64, f64))| Own {
        acceleration: p.acceleration - expected_mn / unit,
        residual_mn: p.force_mn - mass * p.acceleration - damping * p.input[3] - force_mn,
    };
    points.iter().zip(forces).map(own).collect()
}

/// The model's force at points, mN; neighbouring points with the same masses are evaluated together.
fn forces_mn(model: &NetworkJoint, points: &[Point]) -> Vec<f64> {
    let forces = PointForces::new(&model.force);
    let recordings: Vec<&[Point]> = points.chunk_by(|a, b| a.input[..2] == b.input[..2]).collect();
    let of_recording = |k: usize| {
        let [flexor_g, extensor_g, ..] = recordings[k][0].input;
        let states: Vec<[f64; 2]> =
            recordings[k].iter().map(|p| [p.input[2], p.input[3]]).collect();
        let mut values = vec![0.0; states.len()];
        let masses = SealedMasses { flexor_g, extensor_g };
        forces.values_into(masses, &states, &mut values, &mut forces.memory());
        values
    };
    parallel::map(recordings.len(), of_recording).concat()
}

/// δ, kg.
#[must_use]
pub fn mass_correction_kg(own: &[Own]) -> f64 {
    let (product, square) = own.iter().fold((0.0, 0.0), |s, o| {
        (s.0 + o.acceleration * o.residual_mn, s.1 + o.acceleration * o.acceleration)
    });
    if square > 0.0 { product / square } else { 0.0 }
}
