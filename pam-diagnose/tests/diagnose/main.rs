//! The parts of the diagnosis against equations written out here, and against themselves (threads).

#[path = "../../../pam-effects/tests/effects/support/mod.rs"]
#[allow(dead_code)]
mod support;

mod biases;
mod coverage;
mod settings;
mod threads;
