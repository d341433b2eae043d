//! Derivatives against closed forms, differences and each other.

mod agreement;
mod elementary;
mod field;
mod finite_difference;
mod stiffness;
mod support;
mod tape;
