//! Effects as parts of a model: one file each, generic over the scalar.
//!
//! An [`Effect`] hooks into the joint where it acts: on the commanded force, in the balance of
//! forces, in the air, on what the sensors show. The hooks that an effect does not need have neutral
//! defaults. Everything is written once over [`Scalar`] and runs with plain numbers, with chunks of
//! derivatives, and on tapes ([`EffectScalar`]).
//!
//! **Memory.** Friction, loops and creep remember. An effect keeps what it remembers in `memory`,
//! which is constant during a step of the simulation and moved by [`Effect::advance`] after it; forces
//! inside a step are evaluated from the memory at its start and the way since.
//!
//! **A new effect** is a type with [`Effect`] in a file of its own, a line in its group's `mod.rs`, and a line
//! in the list of [`ALL`]. Its [`EffectInfo`] is the entry of the vocabulary ([`entry`]), or its own if the
//! vocabulary does not have it. An effect of another crate is passed to the diagnosis as a candidate, or gets known by
//! its id everywhere with [`register`]. An effect of a line or two needs no type: it is [an
//! expression](crate::expression) in a file. Any effect may begin, end or grow at a time: [`timed`].

mod before;
mod dynamic;
mod gas;
mod hook_list;
mod hooks;
mod mechanics;
mod own;
mod scales;
mod sensing;
mod timed;

pub use before::{Before, MeasuredPoint};
pub use dynamic::{
    AnyEffect, Derivatives, EffectHooks, EffectScalar, FewDerivatives, ManyDerivatives, NARROW,
    WIDE, WIDTH,
};
pub use hook_list::Hooks;
pub use hooks::{
    Absorbed, Air, ChamberLaw, Command, Effect, FixedState, MemoryStart, Observed, Point, Rest,
    Restoring, StepStart,
};
pub use own::{all, register, registered};
pub use pam_vocabulary::{
    ActivityWindow, EffectInfo, Group, ParameterInfo, Switch, VocabularyError, entry,
};
pub use scales::{DataScales, ScaleSample};
pub use timed::{Timed, timed};

pub(crate) use sensing::delayed;

#[cfg(doc)]
use pam_core::Scalar;

macro_rules! effects {
    ($($group:ident::$module:ident::$effect:ident),+ $(,)?) => {
        $(pub use $group::$module::$effect;)+

        /// Every built-in effect: those of the vocabulary ([`pam_vocabulary`]) in its order, and any further ones.
        /// [`all`] has those of other crates besides.
        pub static ALL: &[&dyn AnyEffect] = &[$(&$effect),+];
    };
}

effects! {
    mechanics::coulomb_friction::CoulombFriction,
    mechanics::stribeck_friction::StribeckFriction,
    mechanics::load_friction::LoadFriction,
    mechanics::viscous_damping::ViscousDamping,
    mechanics::hysteresis::Hysteresis,
    mechanics::creep::Creep,
    mechanics::constant_load::ConstantLoad,
    mechanics::added_inertia::AddedInertia,
    mechanics::backlash::Backlash,
    mechanics::cogging::Cogging,
    mechanics::tendon_slack::TendonSlack,
    mechanics::stiffness_drift::StiffnessDrift,
    mechanics::stiffness_scale::StiffnessScale,
    gas::leak::Leak,
    gas::polytropic_gas::PolytropicGas,
    gas::geometry_coefficient::GeometryCoefficient,
    sensing::force_gain::ForceGain,
    sensing::force_saturation::ForceSaturation,
    sensing::actuation_delay::ActuationDelay,
    sensing::actuator_lag::ActuatorLag,
    sensing::pressure_sensor_lag::PressureSensorLag,
    sensing::pressure_delay::PressureDelay,
    sensing::pressure_bias::PressureBias,
    sensing::pressure_gain::PressureGain,
    sensing::position_offset::PositionOffset,
    sensing::position_gain::PositionGain,
    sensing::position_sensor_lag::PositionSensorLag,
    sensing::position_delay::PositionDelay,
}

/// The effect with this id: a built-in one, or one that was [registered](register).
#[must_use]
pub fn by_id(id: &str) -> Option<&'static dyn AnyEffect> {
    ALL.iter().copied().chain(registered()).find(|e| e.info().id == id)
}
