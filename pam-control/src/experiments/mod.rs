//! The published tests of the commands, on any joint.
//!
//! - [`tracking`]: sine and triangle over amplitudes, frequencies and stiffnesses;
//! - [`stiffness`]: the staircase at rest, and the cycle of stiffnesses on a moving joint;
//! - [`comparison`]: the learned model's commands beside the equilibrium-point model's.
//!
//! Each takes a function that makes a fresh joint for a seed, filled to the first pressures of its
//! commands, so that tests can run side by side.

pub mod comparison;
pub mod stiffness;
pub mod tracking;

use crate::execution::Joint;

/// Makes a joint for a seed whose muscles hold these pressures (kPa absolute).
pub type MakeJoint<'a> = &'a (dyn Fn(u64, [f64; 2]) -> Box<dyn Joint> + Sync);

/// How long a joint is held at the first commands before a test begins, s.
pub const SETTLE_S: f64 = 4.0;
