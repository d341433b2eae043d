//! Effects as parts of a model: one file each, generic over the scalar.
//!
//! An [`Effect`] hooks into the joint where it acts: on the commanded force, in the balance of
//! forces, in the air, on what the sensors show. The hooks that an effect does not need have neutral
//! defaults. Everything is written once over [`Scalar`] and runs with plain numbers and with chunks of
//! derivatives ([`EffectScalar`]).
//!
//! **Memory.** Friction, loops and creep remember. An effect keeps what it remembers in `memory`,
//! which is constant during a step of the simulation and moved by [`Effect::advance`] after it; forces
//! inside a step are evaluated from the memory at its start and the way since.
//!
//! **A new effect** is a type with [`Effect`] in a file of its own, and a line in [`ALL`]; from another
//! crate it is handed to [`crate::Options::candidates`] beside these.

mod evidence;
mod gas;
mod hooks;
mod info;
mod mechanics;
mod over;
mod sensing;

pub use evidence::{Evidence, EvidenceSample};
pub use gas::{GeometryCoefficient, Leak, PolytropicGas};
pub use hooks::{Absorbed, ChamberLaw, Effect, Observed, Point, Rest, Restoring};
pub use info::{EffectInfo, Group, ParameterInfo};
pub use mechanics::{
    AddedInertia, Backlash, Cogging, ConstantLoad, CoulombFriction, Creep, Hysteresis,
    StiffnessDrift, StiffnessScale, StribeckFriction, TendonSlack, ViscousDamping,
};
pub use over::{AnyEffect, Derivatives, EffectOver, EffectScalar, WIDTH};
pub use sensing::{
    ActuationDelay, ForceGain, ForceSaturation, PositionGain, PositionOffset, PressureBias,
    PressureDelay, PressureGain, PressureSensorLag,
};

#[cfg(doc)]
use pam_core::Scalar;

/// Every effect of the vocabulary, in its order.
pub static ALL: &[&dyn AnyEffect] = &[
    &CoulombFriction,
    &StribeckFriction,
    &ViscousDamping,
    &Hysteresis,
    &Creep,
    &ConstantLoad,
    &AddedInertia,
    &Backlash,
    &Cogging,
    &TendonSlack,
    &StiffnessDrift,
    &StiffnessScale,
    &Leak,
    &PolytropicGas,
    &GeometryCoefficient,
    &ForceGain,
    &ForceSaturation,
    &ActuationDelay,
    &PressureSensorLag,
    &PressureDelay,
    &PressureBias,
    &PressureGain,
    &PositionOffset,
    &PositionGain,
];

/// The effect with this id.
#[must_use]
pub fn by_id(id: &str) -> Option<&'static dyn AnyEffect> {
    ALL.iter().find(|e| e.info().id == id).copied()
}
