//! Simulation of the extended joint, fast enough to fit hundreds of candidates.
//!
//! A [`ResampledRecord`] holds the force of a recording on a uniform grid, its measured channels and its reading at
//! rest. A [`Trial`] adds the base model's force, tabulated at the recording's sealed masses over (x, ẋ) as a
//! [`ForceTable`]: with frozen weights and sealed air the network is a function of two numbers, so a table costs a
//! few nanoseconds where the network costs hundreds, and carries derivatives as easily.
//!
//! [`simulate`] integrates a trial with any effects over any [`EffectScalar`](crate::effects::EffectScalar):
//! Runge–Kutta steps of fourth order, as short as stability and accuracy ask, and dry friction as a set-valued force
//! that holds the joint exactly still, with steps cut where the joint turns, stops or breaks away.

pub(crate) mod base;
mod before;
mod friction;
mod gas;
mod gas_table;
mod halving;
mod input;
pub(crate) mod integrator;
pub(crate) mod measured;
mod nuisances;
pub(crate) mod observation;
pub(crate) mod parts;
mod record;
mod run;
pub(crate) mod spectrum;
mod start;
pub(crate) mod steps;
mod substep;
mod table;
mod trajectory;
mod trial;

pub use base::Base;
pub use gas::Chambers;
pub use input::FineForce;
pub use nuisances::Nuisances;
pub use record::{RecordSource, ResampledRecord, TooLong};
pub use run::{SimulationScalar, motion_until, needed_substeps, sensed, simulate, simulate_until};
pub use start::StartVelocity;
pub use table::{Air, ForceTable};
pub use trajectory::{Diverged, Trajectory};
pub use trial::Trial;
pub(crate) use trial::range_of;
