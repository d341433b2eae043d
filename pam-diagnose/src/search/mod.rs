//! Which effects explain the residual: every candidate refitted through the simulation, alone and beside
//! others, and held against recordings that took no part.

mod chance;
mod constancy;
mod explore;
mod floors;
mod forward;
mod reference;
mod scales;
mod settle;
mod split;

pub use chance::Chance;
pub use constancy::Constancy;
pub use explore::{Scored, Search};
pub use floors::noise_floors;
pub use forward::{Acceptance, Findings};
pub use reference::Reference;
pub use scales::gather;
pub use settle::Settled;
pub use split::Split;
