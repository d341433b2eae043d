//! Derivatives against closed forms, differences and each other.

mod agreement;
/// Batched networks and fields against the generic ones.
mod batch {
    mod network;
    mod sealed_motion;
}
mod elementary;
mod field;
mod finite_difference;
mod stiffness;
mod support;
mod tape;
