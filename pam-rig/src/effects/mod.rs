//! Phenomena that can be hidden in the rig.
//!
//! The rig can hide every effect of the vocabulary ([`pam_vocabulary`]), alone or with others, and
//! phenomena outside it ([`unlisted`]), which a diagnosis should leave unnamed. An effect is a file in the
//! folder of its group with a [`Phenomenon`] and a [`HiddenEffect`], which refers to the entry of the
//! vocabulary, and a line in [`ALL`]; or a few lines of TOML, [an expression](expression). Any of them may begin, end or grow at
//! a time: `onset_s`, `end_s` and `ramp_s` stand beside its parameters ([`pam_vocabulary::course`]).
//!
//! Effects act in addition to the rig's own imperfections: `coulomb_friction` adds to the gearbox's
//! friction, `pressure_sensor_lag` precedes the sensor's own filter, `polytropic_gas` multiplies the
//! exponent of the volume law (with isothermal air the pressure follows exactly `P Vⁿ = const`).

pub mod expression;
pub mod gas;
pub mod mechanics;
pub mod sensing;
pub mod unlisted;

mod spec;
mod timed;

pub use pam_vocabulary::{EffectInfo, Group, ParameterInfo};
pub use spec::{Effect, VocabularyError};

use crate::plant::{DryFriction, Plant, PlantParameters, VolumeLaw};
use pam_vocabulary::entry;

/// An effect that the rig can hide.
#[derive(Debug, Clone, Copy)]
pub struct HiddenEffect {
    /// The entry of the vocabulary, or the description of an unlisted phenomenon.
    pub info: &'static EffectInfo,
    /// Typical values of the parameters, used if an effect is switched on without any parameter.
    pub typical: &'static [f64],
    /// Builds the phenomenon from the values of the parameters, in their order.
    pub build: fn(&[f64]) -> Box<dyn Phenomenon>,
}

impl HiddenEffect {
    /// `true` for an effect of the vocabulary, `false` for an unlisted phenomenon.
    #[must_use]
    pub fn is_listed(&self) -> bool {
        pam_vocabulary::ALL.iter().any(|e| e.id == self.info.id)
    }

    /// The value of a parameter that is left out while others are given; `None` if it must be given.
    ///
    /// Parameters may be left out if each of them makes the effect alone: a `leak` with one rate leaves the
    /// other chamber tight.
    #[must_use]
    pub fn neutral(&self, parameter: &ParameterInfo) -> Option<f64> {
        let parameters = self.info.parameters;
        let independent = parameters.len() > 1 && parameters.iter().all(|p| p.off.is_some());
        parameter.off.filter(|_| independent)
    }
}

/// Properties of the rig that a phenomenon may change before a run.
#[derive(Debug, Clone, PartialEq)]
pub struct SetUp {
    /// Parameters of the plant.
    pub plant: PlantParameters,
    /// How each gas follows its muscle.
    pub laws: [VolumeLaw; 2],
    /// Dry friction in addition to the plant's own.
    pub frictions: Vec<DryFriction>,
}

/// Time within a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clock {
    /// Time since the excitation began, s; negative before.
    pub time_s: f64,
    /// Length of a step of the plant, or of a sample in observations, s.
    pub step_s: f64,
    /// True air masses when the valves closed, g; `None` while they work.
    pub sealed_g: Option<[f64; 2]>,
}

/// True values before the sensors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Displacement, mm.
    pub displacement_mm: f64,
    /// Absolute pressures of flexor and extensor, kPa.
    pub pressures_kpa: [f64; 2],
}

/// A phenomenon in the rig. The default of every method has no effect.
pub trait Phenomenon: Send {
    /// The share of it that is there at a time, s since the excitation began.
    fn share(&self, _time_s: f64) -> f64 {
        1.0
    }

    /// Changes parameters before the run.
    fn set_up(&self, _setup: &mut SetUp) {}

    /// The force on the joint for a force of the motor, N. Called once per step of the plant.
    fn actuate(&mut self, _clock: &Clock, force_n: f64) -> f64 {
        force_n
    }

    /// A force on the joint along +x, N. Called once per step of the plant.
    fn joint_force_n(&mut self, _clock: &Clock, _plant: &Plant) -> f64 {
        0.0
    }

    /// Dry friction in addition to that of [`SetUp::frictions`], at rest and while sliding, N. Called once per
    /// step of the plant.
    fn dry_friction_n(&self, _clock: &Clock, _plant: &Plant) -> f64 {
        0.0
    }

    /// A factor of the muscles' net force.
    fn muscle_scale(&self, _clock: &Clock) -> f64 {
        1.0
    }

    /// Air that enters flexor and extensor in a step, g.
    fn air_g(&mut self, _clock: &Clock, _plant: &Plant) -> [f64; 2] {
        [0.0; 2]
    }

    /// Changes the values that the sensors see. Called once per sample.
    fn observe(&mut self, _clock: &Clock, _seen: &mut Seen) {}
}

/// All effects in the order of the vocabulary, then the unlisted phenomena.
pub const ALL: &[HiddenEffect] = &[
    mechanics::coulomb_friction::EFFECT,
    mechanics::stribeck_friction::EFFECT,
    mechanics::load_friction::EFFECT,
    mechanics::viscous_damping::EFFECT,
    mechanics::hysteresis::EFFECT,
    mechanics::creep::EFFECT,
    mechanics::constant_load::EFFECT,
    mechanics::added_inertia::EFFECT,
    mechanics::backlash::EFFECT,
    mechanics::cogging::EFFECT,
    mechanics::tendon_slack::EFFECT,
    mechanics::stiffness_drift::EFFECT,
    mechanics::stiffness_scale::EFFECT,
    gas::leak::EFFECT,
    gas::polytropic_gas::EFFECT,
    gas::geometry_coefficient::EFFECT,
    sensing::force_gain::EFFECT,
    sensing::force_saturation::EFFECT,
    sensing::actuation_delay::EFFECT,
    sensing::actuator_lag::EFFECT,
    sensing::pressure_sensor_lag::EFFECT,
    sensing::pressure_delay::EFFECT,
    sensing::pressure_bias::EFFECT,
    sensing::pressure_gain::EFFECT,
    sensing::position_offset::EFFECT,
    sensing::position_gain::EFFECT,
    sensing::position_sensor_lag::EFFECT,
    sensing::position_delay::EFFECT,
    unlisted::periodic_disturbance::EFFECT,
    unlisted::chamber_crosstalk::EFFECT,
    unlisted::tendon_slip::EFFECT,
    unlisted::sensor_gain_jump::EFFECT,
    unlisted::encoder_freeze::EFFECT,
    unlisted::valve_glitch::EFFECT,
];
