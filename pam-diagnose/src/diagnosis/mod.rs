//! From recordings to a verdict.
//!
//! [`diagnose`] does what the command does: it keeps recordings aside, learns from healthy ones what is
//! ordinary, tells what is wrong, searches causes with a part of the others while the rest judges, fits the
//! names to all of them, weighs the verdict, and measures the gain on what it kept aside. Every part of it is
//! public and can be put together in another way.

mod cause;
mod gain;
mod json;
mod naming;
mod ordinary;
mod run;
mod sets;
mod trace;
mod verdict;

pub use cause::{Cause, Rank};
pub use gain::{ChannelGain, Gain, GroupGain, OverallGain};
pub use ordinary::Ordinary;
pub use run::{Diagnosis, Options, Stage, diagnose};
pub use sets::{HeldOut, JudgedBy, Sets};
pub use trace::Trace;
pub use verdict::Verdict;
pub(crate) use verdict::weigh;
