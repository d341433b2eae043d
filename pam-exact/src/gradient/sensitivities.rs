//! Forward sensitivities: tangents by the propagators.
//!
//! Inside a region a tangent obeys `δ̈ + ζ δ̇ + κ δ = p(τ)`, where `p` is affine in time, in `x(τ)` and in
//! `ẋ(τ)`; its response has the same closed form as the moments of the costate. Crossings contribute
//! nothing, as for the costate.

use crate::network::pattern::slopes_into;
use crate::regions::cache::RegionCache;
use crate::step::propagator::ForcedResponses;
use crate::trajectory::stored::StoredTrajectory;
use crate::trajectory::{ExactMotion, ExactProblem};
use pam_solvers::TrajectoryFailure;

/// A direction in the space of all parameters of a motion.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ExactDirection {
    /// Of the network's parameters, in the order of [`ParametricForce`](pam_core::ParametricForce);
    /// empty for none.
    pub network: Vec<f64>,
    /// Of m, kg.
    pub mass_kg: f64,
    /// Of B, kg/s.
    pub damping_kg_s: f64,
    /// Of m_f and m_e, g.
    pub masses_g: [f64; 2],
    /// Of the initial displacement (mm) and velocity (mm/s).
    pub start: [f64; 2],
}

/// The derivatives of the observed states of `problem` along `directions`: for each direction
/// `[x, ẋ]` at every observation.
///
/// # Errors
/// [`TrajectoryFailure`] if the request is inconsistent or the solve stops early; its problem is 0.
///
/// # Panics
/// If a direction has network parameters, but not as many as the network.
pub fn forward_sensitivities(
    motion: &ExactMotion,
    problem: &ExactProblem<'_>,
    directions: &[ExactDirection],
) -> Result<Vec<Vec<[f64; 2]>>, TrajectoryFailure> {
    let stored = StoredTrajectory::new(motion, problem)?;
    Ok(directions.iter().map(|d| tangents(&stored, problem, d)).collect())
}

fn tangents(
    stored: &StoredTrajectory<'_>,
    problem: &ExactProblem<'_>,
    direction: &ExactDirection,
) -> Vec<[f64; 2]> {
    let regions = &stored.regions;
    let mass = regions.motion.mass_kg;
    let mut out = vec![direction.start; problem.observed_at_start()];
    let mut delta = direction.start;
    let mut known: Vec<Option<[f64; 3]>> = vec![None; regions.coefficients.len()];
    for (index, s) in stored.segments.iter().enumerate() {
        let coefficients = &regions.coefficients[s.region as usize];
        let oscillator = coefficients.oscillator;
        let forcing = &stored.forcing[s.forcing as usize];
        let by_force = *known[s.region as usize].get_or_insert_with(|| {
            affine_tangent(&regions.cache, s.region, problem.masses_g(), direction)
        });
        let w = [(s.force_mn - coefficients.offset_mn) / mass, forcing.rate_mn_s / mass];
        let step = coefficients.differentiable_step(s.length_s);
        let ForcedResponses { by_x, by_v } = step.forced_responses([s.x, s.v], w);
        // ẍ = w₀ + w₁ τ − κ x − ζ ẋ; a larger mass divides all of it.
        let heavier = direction.mass_kg / mass;
        let constant = -by_force[0] / mass - heavier * w[0];
        let ramp = -heavier * w[1];
        let along_x = -by_force[1] / mass + heavier * oscillator.kappa;
        let along_v = -(by_force[2] + direction.damping_kg_s) / mass + heavier * oscillator.zeta;
        let end = step.propagator.advance(oscillator.kappa, delta, [constant, ramp]);
        delta = [
            end[0] + along_x * by_x[0] + along_v * by_v[0],
            end[1] + along_x * by_x[1] + along_v * by_v[1],
        ];
        let ends = stored.segments.get(index + 1).is_none_or(|next| next.forcing != s.forcing);
        if ends && forcing.observed {
            out.push(delta);
        }
    }
    out
}

/// The tangent of a region's affine force `a + b x + c ẋ` along a direction of weights and masses.
fn affine_tangent(
    cache: &RegionCache<'_>,
    region: u32,
    masses_g: [f64; 2],
    direction: &ExactDirection,
) -> [f64; 3] {
    let network = cache.network;
    let mut slopes = vec![0.0; network.units()];
    slopes_into(cache.pattern(region), network.slope, &mut slopes);
    let table = cache.table(region);
    // The inputs as affine functions of x and ẋ, with their tangents.
    let mut inputs: Vec<[f64; 3]> =
        vec![[masses_g[0], 0.0, 0.0], [masses_g[1], 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let [m_f, m_e] = direction.masses_g;
    let mut tangents = vec![[m_f, 0.0, 0.0], [m_e, 0.0, 0.0], [0.0; 3], [0.0; 3]];
    let none = direction.network.is_empty();
    assert!(
        none || direction.network.len() == network.parameter_count(),
        "one number per parameter"
    );
    let mut rest = &direction.network[..];
    let mut take = |len: usize| {
        let (own, after) = rest.split_at(if none { 0 } else { len });
        rest = after;
        own
    };
    let mut start = 0;
    for layer in &network.hidden {
        let mut out = vec![[0.0; 3]; layer.outputs];
        let weights = take(layer.inputs * layer.outputs);
        for (i, (value, tangent)) in inputs.iter().zip(&tangents).enumerate() {
            for (j, out) in out.iter_mut().enumerate() {
                let w = layer.columns[i * layer.stride + j];
                let dw = if none { 0.0 } else { weights[i * layer.outputs + j] };
                for k in 0..3 {
                    out[k] += w * tangent[k] + dw * value[k];
                }
            }
        }
        for (out, db) in out.iter_mut().zip(take(layer.outputs)) {
            out[0] += db;
        }
        let value = |j: usize| table.unit(start + j).map(|z| slopes[start + j] * z);
        inputs = (0..layer.outputs).map(value).collect();
        tangents = out.iter().enumerate().map(|(j, t)| t.map(|t| slopes[start + j] * t)).collect();
        start += layer.stride;
    }
    let mut out = [0.0; 3];
    let weights = take(inputs.len());
    for (j, (value, tangent)) in inputs.iter().zip(&tangents).enumerate() {
        let dw = if none { 0.0 } else { weights[j] };
        for k in 0..3 {
            out[k] += network.output[j] * tangent[k] + dw * value[k];
        }
    }
    out[0] += take(1).first().copied().unwrap_or(0.0);
    out
}
