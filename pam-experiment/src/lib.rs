//! Before, around and after a diagnosis of the joint.
//!
//! | module | question |
//! |---|---|
//! | [`plan`] | what would be measured under this protocol? |
//! | [`detect`] | which effects would a diagnosis find there, from which magnitude on, and which would it confuse? |
//! | [`design`] | which protocol finds more, or distinguishes the live causes? |
//! | [`standing`] | how did the standing of each candidate change from measurement to measurement? |
//! | [`certify`] | how often is a diagnosis right on this rig, and which settings hold the rate of false alarms? |
//!
//! Each question has a command (`pam detect`, `pam design`, `pam certify`), which is a thin layer over this crate.

pub mod certify;
pub mod design;
pub mod detect;
pub mod error;
pub mod plan;
pub mod standing;

pub use error::ExperimentError;
