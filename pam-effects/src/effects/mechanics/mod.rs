//! Effects in the balance of forces.

pub(super) mod added_inertia;
pub(super) mod backlash;
pub(super) mod cogging;
pub(super) mod constant_load;
pub(super) mod coulomb_friction;
pub(super) mod creep;
pub(super) mod hysteresis;
pub(super) mod load_friction;
pub(super) mod stiffness_drift;
pub(super) mod stiffness_scale;
pub(super) mod stribeck_friction;
pub(super) mod tendon_slack;
pub(super) mod viscous_damping;
