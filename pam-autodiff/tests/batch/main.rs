//! Batched networks and fields against the generic ones.

mod network;
mod sealed_motion;
