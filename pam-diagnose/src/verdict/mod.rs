//! Where the verdict falls: from the chosen set to names that stand.
//!
//! `naming` rejects names, `causes` describes the [`Cause`]s that are left, and `alternatives` the candidates that are not named;
//! `apparent` and `discrepancy` widen intervals by apparent values in baseline recordings and by model errors; `bands`, `anomalies` and
//! `stationary` examine the residual on the test data; `outcome` defines the rule of the [`Verdict`].

mod alternatives;
pub(crate) mod anomalies;
mod apparent;
pub(crate) mod bands;
mod cause;
mod causes;
mod discrepancy;
mod naming;
mod outcome;
mod stationary;

pub use anomalies::Anomaly;
#[cfg(feature = "joint")]
pub(crate) use apparent::Apparent;
pub use bands::ChannelBand;
pub(crate) use cause::ranking;
pub use cause::{Alternative, Cause, Rank, Refused};
pub(crate) use discrepancy::widen_by_unexplained;
pub(crate) use naming::{Names, Naming, STRAINED, largest_rise};
pub(crate) use outcome::share;
pub use outcome::{Verdict, VerdictInput};
pub(crate) use stationary::is_stationary;
