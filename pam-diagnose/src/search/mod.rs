//! The search for the set of candidates that explains the residual, generic over the searched system
//! ([`Candidates`]).
//!
//! [`forward`](forward::search) fits every candidate alone and grows sets in a beam; `backward` drops members that are
//! not worth their place; `refit` fits the chosen set and its rivals to training and validation data, from several
//! starts. Every fitted set is a [`Scored`] hypothesis.

pub(crate) mod backward;
mod candidates;
mod extend;
mod forward;
pub(crate) mod refit;
mod scored;

pub use candidates::{CandidateInfo, Candidates, Nuisance, OutputInfo};
pub(crate) use extend::beside;
pub use forward::{Findings, search};
pub(crate) use scored::refit_without;
pub use scored::{Scored, fit_base};
