//! Effects in the balance of forces.

mod added_inertia;
mod backlash;
mod cogging;
mod constant_load;
mod coulomb_friction;
mod creep;
mod hysteresis;
mod stiffness_drift;
mod stiffness_scale;
mod stribeck_friction;
mod tendon_slack;
mod viscous_damping;

pub use added_inertia::AddedInertia;
pub use backlash::Backlash;
pub use cogging::Cogging;
pub use constant_load::ConstantLoad;
pub use coulomb_friction::CoulombFriction;
pub use creep::Creep;
pub use hysteresis::Hysteresis;
pub use stiffness_drift::StiffnessDrift;
pub use stiffness_scale::StiffnessScale;
pub use stribeck_friction::StribeckFriction;
pub use tendon_slack::TendonSlack;
pub use viscous_damping::ViscousDamping;
