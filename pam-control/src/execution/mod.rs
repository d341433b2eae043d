//! Plans carried out on a joint, sample by sample.
//!
//! A [`Joint`] is anything that takes a command and gives a reading once a millisecond: the virtual rig
//! (in the `pam` command), hardware, or the model itself ([`ModelJoint`]). [`follow()`] lets the joint's own pressure servo track a table of
//! [`Commands`]; [`perturb`] does the same and, at given times, shuts the valves and pushes.

mod commands;
mod follow;
mod model_joint;
mod perturb;

pub use commands::Commands;
pub use follow::{Followed, follow};
pub use model_joint::ModelJoint;
pub use perturb::{Pulse, PulseRecord, PulseShape, perturb};

/// Time between samples, s.
pub const SAMPLE_S: f64 = 1e-3;

/// State of a pair of valves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Valve {
    /// Both shut.
    #[default]
    Shut,
    /// Air from the supply flows in.
    Inflate,
    /// Air flows out into the room.
    Exhaust,
}

/// Command to the air during a sample, flexor before extensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Air {
    /// All valves shut.
    Sealed,
    /// The joint's servo drives the muscles to these pressures, kPa absolute.
    Servo([f64; 2]),
    /// The valves are driven by hand.
    Valves([Valve; 2]),
}

/// A command for one sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointCommand {
    /// Force of the motor along +x, N.
    pub force_n: f64,
    /// The air.
    pub air: Air,
}

/// Readings of the sensors before a command is carried out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Displacement, mm.
    pub displacement_mm: f64,
    /// Pressures of flexor and extensor, kPa absolute.
    pub pressures_kpa: [f64; 2],
}

/// A joint that can be commanded.
pub trait Joint {
    /// Reads the sensors, then carries the command out for a millisecond.
    fn tick(&mut self, command: &JointCommand) -> Reading;
}

impl<J: Joint + ?Sized> Joint for &mut J {
    fn tick(&mut self, command: &JointCommand) -> Reading {
        (**self).tick(command)
    }
}

impl<J: Joint + ?Sized> Joint for Box<J> {
    fn tick(&mut self, command: &JointCommand) -> Reading {
        (**self).tick(command)
    }
}
