//! Effects in the mechanics.

pub mod added_inertia;
pub mod backlash;
pub mod cogging;
pub mod constant_load;
pub mod coulomb_friction;
pub mod creep;
pub mod hysteresis;
pub mod load_friction;
pub mod stiffness_drift;
pub mod stiffness_scale;
pub mod stribeck_friction;
pub mod tendon_slack;
pub mod viscous_damping;
