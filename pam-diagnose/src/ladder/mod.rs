//! Ladders: models of one phenomenon, from a short one to a rich one, fitted to the same data.
//!
//! A diagnosis asks which of many different causes is at work. A ladder asks how much of one cause the data can tell: dry and
//! viscous friction only, or one that is higher near rest, grows with the load, differs between the sides, … Every rung is fitted
//! through the simulation, from its own starting values and from every rung before that shares parameters with it by name, so
//! that a rung that holds another is never worse. Noise, priors and rows are those of a diagnosis.
//!
//! The table has, for each rung,
//!
//! * its parameters with 95 % intervals,
//! * the **description length** `L = (−ln p(data | θ̂) − ln p(nuisances) + ½ p ln n) / ln 2` bits, relative to the shortest
//!   (Rissanen 1978; half of Schwarz's criterion), with the noise that is learned beside the best rung,
//! * the error on the **test set**, which no fit has seen, with the interval of its reduction.
//!
//! The shortest description is the rung that the data support. [`joint_ladder`](crate::joint::joint_ladder) climbs the friction
//! models M1 to M6 of a geared drive, or any list of effects; [`field_ladder`](crate::field::field_ladder) any list of sets of
//! terms of a field.

mod climb;
#[cfg(feature = "report")]
mod report;
mod table;

pub use climb::{RungModel, climb};
#[cfg(feature = "report")]
pub(crate) use report::section;
pub use table::{Ladder, Rung, RungError};
