//! Where a name is rejected.
//!
//! | rule | file |
//! |---|---|
//! | its intervals hold that it is absent | [`absent`] |
//! | it has another value in each part of the data, so it only mimics another cause | [`stability`] |
//! | it explains no more than the best candidate explains by chance | [`null_test`] |
//!
//! A value that changes with time, or differs between recordings, is no reason to reject a name; it is reported ([`stability_test`]).
//!
//! Two further rules act during the search: a set whose values are no longer what the name says
//! ([`Candidates::stands`](crate::search::Candidates::stands)) is not followed, and a scale at the limit of its range
//! costs as much as a further cause.

pub mod absent;
pub mod null_test;
pub mod stability;
pub mod stability_test;

pub(crate) use absent::{OF_INTERVALS, is_absent_where_off, may_be_absent, vague};
pub use null_test::NullTest;
pub use stability::ParameterStability;
pub(crate) use stability_test::correlation;
pub use stability_test::{ChangeInTime, DifferenceBetween, StabilityTest};
