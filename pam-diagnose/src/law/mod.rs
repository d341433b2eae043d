//! From a correction to a law: a few terms with numbers and units in place of many without names.
//!
//! 1. **Screening.** About the correction, the system answers small changes linearly. What every term of a library would do
//!    to the outputs is one column: powers, products, bends, saturations, decays and low-passes of all variables, at a few
//!    scales each. Sums of one to three columns that do what the correction does are put together by a beam search, by their
//!    least squares and the length of their description (Rissanen 1978; sparse regression as in Brunton, Proctor and Kutz 2016,
//!    but on responses of the simulation in place of derivatives of data).
//! 2. **Refinement.** The best sums of each length are fitted through the simulation with all of their numbers: coefficients,
//!    scales and time constants. A force that saturates in the velocity is tried as set-valued dry friction as well. Validation
//!    data and description length rank them.
//! 3. **Neighbours.** The best laws of one and two terms are varied: the function, the variable or the memory of one factor is
//!    replaced, or one factor removed or added. What each variant would do is screened about the law, and the best are fitted. This
//!    step does not use the correction, which may lack the right term.
//! 4. **Rounds.** About the best law so far, the library and the products of its terms with further factors are screened
//!    anew, until nothing better turns up.
//! 5. **The shortest law** that leaves nearly as little in every channel is refitted to training and validation data, without terms
//!    that these data do not support. It replaces the correction if it achieves most of the correction's error reduction or is at least
//!    as probable, and the test set confirms it.

mod conclude;
mod data;
mod design;
mod find;
mod fitted;
mod library;
mod neighbours;
mod picture;
mod prune;
mod refine;
mod result;
mod screen;
mod select;
mod vary;
mod written;

pub(crate) use data::Data;
pub(crate) use design::Design;
#[cfg(feature = "laws")]
pub(crate) use find::{NOTHING_LEFT, rest};
pub use picture::{Picture, PicturePoint, Plane, PlaneCell};
pub use result::{Law, RankedLaw, Replaced};
pub(crate) use select::Scores;
