//! Supply, valves and the pulse servo.

pub mod servo;
pub mod supply;
pub mod valve;

pub use servo::{Servo, ServoParameters};
pub use supply::{Supply, SupplyParameters};
pub use valve::{AirState, Opening, Valve, ValveFlow, ValveParameters, iso_6358_flow_g_s};

use serde::{Deserialize, Serialize};

/// Parameters of the pneumatics.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PneumaticsParameters {
    /// The reservoir.
    pub supply: SupplyParameters,
    /// The valves of each muscle.
    pub valve: ValveParameters,
    /// The servo.
    pub servo: ServoParameters,
}
