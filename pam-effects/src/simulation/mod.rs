//! The extended joint, simulated fast enough to fit hundreds of candidates.
//!
//! A [`ResampledRecord`] is a recording made ready: its force on a uniform grid, its measured channels, its
//! reading at rest. A [`Trial`] has the base model's force besides, tabulated at its sealed masses over (x, ẋ)
//! as a [`ForceTable`]. With
//! frozen weights and sealed air the network is a function of two numbers, so a table costs a few
//! nanoseconds where the network costs hundreds, and carries derivatives as easily.
//!
//! [`simulate`] marches a trial with any effects over any [`EffectScalar`](crate::effects::EffectScalar):
//! Runge–Kutta steps of fourth order for the smooth part, and dry friction as a set-valued force that
//! holds the joint exactly still (Moreau's time stepping).

mod gas;
mod input;
pub(crate) mod integrator;
mod record;
mod run;
mod table;
mod trial;

pub use gas::Chambers;
pub use input::FineForce;
pub use record::{RecordSource, ResampledRecord};
pub(crate) use run::observe;
pub use run::{Base, Diverged, Nuisances, Trajectory, simulate};
pub use table::{Air, ForceTable};
pub use trial::Trial;
pub(crate) use trial::range_of;
