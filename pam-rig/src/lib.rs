//! A virtual rig of the joint that is not the model.
//!
//! Measured data whose truth is known: a plant whose physics is richer than the models that learn it,
//! behind the valves, the servo, the motor and the sensors of the published rig, with phenomena that can
//! be hidden in it. What it writes are raw logs, which enter through the same door as real ones, and
//! beside them a sealed truth that no estimator reads.
//!
//! The crate reads from the bottom up:
//!
//! 1. [`plant`]: two McKibben muscles, their air, their losses, and a joint with dry friction;
//! 2. [`pneumatics`]: reservoir, ISO 6358 valves, the pulse servo;
//! 3. [`sensors`]: motor, encoder, pressure and current sensors, clock; each can be made ideal;
//! 4. [`effects`]: what can be hidden, from the shared vocabulary and beyond it;
//! 5. [`rig`]: all of it, one sample at a time ([`Rig::tick`]), for closed loops;
//! 6. [`protocol`]: what is done to it; [`record()`] carries a run out, [`Session`] a folder of them;
//! 7. [`observables`]: what is published about the joint, measured here.
//!
//! It shares units and file formats with the other crates, and no force code.
//!
//! ```
//! use pam_rig::{Effect, Protocol, RigParameters, record};
//!
//! let mut rig = RigParameters::default();
//! rig.effects.push("coulomb_friction:force_n=25".parse()?);
//! let mut protocol = Protocol::paper();
//! protocol.current.truncate(1);
//! let runs = protocol.runs()?;
//! let recorded = record(&rig, &protocol, &runs[0], 1)?;
//! assert_eq!(recorded.rows.len(), recorded.truth.rows.len());
//! # Ok::<(), pam_rig::RigError>(())
//! ```

mod check;
pub mod effects;
pub mod error;
pub mod folder;
pub mod observables;
pub mod plant;
pub mod pneumatics;
pub mod protocol;
pub mod record;
pub mod rig;
pub mod sensors;
mod toml_file;
pub mod truth;

pub use effects::{Effect, HiddenEffect};
pub use error::RigError;
pub use folder::{Entry, Session};
pub use protocol::{Conditions, Protocol, Run};
pub use record::{Recorded, record};
pub use rig::{Command, Frame, PressureCommand, Rig, RigParameters};
pub use truth::Truth;
