//! The joint: geometry, gas, mechanics, and the hybrid vector field that joins them.

mod field;
mod gas;
mod geometry;
mod masses;
mod model;
mod parameters;

pub use field::{Chambers, JointField};
pub use gas::{closed_pressure_rate, pressure_rate, sealed_mass_g, sealed_pressure_kpa};
pub use geometry::{MuscleGeometry, MuscleVolumes};
pub use masses::SealedMasses;
pub use model::JointModel;
pub use parameters::{PhysicalParameters, RawParameters};

/// Index of the displacement x (mm) in the joint's state.
pub const X: usize = 0;
/// Index of the velocity ẋ (mm/s) in the joint's state.
pub const V: usize = 1;
/// Index of the flexor pressure P_f (kPa absolute) in the joint's state.
pub const PF: usize = 2;
/// Index of the extensor pressure P_e (kPa absolute) in the joint's state.
pub const PE: usize = 3;
/// Index of the flexor's air mass (g) in the state of a joint with open valves.
pub const MF: usize = 4;
/// Index of the extensor's air mass (g) in the state of a joint with open valves.
pub const ME: usize = 5;
