//! Magnitudes at which the studies hide the effects of the vocabulary.

use crate::plant::Hidden;

/// Size of the motion to which thresholds and lengths of effects are scaled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Largest force, N.
    pub force_n: f64,
    /// Largest displacement from the middle, mm.
    pub travel_mm: f64,
}

impl Motion {
    /// The published excitation at medium pressure.
    pub const PUBLISHED: Self = Self { force_n: 200.0, travel_mm: 1.4 };
}

/// How a value follows the strength of its effect.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Scaling {
    /// Proportional to the strength.
    Grows,
    /// Kept.
    Kept,
    /// Kept, and proportional to the travel of the joint.
    Length,
    /// Kept, and proportional to the largest force.
    BelowPeak,
    /// Its difference from one grows.
    FromOne,
    /// Inversely proportional to the strength.
    Falls,
}

/// Label (the id, or the id and a side), id, and values at medium strength.
type Entry = (&'static str, &'static str, &'static [(&'static str, f64, Scaling)]);

use Scaling::{BelowPeak, Falls, FromOne, Grows, Kept, Length};

/// Sizes that a laboratory would want to know of, with the published joint and excitation. Effects of two chambers have
/// one-sided variants.
const ENTRIES: &[Entry] = &[
    ("coulomb_friction", "coulomb_friction", &[("force_n", 12.0, Grows)]),
    (
        "stribeck_friction",
        "stribeck_friction",
        &[("coulomb_n", 8.0, Grows), ("static_n", 20.0, Grows), ("velocity_mm_s", 2.0, Kept)],
    ),
    // 12 N at 45 psi.
    ("load_friction", "load_friction", &[("force_n_per_kpa", 0.04, Grows)]),
    ("viscous_damping", "viscous_damping", &[("coefficient_ns_m", 800.0, Grows)]),
    ("hysteresis", "hysteresis", &[("force_n", 15.0, Grows), ("slip_mm", 0.5, Length)]),
    ("creep", "creep", &[("stiffness_n_mm", 8.0, Grows), ("time_constant_s", 2.0, Kept)]),
    ("constant_load", "constant_load", &[("force_n", 12.0, Grows)]),
    ("added_inertia", "added_inertia", &[("mass_kg", 35.0, Grows)]),
    ("backlash", "backlash", &[("gap_mm", 0.1, Grows)]),
    ("cogging", "cogging", &[("force_n", 7.0, Grows), ("pitch_mm", 0.6, Length)]),
    (
        "tendon_slack",
        "tendon_slack",
        &[("displacement_mm", 0.9, Length), ("stiffness_loss", 0.2, Grows)],
    ),
    ("stiffness_drift", "stiffness_drift", &[("relative_per_min", 0.12, Grows)]),
    ("stiffness_scale", "stiffness_scale", &[("relative", 0.07, Grows)]),
    ("leak", "leak", &[("flexor_rate_per_s", 1.5e-3, Grows), ("extensor_rate_per_s", 7e-4, Grows)]),
    ("leak of the flexor", "leak", &[("flexor_rate_per_s", 1e-3, Grows)]),
    ("leak of the extensor", "leak", &[("extensor_rate_per_s", 1e-3, Grows)]),
    ("polytropic_gas", "polytropic_gas", &[("exponent", 1.2, FromOne)]),
    ("geometry_coefficient", "geometry_coefficient", &[("relative", 0.08, Grows)]),
    ("force_gain", "force_gain", &[("relative", -0.07, Grows)]),
    ("force_saturation", "force_saturation", &[("force_n", 165.0, BelowPeak)]),
    ("actuation_delay", "actuation_delay", &[("delay_ms", 10.0, Grows)]),
    ("actuator_lag", "actuator_lag", &[("cutoff_hz", 8.0, Falls)]),
    ("pressure_sensor_lag", "pressure_sensor_lag", &[("cutoff_hz", 5.0, Falls)]),
    ("pressure_delay", "pressure_delay", &[("delay_ms", 25.0, Grows)]),
    ("position_sensor_lag", "position_sensor_lag", &[("cutoff_hz", 8.0, Falls)]),
    ("position_delay", "position_delay", &[("delay_ms", 20.0, Grows)]),
    (
        "pressure_bias",
        "pressure_bias",
        &[("flexor_kpa", 12.0, Grows), ("extensor_kpa", -8.0, Grows)],
    ),
    ("pressure_bias of the flexor", "pressure_bias", &[("flexor_kpa", 10.0, Grows)]),
    ("pressure_bias of the extensor", "pressure_bias", &[("extensor_kpa", 10.0, Grows)]),
    (
        "pressure_gain",
        "pressure_gain",
        &[("flexor_relative", 0.05, Grows), ("extensor_relative", -0.04, Grows)],
    ),
    ("pressure_gain of the flexor", "pressure_gain", &[("flexor_relative", 0.05, Grows)]),
    ("pressure_gain of the extensor", "pressure_gain", &[("extensor_relative", 0.05, Grows)]),
    ("position_offset", "position_offset", &[("offset_mm", 0.12, Grows)]),
    ("position_gain", "position_gain", &[("relative", 0.04, Grows)]),
];

/// Ids that have a magnitude, with the names of their values.
pub fn known() -> impl Iterator<Item = (&'static str, Vec<&'static str>)> {
    ENTRIES.iter().map(|e| (e.1, e.2.iter().map(|v| v.0).collect()))
}

/// Labels of the variants of the effects that the vocabulary has.
#[must_use]
pub fn labels() -> Vec<&'static str> {
    let known = |id: &str| pam_vocabulary::by_id(id).is_ok();
    ENTRIES.iter().filter(|e| known(e.1)).map(|e| e.0).collect()
}

/// Effects outside the vocabulary, as the studies hide them.
#[must_use]
pub fn unlisted() -> Vec<Hidden> {
    vec![
        Hidden::new("periodic_disturbance", &[("force_n", 12.0), ("frequency_hz", 1.37)]),
        Hidden::new("chamber_crosstalk", &[("rate_per_s", 4e-3)]),
        Hidden::new("tendon_slip", &[("time_s", 9.0), ("slip_mm", 0.4)]),
        Hidden::new("sensor_gain_jump", &[("time_s", 8.0), ("relative", 0.06)]),
        Hidden::new("encoder_freeze", &[("period_s", 3.3), ("duration_s", 0.3)]),
        Hidden::new("valve_glitch", &[("time_s", 9.0), ("mass_mg", 6.0)]),
    ]
}

/// A variant at a multiple of its medium strength; values without a natural zero move towards their stronger side.
///
/// # Panics
/// If there is no variant of this label.
#[must_use]
pub fn scaled(label: &str, strength: f64, motion: &Motion) -> Hidden {
    let (_, id, values) = ENTRIES.iter().find(|e| e.0 == label).expect("a label of the list");
    let reference = Motion::PUBLISHED;
    let values: Vec<(&str, f64)> = values
        .iter()
        .map(|&(name, value, scaling)| {
            let value = match scaling {
                Grows => value * strength,
                Kept => value,
                Length => value * motion.travel_mm / reference.travel_mm,
                BelowPeak => {
                    let below = strength * (1.0 - value / reference.force_n);
                    motion.force_n * (1.0 - below.min(0.9))
                }
                FromOne => 1.0 + (value - 1.0) * strength,
                Falls => value / strength,
            };
            (name, value)
        })
        .collect();
    within_range(Hidden::new(id, &values))
}

/// The effect at medium strength or a multiple, with the published motion.
#[must_use]
pub fn at_strength(label: &str, strength: f64) -> Hidden {
    scaled(label, strength, &Motion::PUBLISHED)
}

/// Values inside the ranges of the vocabulary.
fn within_range(mut hidden: Hidden) -> Hidden {
    if let Ok(info) = pam_vocabulary::by_id(&hidden.id) {
        for p in info.parameters {
            if let Some(value) = hidden.values.get_mut(p.name) {
                *value = value.clamp(p.range[0], p.range[1]);
            }
        }
    }
    hidden
}
