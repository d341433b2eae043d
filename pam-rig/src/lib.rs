//! A virtual rig of the joint that is not the model.
//!
//! The rig makes recordings with known ground truth. Its plant has richer physics than the models that
//! learn it, behind the valves, the servo, the motor and the sensors of the published rig, and phenomena can
//! be hidden in it. It writes raw logs, which are loaded like real ones, and for each log a file with the
//! ground truth that no estimator reads.
//!
//! The crate reads from the bottom up:
//!
//! 1. [`plant`]: two McKibben muscles, their air, their losses, and a joint with dry friction;
//! 2. [`pneumatics`]: reservoir, ISO 6358 valves, the pulse servo;
//! 3. [`sensors`]: motor, encoder, pressure and current sensors, clock; each can be made ideal;
//! 4. [`effects`]: effects of the vocabulary, and phenomena outside it, that can be hidden;
//! 5. [`rig`]: all of it, one sample at a time ([`Rig::tick`]), for closed loops;
//! 6. [`protocol`]: the commanded current and pressures; [`record()`] carries out a run, [`Session`] a folder of runs;
//! 7. [`observables`]: the published numbers of the joint, measured on the rig.
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
mod presets;
pub mod protocol;
pub mod record;
pub mod rig;
pub mod sensors;
pub mod truth;

pub use effects::{Effect, HiddenEffect};
pub use error::RigError;
pub use folder::{Entry, Session};
pub use protocol::{Conditions, Protocol, Run};
pub use record::{Recorded, record};
pub use rig::{Command, Frame, PressureCommand, Rig, RigParameters};
pub use truth::Truth;
