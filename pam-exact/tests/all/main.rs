//! Exact solutions, their gradients and regions against Runge–Kutta steps, differences and the networks themselves.

mod common;
mod events;
mod networks;
mod plane;
mod published;
