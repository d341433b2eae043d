//! Fits of effects through the simulation, by Gauss–Newton with the exact sensitivities of the steps
//! taken.
//!
//! A [`Problem`] is a set of trials with the rows that count; [`Hypothesis`] is what is fitted: effects
//! with their values, and what the recordings leave uncertain (the model's own numbers, when the
//! force acted between its samples, initial states, sealed masses, offsets of the first pressure readings),
//! each tied to its measured value by a tolerance. [`Problem::fit`] moves a hypothesis to its best fit,
//! [`Problem::intervals`] says how sure its numbers are.

mod covariance;
mod hypothesis;
mod likelihood;
mod linearise;
mod normal;
mod problem;
mod refit;
mod solve;

pub use covariance::Interval;
pub(crate) use hypothesis::coordinate;
pub use hypothesis::{Common, Hypothesis, Local};
pub(crate) use likelihood::deviance;
pub use likelihood::{CHANNELS, ChannelErrors, Floors};
pub(crate) use linearise::Sensitivities;
pub(crate) use problem::{BLOCK_S, POINTS_PER_ROW};
pub use problem::{Problem, Tolerances};
pub(crate) use refit::BURN_IN_S;
pub use refit::refit;
pub use solve::Fit;
