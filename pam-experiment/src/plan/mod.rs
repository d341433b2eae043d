//! Recordings that nobody has measured yet: a protocol, carried out by the model.
//!
//! [`PlannedRun`]s follow from a protocol of the rig; [`PlannedRun::simulated`] is what the model predicts for one, and
//! [`measured`] what the sensors of a rig would show of it. [`Synthesis`] puts effects into recordings.

mod noise_file;
mod run;
mod sensors;
mod synthesis;

pub use noise_file::noise_from_toml;
pub use run::{PlannedRun, planned_runs};
pub use sensors::{LOADER_HZ, SensorView, measured, sensor_view};
pub use synthesis::Synthesis;
