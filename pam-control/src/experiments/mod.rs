//! The published tests of the commands, on any joint.
//!
//! - [`tracking`]: sine and triangle over amplitudes, frequencies and stiffnesses;
//! - [`stiffness`]: the staircase at rest, and the cycle of stiffnesses on a moving joint;
//! - [`comparison`]: commands of the learned model against those of the equilibrium-point model.
//!
//! Each takes a function that makes a fresh joint for a seed, filled to the first pressures of its
//! commands, so that tests can run side by side.

pub mod comparison;
pub mod stiffness;
pub mod tracking;

use crate::execution::{Joint, ModelJoint};
use pam_core::{ForceModel, JointModel};
use std::sync::Arc;

/// Makes a joint for a seed whose muscles hold these pressures (kPa absolute).
pub type MakeJoint<'a> = &'a (dyn Fn(u64, [f64; 2]) -> Box<dyn Joint> + Sync);

/// Makes [the model itself](ModelJoint) as a joint; seeds do not matter.
pub fn on_model<F>(
    model: &JointModel<f64, F>,
) -> impl Fn(u64, [f64; 2]) -> Box<dyn Joint> + Sync + use<F>
where
    F: ForceModel<f64> + Clone + Send + Sync + 'static,
{
    let model = Arc::new(model.clone());
    move |_, pressures| Box::new(ModelJoint::new(Arc::clone(&model), pressures))
}

/// How long a joint is held at the first commands before a test begins, s.
pub const SETTLE_S: f64 = 4.0;
