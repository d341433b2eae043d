//! From a learned joint model to commands and back.
//!
//! - [`motion`]: desired motions and stiffnesses;
//! - [`synthesis`]: the air masses and pressures that give them, exactly and fast;
//! - [`export`]: plans and networks for controllers;
//! - [`execution`]: plans carried out on a joint, with and without perturbations;
//! - [`identification`]: stiffness and damping from the response to a pulse;
//! - [`stiffness`]: maps of stiffness and damping, reachable ranges;
//! - [`mpc`]: receding-horizon MPC over the model with valves and flows;
//! - [`experiments`]: the published tests; [`report`]: what commands show;
//! - [`equilibrium_point`]: the classical model, for comparison.
//!
//! ```
//! use pam_control::motion::{MotionSpec, StiffnessProfile};
//! use pam_control::synthesis::{self, MassBounds, Plan, SynthesisSettings};
//! use pam_core::{AnyForce, JointModel, SpringDamper};
//!
//! let mut spring = SpringDamper::<f64>::published();
//! spring.shift_per_mass_mm_g = 30.0; // mm for each gram that the flexor holds more
//! let model = JointModel::datasheet(AnyForce::SpringDamper(spring));
//! let motion = MotionSpec::parse("sine:A=0.5,f=0.5")?;
//! let stiffness = StiffnessProfile::parse("150")?;
//! let targets = synthesis::plan::targets(&motion, Some(&stiffness), 0.0, 100.0)?;
//! let settings = SynthesisSettings::published(MassBounds::trained(&model));
//! let summary = Plan::new(&model, targets, settings)?.summary();
//! assert_eq!(summary.nearest_stiffness, 0);
//! assert!(summary.largest_residual_mn <= 1e-3);
//! # Ok::<(), pam_control::ControlError>(())
//! ```

pub mod equilibrium_point;
pub mod error;
pub mod execution;
pub mod experiments;
pub mod export;
pub mod identification;
pub mod motion;
pub mod mpc;
pub mod report;
pub mod stiffness;
pub mod synthesis;

pub use error::ControlError;
