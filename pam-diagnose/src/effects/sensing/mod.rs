//! Effects between command and force, and between joint and record.

mod actuation_delay;
mod force_gain;
mod force_saturation;
mod position_gain;
mod position_offset;
mod pressure_bias;
mod pressure_delay;
mod pressure_gain;
mod pressure_sensor_lag;

pub use actuation_delay::ActuationDelay;
pub use force_gain::ForceGain;
pub use force_saturation::ForceSaturation;
pub use position_gain::PositionGain;
pub use position_offset::PositionOffset;
pub use pressure_bias::PressureBias;
pub use pressure_delay::PressureDelay;
pub use pressure_gain::PressureGain;
pub use pressure_sensor_lag::PressureSensorLag;
