//! Stiffness and damping of a force model at one operating point.
//!
//! With the restoring-force convention both are positive for a stable joint:
//! `K = ∂f/∂x` (N/mm, after division by 1000 mN/N) and `B = ∂f/∂ẋ` (kg/s = mN·s/mm).

use crate::finite_difference::DifferenceScheme;
use num_dual::Dual64;
use pam_core::units::MN_PER_N;
use pam_core::{ForceInput, ForceModel, Scalar, scalar};

/// A force with its two slopes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearForce {
    /// The restoring force, mN.
    pub force_mn: f64,
    /// Stiffness K = ∂f/∂x, N/mm.
    pub stiffness_n_mm: f64,
    /// Damping B = ∂f/∂ẋ, kg/s.
    pub damping_kg_s: f64,
}

/// Force, exact stiffness and exact damping at one point, by two dual evaluations. `force` is the
/// model with dual numbers, for example `model.force.map(Dual64::constant)`.
///
/// ```
/// use num_dual::Dual64;
/// use pam_autodiff::linearise;
/// use pam_core::{ForceInput, Scalar, SpringDamper};
///
/// let spring = SpringDamper::<f64>::published();
/// let at = ForceInput { displacement_mm: 0.0, velocity_mm_s: 0.0, mass_flexor_g: 0.08, mass_extensor_g: 0.08 };
/// let slope = linearise(&spring.map(Dual64::constant), &at);
/// assert!(slope.stiffness_n_mm > 100.0 && slope.damping_kg_s > 0.0);
/// ```
pub fn linearise<F: ForceModel<Dual64>>(force: &F, at: &ForceInput<f64>) -> LinearForce {
    let mut work = scalar::zeros(force.work_len());
    let mut point = at.lift::<Dual64>();
    point.displacement_mm.eps = 1.0;
    let along_x = force.restoring_force_mn(&point, &mut work);
    point.displacement_mm.eps = 0.0;
    point.velocity_mm_s.eps = 1.0;
    let along_v = force.restoring_force_mn(&point, &mut work);
    LinearForce {
        force_mn: along_x.real(),
        stiffness_n_mm: along_x.eps / MN_PER_N,
        damping_kg_s: along_v.eps,
    }
}

/// Exact stiffness `∂f/∂x`, N/mm. See [`linearise`].
pub fn stiffness_exact_n_mm<F: ForceModel<Dual64>>(force: &F, at: &ForceInput<f64>) -> f64 {
    linearise(force, at).stiffness_n_mm
}

/// Exact damping `∂f/∂ẋ`, kg/s. See [`linearise`].
pub fn damping_exact_kg_s<F: ForceModel<Dual64>>(force: &F, at: &ForceInput<f64>) -> f64 {
    linearise(force, at).damping_kg_s
}

/// Stiffness `∂f/∂x` by a finite-difference scheme in x, N/mm.
pub fn stiffness_by_difference_n_mm<F: ForceModel<f64>>(
    force: &F,
    at: &ForceInput<f64>,
    scheme: &dyn DifferenceScheme,
) -> f64 {
    let mut work = scalar::zeros(force.work_len());
    let mut along_x =
        |x: f64| force.restoring_force_mn(&ForceInput { displacement_mm: x, ..*at }, &mut work);
    scheme.derivative(&mut along_x, at.displacement_mm) / MN_PER_N
}
