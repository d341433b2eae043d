//! Where training starts from, without solving anything.
//!
//! Both physical parts of the model can be read off the data: the deformation coefficient from
//! pressures over displacements ([`gas`]), and mass and restoring force from accelerations
//! ([`derivative_matching`]). What comes out predicts whole recordings already; training through the
//! solver then removes what noise and smoothing did to the derivatives.

pub mod derivative_matching;
pub mod gas;
mod initial;
mod mass_correction;
pub mod own_acceleration;
mod squared_residuals;

pub use derivative_matching::{DerivativeMatching, Matched};
pub use gas::{FittedDeformation, fit_deformation};
pub(crate) use initial::random_network_len;
pub use initial::{Initialisation, random_network};
