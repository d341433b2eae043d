//! Your own rig: the columns of its files and the dimensions of its joint.
//!
//! A [`RigFile`] is a TOML file that a lab writes once. With it every command and [`open_recordings`] read the lab's own
//! files as [recordings](crate::Recording), and models start from the rig's geometry and data sheet:
//!
//! ```toml
//! name = "elbow"
//!
//! [columns]
//! time = { column = "t", unit = "ms" }
//! displacement = { column = "angle", unit = "deg", sign = -1 }
//! pressure_flexor = { column = "p1", unit = "bar", reference = "gauge" }
//! pressure_extensor = { column = "p2", unit = "bar", reference = "gauge" }
//! force = { column = "i_motor", unit = "A" }
//!
//! [drive]
//! pulley_radius_mm = 20
//! torque_constant_nm_per_a = 0.0255
//! gear_ratio = 36
//!
//! [muscles]
//! radius_mm = 8
//! length_mm = 150
//! braid_angle_deg = 25
//!
//! [joint]
//! mass_kg = 2
//! ```
//!
//! [`RigFile::guess`] writes a first one by looking at a recording.
//!
//! [`open_recordings`]: crate::open_recordings

mod guess;
mod model;
mod read;
mod schema;
pub mod units;

pub use guess::{Guess, GuessedRig};
pub use schema::{
    Air, Column, ColumnKey, Columns, Drive, FileLayout, Filters, JointSheet, Limits, Muscles,
    PressureColumn, RigFile, Zero,
};
