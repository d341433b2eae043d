//! The study of the diagnosis: a design of cases, their data, their outcomes and what they add up to.
//!
//! | file | content |
//! |---|---|
//! | `case` | a case: kind, factors, what is hidden |
//! | `design` | the seeded design of the full study |
//! | `rows` | single cases that once went wrong, each with what must hold |
//! | `model` | models that are off by a given amount |
//! | `data` | the recordings of a case |
//! | `detection` | size of what is hidden, relative to the limit of detection |
//! | `nuisances` | nuisance parameters with their tolerances, and their projection out of a residual |
//! | `rig` | the same for recordings of the virtual rig |
//! | `outcome` | what the diagnosis said of a case |
//! | `store` | a folder of outcomes |
//! | `criteria` | counts with exact binomial limits |
//! | `tables` | the tables of a folder of outcomes |

pub mod case;
pub mod criteria;
pub mod data;
pub mod design;
pub mod detection;
pub mod model;
pub mod nuisances;
pub mod outcome;
pub mod rig;
pub mod rows;
pub mod store;
pub mod tables;

pub use case::{Case, Factors, Fault, Kind, ModelError, Shape, Source, Strength};
pub use outcome::Outcome;
