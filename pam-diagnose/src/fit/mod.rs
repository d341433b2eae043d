//! The fit of one hypothesis through the simulation, with exact sensitivities of the steps taken.
//!
//! A [`Problem`] is a set of experiments with the rows that count; a [`Hypothesis`] is what is fitted: candidates with
//! their values, and the nuisance values that the experiments leave uncertain, each with a Gaussian prior.
//! [`Problem::fit`] moves a hypothesis to its best fit by Levenberg–Marquardt, [`Problem::intervals`] computes the
//! confidence intervals of its parameters.

mod covariance;
mod hypothesis;
mod levenberg_marquardt;
mod likelihood;
mod normal;
mod problem;
mod unseen;

pub use covariance::Interval;
pub(crate) use covariance::{HALF_WIDTH, Influences, Responses};
#[cfg(feature = "joint")]
pub(crate) use hypothesis::FittedParameter;
pub use hypothesis::{Hypothesis, Member};
pub(crate) use hypothesis::{coordinate, is_magnitude};
pub use levenberg_marquardt::Fit;
pub use likelihood::ChannelErrors;
pub(crate) use pam_numerics::dot;
pub(crate) use problem::fitted_outputs;
#[cfg(feature = "joint")]
pub(crate) use problem::row_means;
pub use problem::{Problem, Sensitivities};
