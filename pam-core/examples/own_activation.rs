//! An activation of one's own: Mish, `z tanh(ln(1 + eᶻ))` (D. Misra, *Mish: A Self Regularized
//! Non-Monotonic Activation Function*, 2019).
//!
//! The type below is all that a network needs. With `NamedActivation` it has a name in every command of a program of one's
//! own (`templates/own-pam`). To ship it, put it into
//! `pam-core/src/activation/mish.rs` and add two lines to `mod.rs` there: `mod mish;` and
//! `"mish" => Mish(mish::Mish),`.

use num_dual::Dual64;
use pam_core::activation::Tanh;
use pam_core::force::Dense;
use pam_core::{ActivationFunction, ForceInput, ForceModel, Mlp, ModelError, NetworkForce, Scalar};
use serde::{Deserialize, Serialize};

/// `z tanh(ln(1 + eᶻ))`.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Mish;

impl ActivationFunction for Mish {
    fn value<S: Scalar>(&self, z: S) -> S {
        // Far out the derivative of `DualNum::tanh` is NaN; that of `Tanh` is 0.
        z * Tanh.value(z.softplus())
    }
}

fn main() -> Result<(), ModelError> {
    // Values of the definition.
    assert!((Mish.value(1.0_f64) - 0.865_098_388_267).abs() < 1e-10);
    assert_eq!(Mish.value(0.0_f64), 0.0);

    // Slopes come by themselves, one by one and over batches.
    let h = 1e-5;
    for z in [-3.0, -0.3, 0.0, 1.7] {
        let slope = Mish.value(Dual64::new(z, 1.0)).eps;
        assert!((slope - (Mish.value(z + h) - Mish.value(z - h)) / (2.0 * h)).abs() < 1e-9);
        let (mut values, mut slopes) = ([z; 5], [0.0; 5]);
        Mish.apply_to_batch_with_slopes(&mut values, &mut slopes);
        assert!((slopes[4] - slope).abs() < 1e-12);
    }

    // A learned force with it: inputs (m_f, m_e, x, ẋ), one hidden layer of three, a force in mN.
    let hidden = Dense::from_rows(
        &[0.1, 0.2, 1.0, 0.01, -0.3, 0.1, 0.5, 0.02, 0.0, 0.4, -1.0, 0.0],
        vec![0.0, 0.1, -0.1],
    )?;
    let out = Dense::from_rows(&[8e4, 4e4, -6e4], vec![0.0])?;
    let force = NetworkForce::new(Mlp::new(vec![hidden, out], Mish)?)?;
    let mut work = vec![Dual64::from(0.0); force.mlp().work_len()];
    let at = ForceInput {
        displacement_mm: Dual64::new(0.5, 1.0), // the derivative is by x
        velocity_mm_s: 0.0.into(),
        mass_flexor_g: 0.07.into(),
        mass_extensor_g: 0.07.into(),
    };
    let f = force.map(Dual64::constant).restoring_force_mn(&at, &mut work);
    println!("f = {:.3} N, K = {:.3} N/mm", f.re / 1e3, f.eps / 1e3);
    assert!(f.eps > 0.0);
    Ok(())
}
