//! Whole-system tests: the program and the library on real and made-up data.
//!
//! They are one program, so that two cores always have a test to run: `cargo test --release --workspace --test system train::`.

mod ablate;
mod bad_input;
mod commands;
mod compare;
mod control;
mod detection;
mod diagnose;
mod experiment;
mod formats;
mod fuzz;
mod gradient;
mod hardening;
mod inspection;
mod laws;
mod loader;
mod measured_rig;
mod own_pam;
mod own_rig;
mod plant;
mod plausibility;
mod published_model;
mod real_run;
mod rig;
mod train;
