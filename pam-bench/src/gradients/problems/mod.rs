//! The problems, one file each.
//!
//! - [`linear`]: a damped oscillation, as a baseline;
//! - [`van_der_pol`]: a nonlinear oscillation;
//! - [`quartic`]: `u̇ = (t − θ)⁴`, whose steps suit the state and not the gradient;
//! - [`stiff`]: a slow state with a fast one, where nothing may be integrated back;
//! - [`joint`]: the hybrid model of the joint with a network of any activation and width, made by
//!   [`network`] without any data.

pub mod joint;
pub mod linear;
pub mod network;
pub mod quartic;
pub mod stiff;
pub mod van_der_pol;
