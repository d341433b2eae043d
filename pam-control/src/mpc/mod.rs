//! Receding-horizon model predictive control (MPC) over the learned model.
//!
//! Every millisecond the controller
//!
//! 1. estimates the state and the force that the model does not explain ([`observer`]);
//! 2. linearises the model along the trajectory that it predicted last, with exact derivatives, and
//!    discretises it; the air masses are states now, driven by the valves' flows ([`horizon`], [`flow`]);
//! 3. solves the quadratic program of the horizon from the last solution ([`box_qp`]): one step of
//!    sequential quadratic programming per sample (Diehl, Bock and Schlöder 2005);
//! 4. turns the first flows into openings of the on/off valves ([`modulator`]).
//!
//! [`MpcController`] joins them, [`run_mpc`] closes the loop over a [`Joint`](crate::execution::Joint).

pub mod box_qp;
mod controller;
pub mod flow;
pub mod horizon;
pub mod modulator;
pub mod observer;

pub use controller::{MpcController, MpcRun, MpcSettings, MpcTask, run_mpc};
pub use flow::ValveModel;
pub use horizon::{Horizon, HorizonSettings, Reference};
