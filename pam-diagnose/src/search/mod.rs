//! The search for the set of candidates that explains the residual, generic over the searched system
//! ([`Candidates`]).
//!
//! [`search`] screens all candidates and all pairs to first order ([`linearised`](crate::linearised)), fits the most
//! promising sets, and then adds, exchanges and drops members until no change is worth it; each time the noise is learned
//! anew beside the set. `refit` fits the chosen set to training and validation data from several starts. Every fitted set
//! is a [`Scored`] hypothesis; sets are compared by their odds ([`Scored::log_odds`]).

mod candidates;
mod chosen;
mod fits;
pub(crate) mod refit;
mod remembered;
mod rows;
mod scored;
mod work;

pub use candidates::{CandidateInfo, Candidates, Nuisance, OutputInfo};
pub(crate) use chosen::TIE;
pub use chosen::{Findings, search};
pub(crate) use fits::{fit_promising, stands};
pub(crate) use remembered::Remembered;
pub use rows::Rows;
pub use scored::Scored;
pub use work::Work;
