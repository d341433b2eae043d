//! Stiffness, and how it changes: first and mixed second derivatives of a force at once.
//!
//! A hyper-dual number carries `f`, two first derivatives and their mixed second one (J. Fike and J. Alonso
//! 2011), without any step size. For a controller that moves stiffness with air, `∂K/∂m_f` is what counts.

use num_dual::HyperDual64;
use pam_autodiff::{Central, DifferenceScheme, linearise};
use pam_core::activation::Softplus;
use pam_core::{ForceInput, ForceModel, Mlp, NetworkForce, Scalar};
use pam_core::{ModelError, force::Dense};

fn network<S: Scalar>() -> Result<NetworkForce<S, Softplus>, ModelError> {
    let lift = |row: &[f64]| row.iter().map(|&v| S::constant(v)).collect::<Vec<_>>();
    let weights =
        [9.0, 2.0, 1.0, 0.02, 1.0, 8.0, -1.0, 0.01, 4.0, 4.0, 0.5, -0.01, -6.0, 3.0, 0.8, 0.0];
    let hidden = Dense::from_rows(&lift(&weights), lift(&[0.1, -0.2, 0.0, 0.3]))?;
    let out = Dense::from_rows(&lift(&[7e4, -9e4, 5e4, 3e4]), lift(&[0.0]))?;
    NetworkForce::new(Mlp::new(vec![hidden, out], Softplus)?)
}

fn main() -> Result<(), ModelError> {
    let at = ForceInput {
        displacement_mm: 0.4,
        velocity_mm_s: 3.0,
        mass_flexor_g: 0.06,
        mass_extensor_g: 0.09,
    };
    // ε₁ goes with x, ε₂ with m_f.
    let point = ForceInput {
        displacement_mm: HyperDual64::new(at.displacement_mm, 1.0, 0.0, 0.0),
        mass_flexor_g: HyperDual64::new(at.mass_flexor_g, 0.0, 1.0, 0.0),
        ..at.lift()
    };
    let force = network::<HyperDual64>()?;
    let f = force.restoring_force_mn(&point, &mut vec![HyperDual64::from(0.0); force.work_len()]);
    println!(
        "f = {:.3} N, K = {:.3} N/mm, dK/dm_f = {:.3} N/(mm g)",
        f.re / 1e3,
        f.eps1 / 1e3,
        f.eps1eps2 / 1e3
    );

    // K is what dual numbers give; its slope is what differences of exact stiffnesses approach.
    let dual = network::<num_dual::Dual64>()?;
    let stiffness =
        |mass_flexor_g: f64| linearise(&dual, &ForceInput { mass_flexor_g, ..at }).stiffness_n_mm;
    assert!((f.eps1 / 1e3 - stiffness(0.06)).abs() < 1e-12);
    let by_difference = Central { h: 1e-5 }.derivative(&mut |m| stiffness(m), 0.06);
    assert!((f.eps1eps2 / 1e3 - by_difference).abs() < 1e-5 * by_difference.abs());
    Ok(())
}
