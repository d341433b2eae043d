//! Stiffness and damping of a model over its four inputs.
//!
//! [`map`] evaluates the exact slopes and the finite-difference schemes over a grid of
//! (x, ẋ, m_f, m_e); [`profile`] along x for one pair of masses, fine enough to show kinks; [`reachable`]
//! the range of K̂ that the consistent masses span at each position. [`ExactMap`] is the plane of motion cut
//! into the polygons in which stiffness and damping are constant, for (leaky) ReLU networks.

use crate::error::ControlError;
use crate::synthesis::{SynthesisSettings, Synthesiser, Target};
use num_dual::Dual64;
use pam_autodiff::{
    Central, DifferenceScheme, Forward, FourPointSmoothed, Richardson, linearise,
    stiffness_by_difference_n_mm,
};
use pam_core::parallel;
use pam_core::{AnyForce, ForceInput, JointModel, Scalar, SealedMasses};
use serde::Serialize;

mod polygons;

pub use polygons::ExactMap;

/// Stiffness at a point by every scheme.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StiffnessPoint {
    /// Displacement, mm.
    pub displacement_mm: f64,
    /// Velocity, mm/s.
    pub velocity_mm_s: f64,
    /// Air in the flexor, g.
    pub mass_flexor_g: f64,
    /// Air in the extensor, g.
    pub mass_extensor_g: f64,
    /// Restoring force, N.
    pub force_n: f64,
    /// Exact ∂f/∂x, N/mm.
    pub exact_n_mm: f64,
    /// Exact ∂f/∂ẋ, kg/s.
    pub damping_kg_s: f64,
    /// `[f(x+h) − f(x)] / h`, N/mm.
    pub forward_n_mm: f64,
    /// `[f(x+h) − f(x−h)] / 2h`, N/mm.
    pub central_n_mm: f64,
    /// The published estimate K̂, N/mm.
    pub four_point_n_mm: f64,
    /// Richardson's extrapolation of central differences, N/mm.
    pub richardson_n_mm: f64,
}

/// A grid of points; every combination is evaluated.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Grid {
    /// Displacements, mm.
    pub displacements_mm: Vec<f64>,
    /// Velocities, mm/s.
    pub velocities_mm_s: Vec<f64>,
    /// Air in flexor and extensor, g.
    pub masses: Vec<SealedMasses>,
}

/// Stiffness and damping over a grid, displacements fastest, then velocities.
#[must_use]
pub fn map(
    model: &JointModel<f64, AnyForce<f64>>,
    grid: &Grid,
    step_mm: f64,
) -> Vec<StiffnessPoint> {
    let dual = model.force.map(Dual64::constant);
    let points = parallel::map_each(grid.masses.iter().collect(), |masses: &SealedMasses| {
        let mut points =
            Vec::with_capacity(grid.velocities_mm_s.len() * grid.displacements_mm.len());
        for &v in &grid.velocities_mm_s {
            let at = |&x: &f64| point(model, &dual, x, v, *masses, step_mm);
            points.extend(grid.displacements_mm.iter().map(at));
        }
        points
    });
    points.into_iter().flatten().collect()
}

fn point(
    model: &JointModel<f64, AnyForce<f64>>,
    dual: &AnyForce<Dual64>,
    displacement_mm: f64,
    velocity_mm_s: f64,
    masses: SealedMasses,
    h: f64,
) -> StiffnessPoint {
    let at = ForceInput {
        displacement_mm,
        velocity_mm_s,
        mass_flexor_g: masses.flexor_g,
        mass_extensor_g: masses.extensor_g,
    };
    let exact = linearise(dual, &at);
    let by =
        |scheme: &dyn DifferenceScheme| stiffness_by_difference_n_mm(&model.force, &at, scheme);
    StiffnessPoint {
        displacement_mm,
        velocity_mm_s,
        mass_flexor_g: masses.flexor_g,
        mass_extensor_g: masses.extensor_g,
        force_n: exact.force_mn / pam_core::units::MN_PER_N,
        exact_n_mm: exact.stiffness_n_mm,
        damping_kg_s: exact.damping_kg_s,
        forward_n_mm: by(&Forward { h }),
        central_n_mm: by(&Central { h }),
        four_point_n_mm: by(&FourPointSmoothed { h }),
        richardson_n_mm: by(&Richardson { h, levels: 2 }),
    }
}

/// Points along x for one pair of masses.
#[must_use]
pub fn profile(
    model: &JointModel<f64, AnyForce<f64>>,
    masses: SealedMasses,
    velocity_mm_s: f64,
    [from_mm, to_mm]: [f64; 2],
    points: usize,
    step_mm: f64,
) -> Vec<StiffnessPoint> {
    let last = points.saturating_sub(1).max(1) as f64;
    let displacements_mm =
        (0..points).map(|k| from_mm + (to_mm - from_mm) * k as f64 / last).collect();
    let grid =
        Grid { displacements_mm, velocities_mm_s: vec![velocity_mm_s], masses: vec![masses] };
    map(model, &grid, step_mm)
}

/// The stiffness that can be had at a position.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Reachable {
    /// Displacement, mm.
    pub displacement_mm: f64,
    /// Velocity, mm/s.
    pub velocity_mm_s: f64,
    /// Least and largest K̂ of unaccelerated motion there, N/mm; none if no masses hold it.
    pub stiffness_n_mm: Option<[f64; 2]>,
}

/// The reachable range at every pair of displacement and velocity.
///
/// # Errors
/// [`ControlError::Value`] for impossible settings or numbers that are not finite.
pub fn reachable(
    model: &JointModel<f64, AnyForce<f64>>,
    displacements_mm: &[f64],
    velocities_mm_s: &[f64],
    settings: SynthesisSettings,
) -> Result<Vec<Reachable>, ControlError> {
    let synthesiser = Synthesiser::new(model, settings)?;
    for v in displacements_mm.iter().chain(velocities_mm_s) {
        ControlError::require_finite("displacement (mm) or velocity (mm/s)", *v)?;
    }
    let pairs: Vec<[f64; 2]> = velocities_mm_s
        .iter()
        .flat_map(|&v| displacements_mm.iter().map(move |&x| [x, v]))
        .collect();
    Ok(parallel::map_each(pairs, |[displacement_mm, velocity_mm_s]| {
        let target = Target {
            time_s: 0.0,
            displacement_mm,
            velocity_mm_s,
            acceleration_mm_s2: 0.0,
            stiffness_n_mm: 1.0,
            load_mn: 0.0,
        };
        let stiffness_n_mm = synthesiser.reachable_n_mm(&target);
        Reachable { displacement_mm, velocity_mm_s, stiffness_n_mm }
    }))
}
