//! The whole diagnosis of any system, in the order in which it happens, and its result.
//!
//! Preparing the data and their roles is the part of the system: [`joint::diagnose`](crate::joint::diagnose) and
//! [`field::diagnose_field`](crate::field::diagnose_field) do it and call [`run`], which takes any
//! [`Candidates`](crate::search::Candidates).

mod baseline;
mod result;
mod run;

pub(crate) use baseline::Baseline;
pub use result::{Diagnosis, Explainable, SetScore, Stage};
pub(crate) use run::total;
pub use run::{Prepared, run};
