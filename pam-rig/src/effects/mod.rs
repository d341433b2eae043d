//! Phenomena that can be hidden in the rig.
//!
//! Every id of the shared vocabulary of effects can be switched on, alone or with others, and so can
//! phenomena that no vocabulary lists ([`unlisted`]): whoever looks for causes should say of those that
//! it does not know. An effect is a file in the folder of its group with an [`EffectInfo`] (id,
//! parameters with units in their names, limits, one line) and a [`Phenomenon`], plus its line in
//! [`ALL`].
//!
//! Effects come on top of what the rig already does: `coulomb_friction` adds to the gearbox's own, a
//! `pressure_sensor_lag` follows the sensor's own filter, `polytropic_gas` multiplies the exponent of
//! the volume law (and is exactly `P Vⁿ = const` with isothermal air).

pub mod gas;
pub mod mechanics;
pub mod sensing;
pub mod unlisted;

mod spec;

pub use spec::{Effect, EffectError};

use crate::plant::{DryFriction, Plant, PlantParameters, VolumeLaw};

/// Where an effect belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Group {
    /// Forces on the joint.
    Mechanics,
    /// The air.
    Gas,
    /// Motor and sensors.
    Sensing,
    /// Not in the shared vocabulary.
    Unlisted,
}

impl Group {
    /// Whether its effects are in the shared vocabulary.
    #[must_use]
    pub fn is_listed(self) -> bool {
        self != Self::Unlisted
    }

    /// In words.
    #[must_use]
    pub fn label(self) -> &'static str {
        match self {
            Self::Mechanics => "mechanics",
            Self::Gas => "gas",
            Self::Sensing => "actuation and sensing",
            Self::Unlisted => "unlisted",
        }
    }
}

/// A parameter of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ParameterInfo {
    /// Name with its unit.
    pub name: &'static str,
    /// A typical value, taken when the effect is switched on without any parameter.
    pub typical: f64,
    /// What it is when other parameters are given and this one is not; `None` if it must be given.
    pub neutral: Option<f64>,
    /// Smallest and largest sensible value.
    pub limits: [f64; 2],
}

impl ParameterInfo {
    /// A parameter that must be given when any is.
    #[must_use]
    pub const fn new(name: &'static str, typical: f64, limits: [f64; 2]) -> Self {
        Self { name, typical, neutral: None, limits }
    }

    /// A parameter that may be left out.
    #[must_use]
    pub const fn or(self, neutral: f64) -> Self {
        Self { neutral: Some(neutral), ..self }
    }
}

/// An effect that can be switched on.
#[derive(Debug, Clone, Copy)]
pub struct EffectInfo {
    /// Its id.
    pub id: &'static str,
    /// Its group.
    pub group: Group,
    /// What it is, in a line.
    pub what: &'static str,
    /// Its parameters.
    pub parameters: &'static [ParameterInfo],
    /// Makes it from the values of its parameters, in their order.
    pub build: fn(&[f64]) -> Box<dyn Phenomenon>,
}

/// What a phenomenon may change before a run.
#[derive(Debug, Clone, PartialEq)]
pub struct SetUp {
    /// Parameters of the plant.
    pub plant: PlantParameters,
    /// How each gas follows its muscle.
    pub laws: [VolumeLaw; 2],
    /// Dry friction beside the plant's own.
    pub frictions: Vec<DryFriction>,
}

/// Time within a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clock {
    /// Time since the excitation began, s; negative before.
    pub time_s: f64,
    /// Length of a step (in the plant) or of a sample (in observations), s.
    pub step_s: f64,
    /// True air masses when the valves closed, g; `None` while they work.
    pub sealed_g: Option<[f64; 2]>,
}

/// True values on their way to the sensors.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen {
    /// Displacement, mm.
    pub displacement_mm: f64,
    /// Absolute pressures of flexor and extensor, kPa.
    pub pressures_kpa: [f64; 2],
}

/// Something that happens in the rig. Every method has a default that does nothing.
pub trait Phenomenon: Send {
    /// Changes parameters before the run.
    fn set_up(&self, _setup: &mut SetUp) {}

    /// What becomes of the motor's force (N); called once a step of the plant.
    fn actuate(&mut self, _clock: &Clock, force_n: f64) -> f64 {
        force_n
    }

    /// A force on the joint along +x (N); called once a step of the plant.
    fn joint_force_n(&mut self, _clock: &Clock, _plant: &Plant) -> f64 {
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

    /// Changes what the sensors see; called once a sample.
    fn observe(&mut self, _clock: &Clock, _seen: &mut Seen) {}
}

/// All effects, in the order of the vocabulary, then the unlisted ones.
pub const ALL: &[EffectInfo] = &[
    mechanics::coulomb_friction::INFO,
    mechanics::stribeck_friction::INFO,
    mechanics::viscous_damping::INFO,
    mechanics::hysteresis::INFO,
    mechanics::creep::INFO,
    mechanics::constant_load::INFO,
    mechanics::added_inertia::INFO,
    mechanics::backlash::INFO,
    mechanics::cogging::INFO,
    mechanics::tendon_slack::INFO,
    mechanics::stiffness_drift::INFO,
    mechanics::stiffness_scale::INFO,
    gas::leak::INFO,
    gas::polytropic_gas::INFO,
    gas::geometry_coefficient::INFO,
    sensing::force_gain::INFO,
    sensing::force_saturation::INFO,
    sensing::actuation_delay::INFO,
    sensing::pressure_sensor_lag::INFO,
    sensing::pressure_delay::INFO,
    sensing::pressure_bias::INFO,
    sensing::pressure_gain::INFO,
    sensing::position_offset::INFO,
    sensing::position_gain::INFO,
    unlisted::periodic_disturbance::INFO,
    unlisted::chamber_crosstalk::INFO,
    unlisted::tendon_slip::INFO,
    unlisted::sensor_gain_jump::INFO,
    unlisted::encoder_freeze::INFO,
    unlisted::valve_glitch::INFO,
];
